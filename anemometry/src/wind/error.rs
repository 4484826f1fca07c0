//! Why no wind can be estimated from a recording: a sentence each.

use std::path::{Path, PathBuf};

use recording::RecordingError;
use recording::text::tidy;
use recording::toml_file::FileError;

use super::off_line::{GasRefused, OffLineError};

/// A recording that cannot be replayed.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The file cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The head cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// A row, a column or the metadata is not as a replay needs it.
    #[error("{}: {sentence}", path.display())]
    Content {
        /// The recording.
        path: PathBuf,
        /// What is wrong, where, and what would be right.
        sentence: String,
    },
}

impl ReplayError {
    pub(super) fn content(path: &Path, sentence: impl Into<String>) -> Self {
        Self::Content { path: path.to_owned(), sentence: sentence.into() }
    }
}

/// A recording from which no wind can be estimated.
#[derive(Debug, thiserror::Error)]
pub enum WindError {
    /// It cannot be replayed.
    #[error(transparent)]
    Replay(#[from] ReplayError),
    /// The head has no calibration.
    #[error("head `{0}` has no calibration, and so no wind: make one with `anemo calibrate` and name it with --head")]
    NoCalibration(String),
    /// The output interval is no whole number of ticks.
    #[error(
        "--every {interval_s} is not a whole number of sample periods of {} s: {nearest} would be",
        tidy(*sample_period_s)
    )]
    Interval {
        /// Requested interval, s.
        interval_s: f64,
        /// Sample period, s.
        sample_period_s: f64,
        /// The nearest intervals, in words.
        nearest: String,
    },
    /// The anemometer cannot be set up.
    #[error(transparent)]
    SetUp(#[from] OffLineError),
    /// The gas is not known, or known twice.
    #[error(transparent)]
    Gas(#[from] GasInputError),
}

/// Pressure or temperature of the gas that is not known, known twice, or impossible.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GasInputError {
    /// The head is calibrated for another gas.
    #[error(
        "{}: was taken in {species}, but head `{head}` is calibrated for {calibrated}: another gas is another calibration",
        recording.display()
    )]
    OtherGas {
        /// The recording.
        recording: PathBuf,
        /// Its gas.
        species: String,
        /// Name of the head.
        head: String,
        /// Gas of the calibration.
        calibrated: &'static str,
    },
    /// Neither the recording nor an option has the pressure.
    #[error("the recording does not tell the pressure of its gas: give --pressure, in Pa")]
    NoPressure,
    /// The head measures the temperature that is also given.
    #[error("--gas-temperature is given, but this head measures the gas by its reference: leave one of them out")]
    GivenAndMeasured,
    /// Neither the head, the recording nor an option has the temperature.
    #[error("nothing tells the temperature of the gas: give --gas-temperature, a number in °C or a column")]
    NoTemperature,
    /// The board refuses a number.
    #[error("gas: {0}")]
    Refused(#[from] GasRefused),
}
