//! Why no wind can be estimated from a recording: a sentence each.

use recording::RecordingError;
use recording::toml_file::FileError;

/// A recording whose head cannot be had.
#[derive(Debug, thiserror::Error)]
pub enum RecordedHeadError {
    /// The recording cannot be read, or carries no head.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The head cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
}

/// A recording from which no wind can be estimated.
#[derive(Debug, thiserror::Error)]
pub enum WindError {
    /// It cannot be replayed.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The head has no calibration.
    #[error("head `{0}` has no calibration, and so no wind: make one with `anemo calibrate` and name it with --head")]
    NoCalibration(String),
    /// The output interval is no whole number of ticks: what it is, and the nearest ones.
    #[error("--every {0}")]
    Interval(String),
    /// The anemometer cannot be set up.
    #[error(transparent)]
    SetUp(#[from] FileError),
    /// The gas is not known, or known twice.
    #[error(transparent)]
    Gas(#[from] GasInputError),
}

/// Why a head does not get corrections.
#[derive(Debug, thiserror::Error)]
pub enum CorrectedHeadError {
    /// Nothing contradicts, or what was found leaves most of it.
    #[error(
        "nothing is written: the slow errors that were found do not explain what contradicts, or nothing contradicts"
    )]
    Unexplained,
    /// The head cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
}

/// Pressure or temperature of the gas that is not known, known twice, or impossible: a sentence.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct GasInputError(pub(super) String);
