//! Models of heated bodies: time-constant spectra, frequency responses, structure functions, and
//! how well they fit a record.

mod bode;
mod curves;
mod figure;
mod fit;
mod spectrum;

pub use figure::{figure, validation_figure};
pub use fit::FitSeries;

#[cfg(test)]
pub(crate) mod tests;
