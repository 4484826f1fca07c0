//! Thermal anemometer heads (constant-temperature anemometry): quiescent-gas network, calibration
//! in known winds, and wind from recordings, with the board's own arithmetic.
//!
//! ```no_run
//! use std::path::Path;
//!
//! use anemometry::head::Head;
//! use anemometry::wind::{WindEstimation, WindOptions};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let head = Head::read(Path::new("head.toml"))?;
//! let options = WindOptions::default();
//! let mut estimation = WindEstimation::new(Path::new("winds.parquet"), &head, &options, None)?;
//! while let Some(estimate) = estimation.next_estimate()? {
//!     println!("{} s: {} m/s", estimate.moment.time_s, estimate.sample.speed_m_s);
//! }
//! println!("{}", estimation.report());
//! # Ok(())
//! # }
//! ```
//!
//! | module | holds |
//! |---|---|
//! | [`head`] | head files: elements, limits, calibration |
//! | [`network`] | self-heating and cross-heating of the elements in quiescent gas |
//! | [`calibrate`] | from readings in known winds to a calibrated head |
//! | [`current_ratio`] | ratio of the two currents of an element, from its ticks |
//! | [`wind`] | wind estimates of a recording, and their errors |
//! | [`meteorology`] | means, gusts, turbulence and fluxes by intervals |
//! | [`gas`], [`gas_law`] | properties of carbon dioxide and air, and as polynomials for the board |
//! | [`vector`] | scalar product, length, angle |

pub mod calibrate;
pub mod combine;
pub mod current_ratio;
pub mod gas;
pub mod gas_law;
pub mod head;
pub mod meteorology;
pub mod network;
pub mod vector;
pub mod wind;
