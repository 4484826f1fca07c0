//! Why a model cannot be held against a record: every sentence of this kind.

use std::path::PathBuf;

use super::super::record::{RecordError, RecordSource};

/// Validation failed.
#[derive(Debug, thiserror::Error)]
pub enum ValidateError {
    /// The record cannot be read.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// Record and model do not go together.
    #[error("{}: {reason}", record.display())]
    Unfit {
        /// The file, or what a table in memory is called.
        record: PathBuf,
        /// What is wrong, and what would be right.
        reason: Mismatch,
    },
}

impl ValidateError {
    /// The reason with the name of its record.
    pub(super) fn unfit(source: &dyn RecordSource, reason: Mismatch) -> Self {
        Self::Unfit { record: source.survey().path.clone(), reason }
    }
}

/// What keeps a record from being predicted by a model: the rest of a sentence that begins with the
/// record.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "each variant's sentence says what its fields are")]
pub enum Mismatch {
    #[error(
        "has {inputs} inputs and {outputs} outputs where the model has {model_inputs} and {model_outputs}: name them with --input and --output, in the model's order"
    )]
    Columns { inputs: usize, outputs: usize, model_inputs: usize, model_outputs: usize },
    #[error("has no gas column: the model needs the temperature of the gas, which was column `{column}`")]
    NoGasColumn { column: String },
    #[error("column `{column}`: the model knows no class `{label}`; it was identified for {}", classes.join(", "))]
    UnknownClass { column: String, label: String, classes: Vec<String> },
    #[error(
        "begins at {first_time_s} s, but the identified record goes on at {next_time_s} s: only the row that follows it can be continued"
    )]
    NotTheNextRow { first_time_s: f64, next_time_s: f64 },
    #[error(
        "cannot be continued: the model does not hold where its record ended, as none does that was merged; say --start estimate or --start rest"
    )]
    NoEnd,
    #[error(
        "has {rows} rows, from which {unknowns} numbers would be estimated before anything is left to compare: give a longer record, or say --start rest"
    )]
    FewRows { rows: u64, unknowns: usize },
    #[error(
        "what the model predicts for `{output}` is too large to compute with: are the inputs in the units of the model's record?"
    )]
    TooLarge { output: String },
}
