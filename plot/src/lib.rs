//! Every picture of the project, as SVG: runs, wind estimates, models and closed loops over time,
//! rate or frequency.
//!
//! There is one engine: a [`Figure`] is a title above rows of [`Chart`]s, each with axes and
//! [`Trace`]s in it. All else is content, which turns data into a figure.
//!
//! ```
//! use plot::{Chart, Figure, Scale, Trace};
//!
//! let at = |n: i32| (0.1 * f64::from(n), 1.0 / f64::from(n));
//! let exact: Vec<(f64, f64)> = (1..100).map(at).collect();
//! let found = vec![(0.1, 0.9), (1.0, 0.11), (5.0, 0.021)];
//! let chart = Chart::new("Time-constant spectrum", "K/W")
//!     .x(Scale::Log, "rad/s")
//!     .y(Scale::Log)
//!     .trace(Trace::line("exact", exact))
//!     .trace(Trace::points("found", found).errors(vec![0.1, 0.02, 0.004]));
//! let figure = Figure::new("Found against exact").subtitle("least squares, 3 rates");
//! let svg = figure.row([chart]).svg();
//! assert!(svg.contains("least squares, 3 rates"));
//! ```
//!
//! | module | what it draws |
//! |---|---|
//! | [`run`] | a recording: wind, temperatures, powers, heater bits; wind estimates with their truth and quality flags |
//! | [`model`] | a model: time-constant spectra, fits and residuals, frequency responses, structure functions |
//! | [`closed_loop`] | poles, zeros and steps of a closed loop; predicted against recorded power |
//! | [`cole_cole`] | the identification of a system whose answer is known |
//!
//! [`draw_file`] draws a file into a file, [`Canvas`] any figure.

mod canvas;
pub mod closed_loop;
pub mod cole_cole;
mod engine;
mod error;
pub mod model;
pub mod run;

pub use canvas::{Canvas, PlotReport, draw_file};
pub use engine::axis::Scale;
pub use engine::chart::{Chart, Figure};
pub use engine::reduce::Bin;
pub use engine::trace::Trace;
pub use engine::words::brief;
pub use error::PlotError;

#[cfg(test)]
mod tests;
