//! Conductances of heated surfaces to the gas, and the wind vector that follows from them.
//!
//! | file | what |
//! |---|---|
//! | [`gas`] | properties of the gas: density, viscosity, conductivity |
//! | [`gas_law`] | the same from pressure and temperature |
//! | [`convection`] | at which temperature they are taken, and from which stream |
//! | [`free_stream`] | the wind far from a head, and the stream that it meets: stem, rise of warm gas |
//! | [`form`] | sphere, cylinder, wires, single element: which winds their surfaces tell apart |
//! | [`nusselt`] | local Nusselt number of the body: amplitudes as functions of the Reynolds number |
//! | [`surface`] | its mean over one surface, and how that changes with the wind |
//! | [`sphere`] | the surfaces of known heads: four tetrahedral sectors, two hemispheres |
//! | [`surface_inverse`] | the inverse: conductances in, wind vector with its covariance out |
//! | [`card_inverse`] | the same for four dice on a card: speed and direction in its plane |
//! | [`slow_errors`] | what sun, dust and drifts do to the number that four surfaces have to spare |
//! | [`WindEstimate`] | the wind vector with its standard errors and quality |
//! | [`QualityFlags`] | limitations of an estimate, one bit each |
//! | [`anemometer`] | the wind estimate of each tick of the controller; it decides nothing |
//!
//! A wind vector points in the direction in which the gas moves. It comes in the frame in which the
//! axes of the surfaces are given.
//!
//! The inverse knows forced convection of a smooth body in a continuum; what the gas's Prandtl
//! number makes of the amplitudes is for the calibration to put into them. It is meant for the
//! decimated rate, 10 to 100 Hz. What runs there uses `+ − × ÷` on f32 in fixed order; root and
//! logarithm are made of these here.
//!
//! ```
//! use dr_core::wind::{
//!     GasState, HeadForm, MeasuredConductance, NusseltConfig, QualityFlags, WindState, WindVector,
//!     sphere,
//! };
//!
//! // Amplitudes come from a calibration; these are of about the right size for Re 1 … 200.
//! let amplitudes = core::array::from_fn(|j| {
//!     let root = 1.089_f32.powi(j as i32); // √Re
//!     [2.0 + 0.53 * root, 0.55 * root, 0.0, 0.0, 0.0, 0.0]
//! });
//! let nusselt = NusseltConfig { least_reynolds: 1.0, most_reynolds: 200.0, amplitudes };
//! let surfaces = sphere::tetrahedral_sectors(0.01);
//! let head = WindVector::new(HeadForm::Sphere, &nusselt, &surfaces, 0.01, 0.5)?;
//! let gas = GasState::new(0.0168, 11.05e-6, 10.84e-3)?; // CO2 of 700 Pa at 220 K
//!
//! let measured = head.conductances(&gas, [3.0, -4.0, 1.0]).map(|given| {
//!     let conductance_w_k = given.conductance_w_k;
//!     let error_w_k = 1e-3 * conductance_w_k;
//!     Some(MeasuredConductance { conductance_w_k, variance_w2_k2: error_w_k * error_w_k })
//! });
//! let wind = head.step(&mut WindState::default(), &gas, &measured);
//! assert!(!wind.quality.has(QualityFlags::FAILED) && (wind.wind_m_s[1] + 4.0).abs() < 1e-3);
//! # Ok::<(), dr_core::ConfigError>(())
//! ```

pub mod anemometer;
pub mod calibration_uncertainty;
pub mod card_inverse;
pub mod convection;
mod estimate;
pub mod form;
pub mod free_stream;
pub mod gas;
pub mod gas_law;
mod gauss_newton;
mod head_frame;
mod normal;
pub mod nusselt;
pub mod quality_flags;
mod singularity;
pub mod slow_errors;
pub mod sphere;
mod start;
pub mod surface;
pub mod surface_inverse;

pub use anemometer::command::{HeadSurface, WindCommand, WindOutputConfig};
pub use anemometer::{Anemometer, WindTick};
pub use calibration_uncertainty::CalibrationUncertainty;
pub use card_inverse::{Card, CardConfig};
pub use convection::{ConvectionConfig, ConvectionSettings};
pub use estimate::WindEstimate;
pub use form::{BOARD_SURFACES, HeadForm, MOST_SURFACES};
pub use free_stream::{FreeStream, RiseConfig, StemConfig};
pub use gas::GasState;
pub use gas_law::{GasLaw, GasLawConfig};
pub use nusselt::{Nusselt, NusseltConfig};
pub use quality_flags::QualityFlags;
pub use surface::{NusseltSurface, SurfaceConfig};
pub use surface_inverse::{Conductance, MeasuredConductance, WindState, WindVector};

#[cfg(test)]
pub(crate) mod tests;
