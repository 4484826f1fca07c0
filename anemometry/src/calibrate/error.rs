//! Why a head cannot be calibrated: a sentence each.

use std::path::PathBuf;

use dr_core::ConfigError;

use crate::gas::GasError;
use crate::head::error::NewCalibrationError;
use crate::network::error::NetworkError;
use crate::wind::error::ReplayError;

/// Readings from which no calibration can be fitted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CalibrateError {
    /// The head as drawn cannot be.
    #[error("head: {0}")]
    Head(String),
    /// A reading cannot be meant.
    #[error("wind `{label}`: {problem}")]
    Reading {
        /// Label of the wind.
        label: String,
        /// What is wrong.
        problem: String,
    },
    /// Winds are missing: a sentence each.
    #[error("the winds do not determine a calibration:\n  {}", .0.join("\n  "))]
    Spread(Vec<String>),
    /// The fit does not converge.
    #[error(
        "no best fit of the readings could be found: a gain is far from 1 or the mounting far from drawn; check the order of the surfaces \
         and the frame of the winds"
    )]
    NoMinimum,
    /// The best fit is a bad one.
    #[error(
        "what fits best leaves {:.0} % rms of the convective power, most of it `{}`, {}: surfaces in another order than the head's, winds in \
         another frame, or a surface of the head that is not as drawn",
        100.0 * residual_rms, worst.label, worst.surface
    )]
    Unexplained {
        /// Residuals over the convective power, rms.
        residual_rms: f64,
        /// The reading that fits least.
        worst: WorstReading,
    },
    /// dr-core refuses the curves.
    #[error(
        "the amplitudes that fit best do not tell a wind: {0}; check the order of the surfaces and the signs of the winds"
    )]
    Amplitudes(#[from] ConfigError),
}

/// The reading that fits least.
#[derive(Debug, Clone, PartialEq)]
pub struct WorstReading {
    /// Label of its wind.
    pub label: String,
    /// Name of its surface.
    pub surface: String,
    /// Measured less computed, in standard errors.
    pub errors: f64,
}

/// Recordings without steady winds for a calibration.
#[derive(Debug, thiserror::Error)]
pub enum SteadyWindError {
    /// The recording cannot be replayed.
    #[error(transparent)]
    Replay(#[from] ReplayError),
    /// The recording does not tell its gas or its wind, or is of other conditions than the network.
    #[error("{recording}: {sentence}")]
    Content {
        /// Name of the recording.
        recording: String,
        /// What is wrong, and what would be right.
        sentence: String,
    },
    /// The table of winds lacks a label.
    #[error("{} has no row `{label}`, which is a wind of {recording}", table.display())]
    NotInTable {
        /// The table.
        table: PathBuf,
        /// The label.
        label: String,
        /// Name of the recording.
        recording: String,
    },
    /// The gas is not known at a temperature of the recording.
    #[error("`{label}`: {error}")]
    Gas {
        /// Label of the wind.
        label: String,
        /// What is wrong.
        error: GasError,
    },
    /// Recordings of several gases.
    #[error("{}: is of another gas than the first recording", .0.display())]
    OtherGas(PathBuf),
    /// No recordings.
    #[error("there is no recording")]
    NoRecording,
}

/// A head, a network or steady winds that make no calibrated head.
#[derive(Debug, thiserror::Error)]
pub enum CalibratorError {
    /// The network is not one of the head.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// The network lacks a surface of the head.
    #[error("network has no `{element}`, which is a surface of head `{head}`: is it of another head?")]
    NoSurface {
        /// Element of the surface.
        element: String,
        /// Name of the head.
        head: String,
    },
    /// The network does not name its gas.
    #[error("does not tell its gas")]
    NoGas,
    /// The head is no sphere that can be calibrated.
    #[error(
        "head `{head}` has {count} elements with an outward `normal`: four sectors of a sphere, or two hemispheres can be calibrated"
    )]
    Shape {
        /// Name of the head.
        head: String,
        /// Its elements with a normal.
        count: usize,
    },
    /// The elements of a card are not four dice of it.
    #[error("--elements{0}")]
    Elements(String),
    /// Nothing can be fitted.
    #[error(transparent)]
    Calibrate(#[from] CalibrateError),
    /// The calibration makes no head.
    #[error(transparent)]
    New(#[from] NewCalibrationError),
}
