//! Diffusive models of any heated body: identify, validate, reduce, export, analyse, predict,
//! design.
//!
//! A diffusive model is the thermal impedance Z_th of a body as a sum of relaxations on a
//! logarithmic grid of rates (diffusive mesh), with one thermal resistance per rate: a
//! time-constant spectrum (diffusive symbol). One heating power leads to one temperature:
//!
//! ```text
//! dx_k/dt = ξ_k (u − x_k),    T = offset + Σ_k R_k x_k        u in W, ξ_k in rad/s, R_k in K/W
//! ```
//!
//! From an open-loop model the closed loop of constant-temperature operation (CTA) is known before
//! it is built: whether it can hold a set-point, what power it takes, and how fast that power
//! answers.
//!
//! ```
//! use diffusive::model::{Model, PairClass, export::structure_function};
//! use diffusive::predict::analysis_report::{AnalysisReport, AnalysisRequest};
//!
//! let path = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/hot_film.json");
//! let model = Model::read(path.as_ref())?;
//! let part = PairClass::find(&model, None, Some("calm"))?;
//! let steps = structure_function(&part.pair.mesh_rad_s, &part.class.r_k_per_w)?;
//! assert_eq!(steps.len(), 4); // Σ R in K/W and Σ C in J/K outwards from the heater, one a rate
//!
//! let request = AnalysisRequest { target_k: Some(20.0), ..AnalysisRequest::default() };
//! let report = AnalysisReport::new(&model, &request)?; // prints as text, serialises to JSON
//! assert_eq!(report.analysis.is_reachable(), Some(true));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | module | holds |
//! |---|---|
//! | [`identify`] | models from records, with standard errors; validation against another record |
//! | [`model`] | the model as a file; merging, reducing, exporting (Foster, Cauer, SPICE, response, C, Rust) |
//! | [`predict`] | closed loops from a model: sliding surface, zeros, reaching, whole experiments |
//! | [`design`] | levels, sample period and set-point of a loop from requirements |
//! | [`optimise`] | the damped descent behind every search |
//! | [`random`] | normal random numbers with the same bits on every system |
//!
//! Feature `testing`: small models ([`model::testing`](model)) and measured records
//! (`shared_data`) for the tests of other crates.

#[macro_use]
mod macros;

pub mod design;
pub mod identify;
pub mod model;
pub mod optimise;
pub mod predict;
pub mod random;
#[cfg(any(test, feature = "testing"))]
pub mod shared_data;
