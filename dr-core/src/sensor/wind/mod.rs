//! From what the parts of a heated sphere, or the dice of a heated card, lose to the wind vector.
//!
//! | file | what |
//! |---|---|
//! | [`gas`] | what of the gas matters: density, viscosity, conductivity |
//! | [`gas_law`] | the same from pressure and temperature |
//! | [`nusselt`] | local Nusselt number of the sphere: Legendre amplitudes as functions of the Reynolds number |
//! | [`surface`] | its mean over one part of the sphere, and how that changes with the wind |
//! | [`sphere`] | the parts of known heads: four tetrahedral sectors, two hemispheres |
//! | [`vector`] | the inverse: conductances in, wind vector with its covariance out |
//! | [`card`] | the same for four dice on a card: speed and direction in its plane |
//! | [`Wind`] | the wind as it is answered, with its errors and doubts |
//!
//! A wind vector says where the gas goes *to*. It comes in the frame in which the axes of the parts are given.
//!
//! All of it knows forced convection of a smooth sphere in a continuum, and nothing of its stem: what the stem, free convection or the
//! gas's Prandtl number make of the amplitudes is for the calibration to put into them. It is meant for the decimated rate, 10 to
//! 100 Hz. What runs there uses `+ − × ÷` on f32 in fixed order; root and logarithm are made of these here.
//!
//! ```
//! use dr_core::sensor::wind::{sphere, Gas, Measured, NusseltConfig, WindState, WindVector};
//!
//! // Amplitudes come from a calibration; these are of about the right size for Re 1 … 200.
//! let amplitudes = core::array::from_fn(|j| {
//!     let root = 1.089_f32.powi(j as i32); // √Re
//!     [2.0 + 0.53 * root, 0.55 * root, 0.0, 0.0, 0.0, 0.0]
//! });
//! let nusselt = NusseltConfig { least_reynolds: 1.0, most_reynolds: 200.0, amplitudes };
//! let head = WindVector::new(&nusselt, &sphere::tetrahedral_sectors(0.01), 0.01, 0.5)?;
//! let gas = Gas::new(0.0168, 11.05e-6, 10.84e-3)?; // CO2 of 700 Pa at 220 K
//!
//! let measured = head.conductances(&gas, [3.0, -4.0, 1.0]).map(|given| {
//!     let error_w_k = 1e-3 * given.conductance_w_k;
//!     Some(Measured { conductance_w_k: given.conductance_w_k, variance_w2_k2: error_w_k * error_w_k })
//! });
//! let wind = head.step(&mut WindState::default(), &gas, &measured);
//! assert!(!wind.quality.failed && (wind.wind_m_s[1] + 4.0).abs() < 1e-3);
//! # Ok::<(), dr_core::ConfigError>(())
//! ```

mod answer;
pub(crate) mod arithmetic;
pub mod card;
mod descent;
mod fold;
mod frame;
pub mod gas;
pub mod gas_law;
mod normal;
pub mod nusselt;
pub mod sphere;
mod start;
pub mod surface;
pub mod vector;

pub use answer::{Quality, Wind};
pub use card::{Card, CardConfig};
pub use gas::Gas;
pub use gas_law::{GasLaw, GasLawConfig};
pub use nusselt::{Nusselt, NusseltConfig};
pub use surface::{Part, PartConfig};
pub use vector::{Conductance, Measured, WindState, WindVector};

#[cfg(test)]
pub(crate) mod tests;
