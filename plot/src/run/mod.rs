//! Recordings as figures.

mod azimuth;
mod figure;
mod numbers;
mod set_points;
mod wind;
mod wind_error;

pub use figure::figure;
