//! What can be wrong with a recording, in one sentence each.

use std::path::{Path, PathBuf};

use crate::text::one_line;

/// Why a recording cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// The file's name does not say its format.
    #[error("{}: a recording's name ends in .parquet or .csv", .0.display())]
    Extension(PathBuf),
    /// The program was built without the feature `parquet`.
    #[error("{}: this program was built without Parquet: use a .csv file, or build it with the feature `parquet`", .0.display())]
    NoParquet(PathBuf),
    /// There is no such file.
    #[error("{}: there is no such file", .0.display())]
    Missing(PathBuf),
    /// The operating system refuses.
    #[error("{}: cannot be {doing}: {reason}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// `read` or `written`.
        doing: &'static str,
        /// The system's words.
        reason: String,
    },
    /// The file is not whole.
    #[error("{}: is damaged or cut short, and cannot be read: {reason}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What does not fit.
        reason: String,
    },
    /// The file is whole, and its content cannot be used.
    #[error("{}: {sentence}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong, where, and what would be right.
        sentence: String,
    },
    /// A row has other cells than its recording.
    #[error("the row for {time_s} s does not fit the recording: {sentence}")]
    Row {
        /// Time of the row, s.
        time_s: f64,
        /// What is wrong.
        sentence: String,
    },
}

impl RecordingError {
    pub(crate) fn io(path: &Path, doing: &'static str, error: &dyn std::fmt::Display) -> Self {
        Self::Io { path: path.to_owned(), doing, reason: error.to_string() }
    }

    pub(crate) fn damaged(path: &Path, reason: &dyn std::fmt::Display) -> Self {
        Self::Damaged { path: path.to_owned(), reason: one_line(reason.to_string()) }
    }

    pub(crate) fn content(path: &Path, sentence: impl Into<String>) -> Self {
        Self::Content { path: path.to_owned(), sentence: one_line(sentence.into()) }
    }
}
