//! The head file as it is written: every key that there is, before anything is checked.

use std::collections::BTreeMap;

use recording::toml_file::exactly_if_any;
use serde::Deserialize;

use super::body::table::BodyTable;
use super::calibration::table::CalibrationTable;
use super::nominal::PlatinumKind;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct HeadTable {
    pub name: String,
    pub sensor: Option<String>,
    pub heading_deg: Option<f64>,
    #[serde(default, deserialize_with = "exactly_if_any")]
    pub up: Option<[f64; 3]>,
    pub adc: AdcTable,
    pub guard: GuardTable,
    /// Any word may be a kind.
    #[serde(default)]
    pub kinds: BTreeMap<String, ElementTable>,
    #[serde(default)]
    pub elements: Vec<ElementTable>,
    pub body: Option<BodyTable>,
    pub calibration: Option<CalibrationTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AdcTable {
    pub full_scale_v: f64,
    pub bits: u8,
    pub compliance_v: Option<f64>,
}

/// When readings trip.
#[derive(Deserialize, Clone, Copy, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct GuardTable {
    /// Fresh readings that may be missing in a row.
    pub missing_limit_ticks: u32,
    /// How long a regulated element may request the high level only, s.
    pub unreachable_limit_s: f64,
    /// Equal readings in a row that trip; 0: never.
    #[serde(default)]
    pub stuck_limit_ticks: u32,
}

/// An element, or what the elements of a kind share.
#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct ElementTable {
    pub name: Option<String>,
    pub kind: Option<String>,
    #[serde(default, deserialize_with = "exactly_if_any")]
    pub normal: Option<[f64; 3]>,
    pub platinum: Option<PlatinumKind>,
    pub current_low_a: Option<f64>,
    pub current_high_a: Option<f64>,
    pub current_high_nominal_a: Option<f64>,
    pub resistance_min_ohm: Option<f64>,
    pub resistance_max_ohm: Option<f64>,
    pub temperature_max_c: Option<f64>,
    pub sustained_power_w: Option<f64>,
    pub energy_j: Option<f64>,
    pub layers: Option<u8>,
    pub only_senses: Option<bool>,
}
