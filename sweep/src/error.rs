//! Why a sweep, or one of its runs, is not done.

use std::path::Path;

use host_sim::run::RunError;
use recording::RecordingError;
use recording::toml_file::FileError;

/// Why a sweep cannot be read or gathered.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// The sweep file or a file that it names is wrong.
    #[error(transparent)]
    File(#[from] FileError),
    /// The results cannot be written.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A folder or file cannot be used; a sentence.
    #[error("{0}")]
    Folder(String),
}

impl SweepError {
    pub(crate) fn folder(path: &Path, error: &std::io::Error) -> Self {
        Self::Folder(format!("{}: {error}", path.display()))
    }
}

/// What is wrong with an entry of a sweep file, without its place: a sentence's end.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub(crate) struct EntryError(pub String);

impl From<&str> for EntryError {
    fn from(sentence: &str) -> Self {
        Self(sentence.to_owned())
    }
}

impl AsRef<str> for EntryError {
    fn as_ref(&self) -> &str {
        &self.0
    }
}

/// Why one run is not done.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RunFailure {
    /// A sentence; it stands in the results.
    #[error("{0}")]
    Failed(String),
    /// Its folder cannot be written; a sentence.
    #[error("{0}")]
    Unwritten(String),
    /// Somebody asked for the end; the run is as if it had not begun.
    #[error("interrupted")]
    Interrupted,
    /// There is no such run in the sweep.
    #[error("the sweep has no run {0}: it has other files or another version by now")]
    Unknown(String),
}

impl RunFailure {
    pub(crate) fn unwritten(path: &Path) -> impl Fn(std::io::Error) -> Self {
        move |error| Self::Unwritten(format!("{}: cannot be written: {error}", path.display()))
    }
}

impl From<RunError> for RunFailure {
    fn from(error: RunError) -> Self {
        match error {
            RunError::Interrupted => Self::Interrupted,
            error => Self::Failed(error.to_string()),
        }
    }
}

impl From<FileError> for RunFailure {
    fn from(error: FileError) -> Self {
        Self::Failed(error.to_string())
    }
}

impl From<RecordingError> for RunFailure {
    fn from(error: RecordingError) -> Self {
        Self::Failed(error.to_string())
    }
}
