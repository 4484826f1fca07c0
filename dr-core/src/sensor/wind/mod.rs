//! From what the parts of a heated sphere lose to the wind vector.
//!
//! | file | what |
//! |---|---|
//! | [`gas`] | what of the gas matters: density, viscosity, conductivity |
//! | [`nusselt`] | local Nusselt number of the sphere: Legendre amplitudes as functions of the Reynolds number |
//! | [`surface`] | its mean over one part of the sphere, and how that changes with the wind |
//! | [`sphere`] | the parts of known heads: four tetrahedral sectors, two hemispheres |
//! | [`vector`] | the inverse: conductances in, wind vector with its covariance out |
//! | [`Wind`] | the wind as it is answered, with its errors and doubts |
//!
//! A wind vector says where the gas goes *to*. It comes in the frame in which the axes of the parts are given.
//!
//! All of it knows forced convection of a smooth sphere in a continuum, and nothing of its stem: what the stem, free convection or the
//! gas's Prandtl number make of the amplitudes is for the calibration to put into them. It is meant for the decimated rate, 10 to
//! 100 Hz. What runs there uses `+ − × ÷` on f32 in fixed order; root and logarithm are made of these here.

mod answer;
mod arithmetic;
mod descent;
mod fold;
mod frame;
pub mod gas;
mod normal;
pub mod nusselt;
pub mod sphere;
mod start;
pub mod surface;
pub mod vector;

pub use answer::{Quality, Wind};
pub use gas::Gas;
pub use nusselt::{Nusselt, NusseltConfig};
pub use surface::{Part, PartConfig};
pub use vector::{Conductance, Measured, WindState, WindVector};

#[cfg(test)]
mod tests;
