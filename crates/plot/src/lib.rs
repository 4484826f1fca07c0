//! Every picture of the project, as SVG, PDF or PNG: runs, wind estimates, models and closed loops
//! over time, rate or frequency.
//!
//! There is one engine: a [`Figure`] is a title above rows of [`Chart`]s, each with axes and
//! [`Trace`]s in it. All else is content, which turns data into a figure.
//!
//! A figure is laid out for a width on paper ([`PictureWidth`]): 180 mm, a journal's double column,
//! unless another is chosen. Type has 6 to 10 pt at any width. Every chart has axis titles with
//! units, and traces differ by dashes or markers as well as by colour.
//!
//! ```
//! use plot::{Chart, Figure, PictureWidth, Scale, Trace};
//!
//! let at = |n: i32| (0.1 * f64::from(n), 1.0 / f64::from(n));
//! let exact: Vec<(f64, f64)> = (1..100).map(at).collect();
//! let found = vec![(0.1, 0.9), (1.0, 0.11), (5.0, 0.021)];
//! let chart = Chart::new("Time-constant spectrum", "K/W")
//!     .y_title("Thermal resistance") // "Thermal resistance (K/W)" beside the axis
//!     .x(Scale::Log, "rad/s") // "Rate (rad/s)" below it
//!     .y(Scale::Log)
//!     .trace(Trace::line("exact", exact))
//!     .trace(Trace::points("found", found).errors(vec![0.1, 0.02, 0.004]));
//! let figure = Figure::new("Found against exact").subtitle("least squares, 3 rates");
//! let svg = figure.row([chart]).at(PictureWidth::mm(88.0)?).svg();
//! assert!(svg.starts_with("<svg width=\"88mm\"") && svg.contains("Rate (rad/s)"));
//! # Ok::<(), anyhow::Error>(())
//! ```
//!
//! | module | what it draws |
//! |---|---|
//! | [`run`] | a recording: wind, temperatures, powers, heater bits; wind estimates with their truth and quality flags |
//! | [`model`] | a model: time-constant spectra, fits and residuals, frequency responses, structure functions |
//! | [`closed_loop`] | poles, zeros and steps of a closed loop; predicted against recorded power |
//! | [`head`] | a head by the normals of its surfaces, its network, and the powers that it needs by wind |
//!
//! [`draw_file`] draws a file into a file, [`Canvas`] any figure.
//!
//! | length | unit |
//! |---|---|
//! | width of a figure, height of a chart | mm |
//! | type, widths of lines, the view box of an SVG | points of 1/72 inch |

mod canvas;
pub mod closed_loop;
mod engine;
pub mod head;
pub mod model;
mod picture;
pub mod run;

pub use canvas::{Canvas, PictureOptions, PlotReport, TimeCrop, draw_file};
pub use engine::axis::Scale;
pub use engine::chart::{Chart, Figure};
pub use engine::reduce::Bin;
pub use engine::trace::Trace;
pub use engine::words::brief;
pub use picture::{PictureFormat, PictureWidth};

#[cfg(test)]
mod on_paper;
#[cfg(test)]
mod tests;
