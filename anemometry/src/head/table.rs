//! The head file as it is written: every key that there is, before anything is checked.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::calibration::table::CalibrationTable;
use super::error::PlatinumError;
use super::nominal::PlatinumKind;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct HeadTable {
    pub name: String,
    pub sensor: Option<String>,
    pub adc: AdcTable,
    pub guard: GuardTable,
    /// Any word may be a kind.
    #[serde(default)]
    pub kinds: BTreeMap<String, ElementTable>,
    #[serde(default)]
    pub elements: Vec<ElementTable>,
    pub calibration: Option<CalibrationTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AdcTable {
    pub full_scale_v: f64,
    pub bits: u8,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct GuardTable {
    pub missing_limit_ticks: u32,
    pub unreachable_limit_s: f64,
    pub stuck_limit_ticks: Option<u32>,
}

/// An element, or what the elements of a kind share.
#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct ElementTable {
    pub name: Option<String>,
    pub kind: Option<String>,
    pub normal: Option<[f64; 3]>,
    pub platinum: Option<PlatinumTable>,
    pub current_low_a: Option<f64>,
    pub current_high_a: Option<f64>,
    pub resistance_min_ohm: Option<f64>,
    pub resistance_max_ohm: Option<f64>,
    pub temperature_max_c: Option<f64>,
    pub layers: Option<u8>,
}

#[derive(Deserialize, Clone, Copy)]
#[serde(deny_unknown_fields)]
pub(super) struct PlatinumTable {
    pub characteristic: Characteristic,
    pub resistance_0c_ohm: f64,
    pub coefficient_per_c: Option<f64>,
}

#[derive(Deserialize, Clone, Copy, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub(super) enum Characteristic {
    Linear,
    Iec60751,
}

impl PlatinumTable {
    pub fn kind(&self) -> Result<PlatinumKind, PlatinumError> {
        let resistance_0c_ohm = self.resistance_0c_ohm;
        match (self.characteristic, self.coefficient_per_c) {
            (Characteristic::Linear, Some(coefficient_per_c)) => {
                Ok(PlatinumKind::Linear { resistance_0c_ohm, coefficient_per_c })
            }
            (Characteristic::Linear, None) => Err(PlatinumError::NoCoefficient),
            (Characteristic::Iec60751, None) => Ok(PlatinumKind::Iec60751 { resistance_0c_ohm }),
            (Characteristic::Iec60751, Some(_)) => Err(PlatinumError::Coefficient),
        }
    }
}
