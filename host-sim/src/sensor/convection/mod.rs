//! Forced convection: from the wind vector to the conductance of every surface of a body.
//!
//! | file | what |
//! |---|---|
//! | [`sphere_stream`] | local Nusselt number of a sphere in a stream, as Legendre coefficients |
//! | [`sphere_surfaces`] | its means over four sectors, or over two hemispheres |
//! | [`boom`] | small dice on cards around a cylindrical boom, by correlations |
//! | [`film`] | a small film on its own, by a correlation |
//!
//! A wind vector points where the air goes *to*. All of them know forced convection only, in a
//! continuum. Each is made in one gas, and can [follow](BodyConvection::follow) that gas to another
//! temperature without being made anew.

mod any;
pub mod boom;
pub mod film;
mod flow;
pub mod sphere_stream;
pub mod sphere_surfaces;

pub use any::BodyConvection;
