//! Models of heated bodies: time-constant spectra, frequency responses, structure functions, and
//! how well they fit a record.

mod band;
mod bode;
mod figure;
mod fit;
mod naming;
mod spectrum;
mod structure;

pub use figure::{figure, validation_figure};
pub use fit::FitSeries;

#[cfg(test)]
pub(crate) mod tests;
