//! Why a run did not come to its end.

use crate::instrument::error::InstrumentError;
use recording::RecordingError;
use recording::toml_file::FileError;

/// Why a run did not come to its end.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// What the file asks for is refused by the instrument.
    #[error(transparent)]
    Refused(#[from] FileError),
    /// The instrument cannot go on.
    #[error(transparent)]
    Instrument(#[from] InstrumentError),
    /// The recording cannot be written.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// Somebody asked for the end.
    #[error("interrupted at {time_s} s; nothing was kept")]
    Interrupted {
        /// When, s after the start.
        time_s: f64,
    },
}
