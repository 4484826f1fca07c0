//! Why a run has no result, or ended early.

use host_sim::instrument::InstrumentError;
use recording::RecordingError;
use recording::toml_file::FileError;

use crate::port::PortError;

/// Why a run has no result, or ended early.
#[derive(Debug, thiserror::Error)]
pub enum DeviceRunError {
    /// The file's mistake.
    #[error(transparent)]
    File(#[from] FileError),
    /// The controller cannot go on.
    #[error(transparent)]
    Controller(#[from] InstrumentError),
    /// The device cannot be reached.
    #[error(transparent)]
    Port(#[from] PortError),
    /// The recording cannot be written.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// Somebody wanted the end.
    #[error("interrupted")]
    Interrupted,
}
