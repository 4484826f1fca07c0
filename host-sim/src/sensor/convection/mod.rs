//! Convection: from the wind vector to the conductance of every surface of a body.
//!
//! | file | what |
//! |---|---|
//! | [`sphere_stream`] | local Nusselt number of a sphere in a stream, as Legendre coefficients |
//! | [`sphere_surfaces`] | its means over four sectors, or over two hemispheres |
//! | [`sphere_cells`] | its means over the surfaces around any other normals |
//! | [`cylinder`] | a cylinder in crossflow, whole or in sectors |
//! | [`wire`] | a fine wire |
//! | [`plate`] | a small plate or film on its own |
//! | [`king`], [`nusselt_table`] | King's law, and a table of Nusselt numbers |
//! | [`boom`] | small dice on cards around a cylindrical boom, by correlations |
//! | `flow` | what several of them need |
//! | `any` | any of them, by the name that a head file has for it |
//!
//! A wind vector points where the air goes *to*. All of them are for a continuum, or near it. Each
//! is made in one gas, and can [follow](BodyConvection::follow) that gas to another temperature
//! without being made anew.

mod any;
pub mod boom;
pub mod cylinder;
mod flow;
pub mod king;
pub mod nusselt_table;
pub mod plate;
pub mod sphere_cells;
pub mod sphere_stream;
pub mod sphere_surfaces;
pub mod wire;

pub use any::{BodyConvection, validity};
