//! Why a run did not come to its end.

use crate::instrument::error::InstrumentError;
use recording::toml_file::FileError;
use recording::{RecordingError, RecordingRow};
use serde::Serialize;

/// Takes the rows of a run.
pub type RowSink<'a> = &'a mut dyn FnMut(&RecordingRow) -> Result<(), RunError>;

/// Why a run did not come to its end.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The instrument refuses what the file asks for.
    #[error(transparent)]
    Refused(#[from] FileError),
    /// The instrument cannot go on.
    #[error(transparent)]
    Instrument(#[from] InstrumentError),
    /// The recording cannot be written.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// Somebody asked for the end.
    #[error("interrupted")]
    Interrupted,
    /// The run has passed, and nothing of it has arrived.
    #[error("no sample of the whole run arrived: look at the cable, and at its length for this speed")]
    NoSample,
}

/// Why a run ended before its time, its rows kept.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, thiserror::Error)]
#[error(
    "{why}{}",
    if *stopped { "" } else { "; its `Stop` was not confirmed, so heaters may still be on: switch its supply off" }
)]
pub struct EarlyEnd {
    /// A sentence.
    pub why: String,
    /// The instrument has confirmed its stop: its heaters are low.
    pub stopped: bool,
}

impl EarlyEnd {
    /// The last `Stop` was not confirmed, after the run or after what had ended it.
    pub(super) fn not_stopped(ended: Option<Self>, error: &InstrumentError) -> Self {
        let why = ended.map_or_else(|| format!("the instrument could not be stopped: {error}"), |ended| ended.why);
        Self { why, stopped: false }
    }
}
