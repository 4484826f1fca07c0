//! The tables of an experiment's file.

use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DeviceExperimentTable {
    pub title: String,
    pub device: String,
    pub symbol_time_s: f64,
    pub duration_s: f64,
    #[serde(default)]
    pub seed: u64,
    pub unreachable_after_s: Option<f64>,
    pub drive: SymbolDriveTable,
    pub symbols: SymbolsTable,
    #[serde(default)]
    pub changes: Vec<PhaseTable>,
    #[serde(default)]
    pub surroundings: Vec<SurroundingsTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SymbolsTable {
    pub positive_v: f64,
    pub negative_v: f64,
    pub second_share: f64,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum SymbolDriveTable {
    Zero,
    Symbol(i8),
    MeanSymbol(f64),
    Prbs(PrbsTable),
    Hold(HoldTable),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PrbsTable {
    pub order: u8,
    pub bit_time_s: f64,
    pub seed: u32,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct HoldTable {
    pub shift_v: f64,
    #[serde(default = "first")]
    pub order: u8,
    pub gain: Option<f64>,
}

const fn first() -> u8 {
    1
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PhaseTable {
    pub start_s: f64,
    pub drive: SymbolDriveTable,
    pub label: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SurroundingsTable {
    pub start_s: f64,
    pub temperature_c: f64,
    pub humidity_percent: f64,
}
