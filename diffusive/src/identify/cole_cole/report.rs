//! What an identification of Cole and Cole's system reports.

use std::fmt::{self, Display, Formatter};

use serde::Serialize;

use super::super::report::chosen;
use super::case::ColeColeInput;
use super::compare::ColeColeComparison;
use crate::model::Model;

/// The experiment, the model that was identified from it, and how close it comes; for people by
/// `Display`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ColeColeReport {
    /// What drove the system.
    pub input: ColeColeInput,
    /// Standard deviation of the noise on the output.
    pub noise: f64,
    /// Seed of the noise.
    pub seed: u64,
    /// Rows of the record.
    pub rows: usize,
    /// Their distance in time.
    pub sample_period_s: f64,
    /// The model against the truth.
    pub comparison: ColeColeComparison,
    /// What was identified.
    pub model: Model,
}

impl Display for ColeColeReport {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { noise, seed, rows, sample_period_s, comparison, .. } = self;
        let input = self.input.words();
        writeln!(
            f,
            "Cole–Cole relaxation, {input}: {rows} rows, {sample_period_s} s apart, noise {noise}, seed {seed}\n"
        )?;
        writeln!(f, "  {:>12} {:>11} {:>11} {:>9} {:>10}", "rate rad/s", "exact", "identified", "error %", "± se")?;
        for value in &comparison.symbol {
            writeln!(
                f,
                "{} {:>12.4e} {:>11.4e} {:>11.4e} {:>+9.2} {:>10.1e}",
                if value.interior { ' ' } else { '·' },
                value.rate_rad_s,
                value.exact,
                value.identified,
                100.0 * value.relative_error,
                value.se
            )?;
        }
        let largest_percent = 100.0 * comparison.largest_interior_error;
        writeln!(f, "\nlargest error of the interior rates (without ·): {largest_percent:.2} %")?;
        writeln!(f, "negative values: {}", comparison.negative_values)?;
        writeln!(f, "output, from rest, to the exact one: {:.2e} rms", comparison.output_rmse)?;
        chosen(f, &self.model)
    }
}
