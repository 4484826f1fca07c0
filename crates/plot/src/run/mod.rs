//! Recordings as figures.

mod azimuth;
mod charge;
mod columns;
mod counted;
mod error_charts;
mod figure;
mod quantity;
mod set_points;
mod temperatures;
mod wind;
mod wind_error;

pub use figure::figure;
