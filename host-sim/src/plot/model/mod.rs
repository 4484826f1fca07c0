//! Pictures of models and of how well they fit, as SVG, in the look of a run's picture.
//!
//! [`Lines`] is the general figure: rows of [`Chart`]s with [`Series`] in them, on linear or logarithmic axes.

mod chart;
mod columns;
mod head;
mod paint;
mod scaled;
mod words;

pub use super::axis::Scale;
pub use super::reduce::Bin;
pub use chart::{Chart, Lines, Series};

#[cfg(test)]
mod tests;
