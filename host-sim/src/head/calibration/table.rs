//! The tables of a calibration as they are written: every key that there is, before anything is checked.

use dr_core::sensor::wind::card::{KNOTS, TERMS};
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
    #[serde(default)]
    pub parts: Vec<PartTable>,
    #[serde(default)]
    pub own: Vec<OwnTable>,
    #[serde(default)]
    pub cross: Vec<CrossTable>,
}

#[derive(Deserialize, Serialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct NusseltTable {
    pub least_reynolds: f64,
    pub most_reynolds: f64,
    /// a_0 … a_5 at Reynolds numbers in geometric progression.
    pub amplitudes: Vec<[f64; 6]>,
}

#[derive(Deserialize, Serialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct CardTable {
    pub least_reynolds: f64,
    pub most_reynolds: f64,
    /// At values of √Re evenly from zero to that of the greatest Reynolds number.
    pub mean: [f64; KNOTS],
    pub difference: [f64; KNOTS],
    pub along: [f64; TERMS],
    pub around: [f64; TERMS],
    pub seen: [f64; TERMS],
    pub mean_share: f64,
    pub difference_share: f64,
}

#[derive(Deserialize, Serialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct PartTable {
    pub element: String,
    pub axis: [f64; 3],
    pub corner: [f64; 3],
    pub area_m2: f64,
    pub means: [f64; 5],
    pub threefold: [f64; 3],
    pub gain: f64,
    pub windless_w_k: f64,
}

#[derive(Deserialize, Serialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct OwnTable {
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
pub struct CrossTable {
    pub from: String,
    pub to: String,
    pub mesh_rad_s: Vec<f64>,
    pub r_k_per_w: Vec<f64>,
    pub surface: Vec<f64>,
}
