//! Recordings as figures.

mod azimuth;
mod figure;
mod set_points;
mod wind;

pub use figure::figure;
