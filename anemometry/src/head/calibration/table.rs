//! The tables of a calibration as they are written: every key, before anything is checked.

use dr_core::wind::card_inverse::{KNOTS, TERMS};
use dr_core::wind::{CardConfig, SurfaceConfig};
use serde::{Deserialize, Serialize};

#[derive(Deserialize, Serialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct CalibrationTable {
    /// What it was made from and how good it is, for people.
    pub made_from: String,
    pub species: String,
    pub reference_gas_c: f64,
    pub diameter_m: f64,
    pub direction_error_max_deg: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nusselt: Option<NusseltTable>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub card: Option<CardTable>,
    #[serde(default, alias = "parts")]
    pub surfaces: Vec<SurfaceTable>,
    #[serde(default, alias = "own")]
    pub self_heating: Vec<SelfHeatingTable>,
    #[serde(default, alias = "cross")]
    pub cross_heating: Vec<CrossHeatingTable>,
}

#[derive(Deserialize, Serialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct NusseltTable {
    pub least_reynolds: f64,
    pub most_reynolds: f64,
    /// a_0 … a_5 at Reynolds numbers in geometric progression.
    pub amplitudes: Vec<[f64; 6]>,
}

/// `[calibration.card]`: the curves of a card, as dr-core's `CardConfig` has them.
#[derive(Deserialize, Serialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct CardTable {
    /// Least Reynolds number of the winds.
    pub least_reynolds: f64,
    /// Greatest Reynolds number of the winds.
    pub most_reynolds: f64,
    /// At values of √Re evenly from zero to that of the greatest Reynolds number.
    pub mean: [f64; KNOTS],
    /// D, at the same values.
    pub difference: [f64; KNOTS],
    /// Of cos nθ in P.
    pub along: [f64; TERMS],
    /// Of sin nθ in Q.
    pub around: [f64; TERMS],
    /// Of cos nθ in E.
    pub seen: [f64; TERMS],
    /// Standard error of M, as a share of what the wind adds to it.
    pub mean_share: f64,
    /// Standard error of D, as a share of its size.
    pub difference_share: f64,
}

#[derive(Deserialize, Serialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct SurfaceTable {
    pub element: String,
    pub axis: [f64; 3],
    pub corner: [f64; 3],
    pub area_m2: f64,
    pub means: [f64; 5],
    pub threefold: [f64; 3],
    pub gain: f64,
    #[serde(alias = "windless_w_k")]
    pub quiescent_w_k: f64,
}

#[derive(Deserialize, Serialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct SelfHeatingTable {
    pub element: String,
    pub rest_c: f64,
    /// Of one reading at the low and at the high level, K.
    pub noise_k: [f64; 2],
    pub mesh_rad_s: Vec<f64>,
    pub r_k_per_w: Vec<f64>,
    /// m_k; absent for an element that no wind cools.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface: Option<Vec<f64>>,
}

#[derive(Deserialize, Serialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct CrossHeatingTable {
    pub from: String,
    pub to: String,
    pub mesh_rad_s: Vec<f64>,
    pub r_k_per_w: Vec<f64>,
    pub surface: Vec<f64>,
}

impl CardTable {
    /// As the board takes it.
    pub fn config(&self) -> CardConfig {
        CardConfig {
            mean: self.mean.map(|x| x as f32),
            difference: self.difference.map(|x| x as f32),
            along: self.along.map(|x| x as f32),
            around: self.around.map(|x| x as f32),
            seen: self.seen.map(|x| x as f32),
            mean_share: self.mean_share as f32,
            difference_share: self.difference_share as f32,
        }
    }
}

impl SurfaceTable {
    /// Its geometry as the board takes it.
    pub fn surface(&self) -> SurfaceConfig {
        SurfaceConfig {
            axis: self.axis.map(|x| x as f32),
            corner: self.corner.map(|x| x as f32),
            area_m2: self.area_m2 as f32,
            means: self.means.map(|x| x as f32),
            threefold: self.threefold.map(|x| x as f32),
        }
    }
}
