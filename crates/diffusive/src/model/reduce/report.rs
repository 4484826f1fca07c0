//! A smaller model as a report: the text and the keys of `anemo model reduce`.

use std::fmt::{self, Display, Formatter};

use serde::Serialize;

use super::loss::{Loss, Reduced};
use crate::model::ModelError;
use crate::model::content::{Class, Model, Pair};

/// Result of a reduction and its loss. It prints as a summary, and serialises to the keys of `anemo
/// model reduce --json`.
#[derive(Debug, Serialize)]
pub struct ReductionReport<'a> {
    /// Poles a pair that were requested.
    pub order: usize,
    pairs: &'a [Pair],
    losses: &'a [Loss],
    /// The board's table, where there is one.
    toml: Option<&'a str>,
    /// The file of the smaller model.
    file: Option<String>,
    #[serde(skip)]
    whole: &'a Model,
    #[serde(skip)]
    no_table: Option<&'a ModelError>,
    #[serde(skip)]
    table_file: Option<String>,
}

impl<'a> ReductionReport<'a> {
    /// A whole model and what it was reduced to, with the board's table or why there is none, and
    /// the files of both.
    pub fn new(
        whole: &'a Model,
        (order, reduced): (usize, &'a Reduced),
        table: &'a Result<String, ModelError>,
        (file, table_file): (Option<String>, Option<String>),
    ) -> Self {
        let (pairs, losses) = (&reduced.model.pairs, &reduced.losses);
        let (toml, no_table) = (table.as_deref().ok(), table.as_ref().err());
        Self { order, pairs, losses, toml, file, whole, no_table, table_file }
    }
}

impl Display for ReductionReport<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        for (before, pair) in self.whole.pairs.iter().zip(self.pairs) {
            let (from, to) = (before.mesh_rad_s.len(), pair.mesh_rad_s.len());
            writeln!(f, "{} → {}: {from} poles → {to}, f32", pair.input, pair.output)?;
            for (label, class) in &pair.classes {
                write_class(f, pair, label, class)?;
                let own = |loss: &&Loss| loss.input == pair.input && loss.output == pair.output && loss.class == *label;
                if let Some(loss) = self.losses.iter().find(own) {
                    for (input, difference) in [("random bits", loss.bits), ("random levels", loss.levels)] {
                        writeln!(
                            f,
                            "  lost on {input}: {:.2e} of the output's rms, at most {:.2e} K/W",
                            difference.rms_share, difference.largest_k_per_w
                        )?;
                    }
                    writeln!(f, "  steady gain changes by {:.2e} of itself", loss.steady_gain_change)?;
                }
            }
        }
        match (self.toml, self.no_table, &self.table_file) {
            (_, _, Some(path)) => writeln!(f, "\nboard's table in {path}")?,
            (Some(table), ..) => write!(f, "\nThe board's table (--toml FILE writes it):\n\n{table}")?,
            (None, Some(error), None) => writeln!(f, "\nNo table for the board: {error}")?,
            (None, None, None) => {}
        }
        match &self.file {
            Some(path) => writeln!(f, "\nmodel in {path}"),
            None => Ok(()),
        }
    }
}

fn write_class(f: &mut Formatter<'_>, pair: &Pair, label: &str, class: &Class) -> fmt::Result {
    writeln!(f, "  class {label}\n  {:>14}  {:>14}  {:>10}", "rate rad/s", "R K/W", "± K/W")?;
    for ((rate, r), se) in pair.mesh_rad_s.iter().zip(&class.r_k_per_w).zip(&class.se_k_per_w) {
        writeln!(f, "  {:>14}  {:>14}  {se:>10.1e}", *rate as f32, *r as f32)?;
    }
    Ok(())
}
