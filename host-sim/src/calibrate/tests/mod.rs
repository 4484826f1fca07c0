//! Calibrations of simulated heads, whose truth the fit does not share a line with.

pub mod tunnel;

mod refused;
mod spheres;
mod winds;
