//! Why a new head was not written.

use std::path::PathBuf;

use recording::toml_file::FileError;

/// Why a new head was not written.
#[derive(Debug, thiserror::Error)]
pub enum NewHeadError {
    /// The head's file is wrong.
    #[error(transparent)]
    File(#[from] FileError),
    /// Head, overheat or folder is refused, in one sentence.
    #[error("{0}")]
    Refused(String),
    /// A file cannot be written.
    #[error("{}: cannot be written: {error}", path.display())]
    Unwritten {
        /// The file.
        path: PathBuf,
        /// What the system says.
        error: std::io::Error,
    },
}
