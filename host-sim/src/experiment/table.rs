//! The experiment file as it is written: every key that there is, before anything is checked. What
//! the simulated sensor takes as it is written is read into the sensor's own types.

use std::collections::BTreeMap;
use std::path::PathBuf;

use dr_core::sensor::Level;
use serde::Deserialize;

use super::sweep::SweepTable;
use crate::sensor::field::{Buoyancy, ElementDrift, GasProperties, Sky, Stem, Sun, SurfaceHeat};
use crate::sensor::{DirectionSwing, DustDevil, Gust, Imperfections, ResistorFault, Sine, TemperatureSwing};
use anemometry::gas::Species;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ExperimentTable {
    pub title: String,
    pub head: PathBuf,
    pub models: Option<PathBuf>,
    #[serde(default)]
    pub observe: bool,
    pub host_timeout_s: Option<f32>,
    pub wind_output: Option<WindOutputTable>,
    pub sample_period_s: f64,
    pub duration_s: f64,
    #[serde(default)]
    pub seed: u64,
    pub gas: GasTable,
    pub support: Option<SupportTable>,
    #[serde(default)]
    pub front_end: Imperfections,
    #[serde(default)]
    pub currents: BTreeMap<String, CurrentsTable>,
    #[serde(default)]
    pub drives: BTreeMap<String, DriveTable>,
    #[serde(default)]
    pub changes: Vec<ChangeTable>,
    pub overheat_alternation: Option<OverheatAlternationTable>,
    #[serde(default)]
    pub wind: Vec<WindTable>,
    pub tunnel: Option<TunnelTable>,
    pub sweep: Option<SweepTable>,
    #[serde(default)]
    pub faults: Vec<FaultTable>,
    #[serde(default)]
    pub surface_heat: Vec<SurfaceHeat>,
    pub sun: Option<Sun>,
    pub sky: Option<Sky>,
    #[serde(default)]
    pub drifts: Vec<ElementDrift>,
    pub buoyancy: Option<Buoyancy>,
    pub stem: Option<Stem>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct WindOutputTable {
    pub bandwidth_hz: Option<f64>,
    pub interval_s: Option<f64>,
    #[serde(default)]
    pub fixed: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct GasTable {
    pub species: Species,
    pub pressure_pa: f64,
    pub temperature_c: f64,
    #[serde(default)]
    pub properties: GasProperties,
    pub swing: Option<TemperatureSwing>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SupportTable {
    pub temperature_c: f64,
    pub swing: Option<TemperatureSwing>,
}

/// Written as a word, or as a table of one key.
#[derive(Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum DriveTable {
    Passive,
    #[serde(with = "LevelName")]
    Level(Level),
    PowerW(f64),
    TemperatureC(f64),
    Prbs {
        order: u8,
        bit_time_s: f64,
        seed: u32,
    },
    Setpoints {
        low_c: f64,
        high_c: f64,
        dwell_s: f64,
        seed: u32,
    },
    Alternation {
        low_c: f64,
        high_c: f64,
        half_s: f64,
    },
}

/// Overheats in turn, of every element that holds a temperature.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct OverheatAlternationTable {
    pub low_k: f64,
    pub high_k: f64,
    pub half_s: f64,
}

/// A level as people write it.
#[derive(Deserialize)]
#[serde(remote = "Level", rename_all = "lowercase")]
enum LevelName {
    Low,
    High,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CurrentsTable {
    pub low_a: f64,
    pub high_a: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ChangeTable {
    pub start_s: f64,
    #[serde(default)]
    pub drives: BTreeMap<String, DriveTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WindTable {
    pub start_s: f64,
    pub label: Option<String>,
    pub speed_m_s: f64,
    #[serde(default)]
    pub azimuth_deg: f64,
    #[serde(default)]
    pub elevation_deg: f64,
    pub swing: Option<DirectionSwing>,
    pub sine: Option<Sine>,
    pub gust: Option<Gust>,
    pub dust_devil: Option<DustDevil>,
    pub turbulence: Option<TurbulenceTable>,
}

/// A spectrum by its name with its scale, or one relaxation by its correlation time.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TurbulenceTable {
    pub spectrum: Option<SpectrumName>,
    pub intensity: f64,
    pub correlation_time_s: Option<f64>,
    pub length_m: Option<f64>,
    pub height_m: Option<f64>,
}

#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "kebab-case")]
pub(super) enum SpectrumName {
    VonKarman,
    Kaimal,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TunnelTable {
    pub track_m: f64,
    pub speeds_m_min: Vec<f64>,
    pub pause_s: f64,
    #[serde(default)]
    pub first_pause_s: f64,
    pub order_seed: Option<u64>,
    /// The sensor's x looks forward: the air comes from there.
    #[serde(default = "from_ahead")]
    pub azimuth_deg: f64,
    #[serde(default)]
    pub elevation_deg: f64,
}

fn from_ahead() -> f64 {
    180.0
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FaultTable {
    pub start_s: f64,
    pub element: String,
    pub kind: ResistorFault,
}
