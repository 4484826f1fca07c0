//! Why a record cannot be used: one sentence with the file, and the row and the column where there
//! are such.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use recording::RecordingError;
use recording::text::one_line;

/// A record that cannot be read, or that cannot be identified, or held against a model, with the
/// options given.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] RecordingError),
    /// Rows stand on no uniform grid of times; the sentence names the first of them.
    #[error("{}: {sentence}", record.display())]
    Uneven {
        /// The file.
        record: PathBuf,
        /// Sentence: what is wrong, where, and what would be right.
        sentence: String,
    },
    /// A row, a column or the whole record is not as identification needs it; the sentence names it
    /// and the remedy.
    #[error("{}: {sentence}", record.display())]
    Content {
        /// The file, or what a table in memory is called.
        record: PathBuf,
        /// Sentence: what is wrong, where, and what would be right.
        sentence: String,
    },
}

impl RecordError {
    pub(super) fn content(record: &Path, sentence: impl Into<String>) -> Self {
        Self::Content { record: record.to_owned(), sentence: one_line(sentence.into()) }
    }

    pub(super) fn uneven(record: &Path, sentence: String) -> Self {
        Self::Uneven { record: record.to_owned(), sentence: one_line(sentence) }
    }

    /// What is wrong with a value; its row is counted from 0.
    pub(super) fn value(record: &Path, column: &str, row: u64, what: impl Display) -> Self {
        Self::content(record, format!("row {}, column `{column}`: {what}", row + 1))
    }
}

/// Refuses a value that is none, in the row counted from 1.
pub(super) fn finite(record: &Path, column: &str, values: &[f64], first_row: u64) -> Result<(), RecordError> {
    // Without a branch in the loop: this runs over every value of every record.
    if values.iter().fold(true, |all, value| all & value.is_finite()) {
        return Ok(());
    }
    let at = values.iter().position(|value| !value.is_finite()).unwrap_or_default();
    let what = if values[at].is_nan() { "a value is missing" } else { "an infinite value" };
    let what = format!("{what}; cut the record there or fill the gap");
    Err(RecordError::value(record, column, first_row + at as u64, what))
}
