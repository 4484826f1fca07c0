//! Pictures of models and of how well they fit, as SVG, in the look of a run's picture.
//!
//! [`page`] stacks all that there is to see of a model; [`FitSeries`] takes a record and its prediction row by row, however long.
//! [`Lines`] is the general figure: rows of [`Chart`]s with [`Series`] in them, on linear or logarithmic axes.

mod bode;
mod chart;
pub mod closed_loop;
mod columns;
mod fit;
mod head;
mod marks;
mod naming;
mod page;
mod paint;
mod scaled;
mod structure;
mod symbol;
mod words;

pub use super::axis::Scale;
pub use super::reduce::Bin;
pub use chart::{Chart, Lines, Series};
pub use fit::{FitBuilder, FitSeries};
pub use page::page;
pub use words::brief;

#[cfg(test)]
mod tests;
