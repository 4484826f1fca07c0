//! Calibrations of simulated heads, whose truth the fit does not share a line with.

mod cards;
mod derivatives;
mod other_heads;
mod refused;
mod spheres;
mod streams;
mod tunnel;
mod winds;
