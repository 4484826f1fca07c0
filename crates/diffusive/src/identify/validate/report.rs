//! What a validation reports.

use std::fmt::{self, Display, Formatter};

use recording::text::brief;
use serde::{Serialize, Serializer};

use crate::model::Whiteness;

/// What the model starts from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ValidationStart {
    /// Offset and stored heat are estimated from the record.
    Estimate,
    /// Where the identified record ended.
    Continue,
    /// All states zero and the model's own offset.
    Rest,
}

/// How well a model predicted a record; for people by `Display`. As JSON, figures of the first
/// output stand beside the list of all.
#[derive(Debug, Clone, PartialEq)]
pub struct ValidationReport {
    /// In the model's order.
    pub outputs: Vec<ValidatedOutput>,
    /// Rows of the record.
    pub rows: u64,
    /// Parts of it between gaps.
    pub segments: u64,
    /// What the record's reader decided by default, and what it found remarkable.
    pub notes: Vec<String>,
    /// What the model started from.
    pub start: ValidationStart,
    /// Why the figures say little, if they do: sentences for the user.
    pub warnings: Vec<String>,
}

/// Figures of one output.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ValidatedOutput {
    /// The output's column.
    pub name: String,
    /// Root mean square error, in the output's unit.
    pub rmse: f64,
    /// 100 (1 − ‖y − ŷ‖ / ‖y − mean y‖); none where the output is the same in all rows, as there is
    /// nothing to fit.
    pub fit_percent: Option<f64>,
    /// The output's value, if it is the same in all rows.
    #[serde(skip)]
    pub constant: Option<f64>,
    /// The offset with which the record was predicted.
    pub offset_c: f64,
    /// Of the residuals.
    pub whiteness: Option<Whiteness>,
}

impl Serialize for ValidationReport {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let first = self.outputs.first();
        keys! {
            rmse: first.map(|output| output.rmse),
            fit_percent: first.and_then(|output| output.fit_percent),
            offset_c: first.map(|output| output.offset_c),
            n: self.rows,
            segments: self.segments,
            start: self.start,
            warnings: &self.warnings,
            outputs: &self.outputs,
        }
        .serialize(serializer)
    }
}

impl Display for ValidationReport {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let from = match self.start {
            ValidationStart::Estimate => "offset and stored heat estimated from the record",
            ValidationStart::Continue => "going on where the identified record ended",
            ValidationStart::Rest => "from rest, with the model's offset",
        };
        writeln!(f, "{} rows, {from}", self.rows)?;
        self.notes.iter().try_for_each(|note| writeln!(f, "  {note}"))?;
        for output in &self.outputs {
            let fit = output.fit_percent.map_or("no fit".to_owned(), |percent| format!("fit {percent:.2} %"));
            write!(f, "{}: {fit}, rmse {}, offset {}", output.name, brief(output.rmse), brief(output.offset_c))?;
            let white = output.whiteness.as_ref().map_or("", |white| match white.is_white() {
                true => "; residuals white",
                false => "; residuals coloured",
            });
            writeln!(f, "{white}")?;
        }
        self.warnings.iter().try_for_each(|warning| writeln!(f, "\nwarning: {warning}"))
    }
}
