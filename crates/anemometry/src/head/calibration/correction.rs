//! Corrections of slow errors that a head carries: the table `[calibration.correction]`, which
//! `anemo wind --write-head` writes. Whatever uses the head applies them.

use dr_core::wind::slow_errors::SurfaceCorrection;
use dr_core::wind::sphere::SECTORS;
use serde::{Deserialize, Serialize};

/// `[calibration.correction]`
#[derive(Deserialize, Serialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct CorrectionTable {
    /// What was sought in which recordings, in words.
    pub made_from: String,
    /// Day of the last of them, as 2026-03-01, if it states one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub made_on: Option<String>,
    /// Of every surface, in the order of the calibration's.
    pub surfaces: Vec<SurfaceCorrectionTable>,
}

/// `[[calibration.correction.surfaces]]`
#[derive(Deserialize, Serialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct SurfaceCorrectionTable {
    /// Name of its element.
    pub element: String,
    /// Heat that it takes up beside the wind, W.
    pub offset_w: f64,
    /// Standard uncertainty, W.
    pub offset_u_w: f64,
    /// Change of its gain since the calibration, as a share.
    pub gain_change: f64,
    /// Standard uncertainty.
    pub gain_change_u: f64,
}

impl SurfaceCorrectionTable {
    /// Of a correction as the board takes it: what multiplies a conductance takes back what its
    /// gain has changed by.
    pub fn new(element: String, of: &SurfaceCorrection) -> Self {
        let factor = 1.0 + f64::from(of.gain);
        Self {
            element,
            offset_w: of.offset_w.into(),
            offset_u_w: of.offset_u_w.into(),
            gain_change: 1.0 / factor - 1.0,
            gain_change_u: f64::from(of.gain_u) / factor.powi(2),
        }
    }

    /// As the board takes it.
    pub fn config(&self) -> SurfaceCorrection {
        let remains = 1.0 + self.gain_change;
        SurfaceCorrection {
            offset_w: self.offset_w as f32,
            gain: (1.0 / remains - 1.0) as f32,
            offset_u_w: self.offset_u_w as f32,
            gain_u: (self.gain_change_u / remains.powi(2)) as f32,
        }
    }
}

impl CorrectionTable {
    /// As the board takes it; none of a table that was not checked.
    pub fn config(&self) -> Option<[SurfaceCorrection; SECTORS]> {
        let [a, b, c, d] = &self.surfaces[..] else { return None };
        Some([a, b, c, d].map(SurfaceCorrectionTable::config))
    }

    /// That they are applied, in a sentence.
    pub fn sentence(&self) -> String {
        let day = self.made_on.as_ref().map_or_else(String::new, |day| format!(" of {day}"));
        format!("corrections{day} are applied, by {}", self.made_from)
    }
}
