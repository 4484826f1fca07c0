//! Why a head cannot be calibrated: a sentence each.

use dr_core::ConfigError;
use recording::RecordingError;
use recording::toml_file::FileError;

use crate::network::error::NetworkError;

/// Readings from which no calibration can be fitted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CalibrateError {
    /// The head as drawn cannot be.
    #[error("head: {0}")]
    Head(String),
    /// A reading cannot be meant.
    #[error("wind {0}")]
    Reading(String),
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
         another frame, or a surface of the head that is not as drawn; surfaces that are no body together are calibrated one by one, \
         `--elements {} --form single`, and combined by `anemo combine`",
        100.0 * residual_rms, worst.label, worst.surface, worst.surface
    )]
    Unexplained {
        /// Residuals over the convective power, rms.
        residual_rms: f64,
        /// The reading that fits least.
        worst: WorstReading,
    },
    /// Winds from where wires see the same as from elsewhere.
    #[error(
        "{} of the winds, such as `{}`, come from where the wires see the same as from in front: from behind their normals, or \
         from outside the quadrant between two normals that stand at right angles; turn the normals or the frame of the winds, or leave such \
         winds out",
        labels.len(), labels[0]
    )]
    Mirrored {
        /// Of these winds; at least one.
        labels: Vec<String>,
    },
    /// What fits tells no direction.
    #[error(
        "directions that were left out of the fit come out {rms_deg:.0}° wrong, rms: check the frame of the winds, the normals \
         and the order of the surfaces"
    )]
    Direction {
        /// Of the cross-validation, °.
        rms_deg: f64,
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

/// A head, a network or steady winds that make no calibrated head.
#[derive(Debug, thiserror::Error)]
pub enum CalibratorError {
    /// The network cannot be one of the head.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// The head is no sphere that can be calibrated, or the network lacks its surfaces or its gas.
    #[error("{0}")]
    Head(String),
    /// Options that do not fit the head, with the option's name.
    #[error("{0}")]
    Options(String),
    /// Nothing can be fitted.
    #[error(transparent)]
    Calibrate(#[from] CalibrateError),
    /// A table of steady winds cannot be used.
    #[error(transparent)]
    Table(#[from] RecordingError),
    /// The calibration makes no head.
    #[error(transparent)]
    File(#[from] FileError),
}
