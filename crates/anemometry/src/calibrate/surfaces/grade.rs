//! A calibration in a word, by what its model leaves of the readings.
//!
//! The bounds are the tunnel's: speeds of a good one are known to 0.5 %, of an ordinary one to 2 %,
//! and the convective power goes as the speed to the power of 0.3 to 0.4.

use serde::Serialize;

/// Misfit up to which a calibration is good: 0.5 % of speed.
const GOOD: f64 = 2e-3;
/// Misfit up to which it is fair: 2 to 3 % of speed.
const FAIR: f64 = 1e-2;
/// What to do about a poor one.
pub const ADVICE: &str =
    "check labels and frame of the winds, the order of the surfaces, and what stands in the stream";

/// What a calibration is worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum CalibrationGrade {
    /// The misfit is less than what tunnels know of their speeds.
    Good,
    /// The misfit is that of an ordinary tunnel.
    Fair,
    /// No tunnel explains the misfit.
    Poor,
}

impl CalibrationGrade {
    /// Of a misfit over the convective power, rms.
    pub fn of(misfit_rms: f64) -> Self {
        match misfit_rms {
            misfit if misfit <= GOOD => Self::Good,
            misfit if misfit <= FAIR => Self::Fair,
            _ => Self::Poor,
        }
    }

    /// In a word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Fair => "fair",
            Self::Poor => "poor",
        }
    }

    /// What it means.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Good => "the misfit is less than 0.5 % of speed; standard uncertainties include it",
            Self::Fair => {
                "the misfit is up to 3 % of speed, as much as an ordinary tunnel's speeds are off; look at the worst wind"
            }
            Self::Poor => "the misfit is more than 3 % of speed",
        }
    }
}
