//! Recordings as figures.

mod columns;
mod error_charts;
mod figure;
mod quantity;
mod temperatures;
mod wind;
mod wind_error;

pub use figure::figure;
