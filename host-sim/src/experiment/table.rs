//! The experiment file as it is written: every key that there is, before anything is checked.

use std::collections::BTreeMap;
use std::path::PathBuf;

use dr_core::sensor::Level;
use serde::Deserialize;

use super::blown::{DustDevilTable, GustTable, SineTable, SwingTable, TurbulenceTable};
use super::sweep::SweepTable;
use crate::sensor::{GasSwing, Imperfections, ResistorFault, WindEntry};
use anemometry::gas::Species;
use recording::toml_file::{FileError, TomlSource};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ExperimentTable {
    pub title: String,
    pub head: PathBuf,
    pub models: Option<PathBuf>,
    #[serde(default)]
    pub observe: bool,
    pub wind_output: Option<WindOutputTable>,
    /// Name of `wind_output` before version 0.2.
    pub answer: Option<AnswerTable>,
    pub sample_period_s: f64,
    pub duration_s: f64,
    #[serde(default)]
    pub seed: u64,
    pub gas: GasTable,
    pub support: Option<SupportTable>,
    #[serde(default)]
    pub front_end: FrontEndTable,
    #[serde(default)]
    pub currents: BTreeMap<String, CurrentsTable>,
    #[serde(default)]
    pub drives: BTreeMap<String, DriveTable>,
    #[serde(default)]
    pub changes: Vec<ChangeTable>,
    #[serde(default)]
    pub wind: Vec<WindTable>,
    pub tunnel: Option<TunnelTable>,
    pub sweep: Option<SweepTable>,
    #[serde(default)]
    pub faults: Vec<FaultTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WindOutputTable {
    pub bandwidth_hz: Option<f64>,
    pub interval_s: Option<f64>,
    #[serde(default)]
    pub fixed: bool,
}

/// The older table of the same meaning.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AnswerTable {
    bandwidth_hz: Option<f64>,
    every_s: Option<f64>,
    #[serde(default)]
    fixed: bool,
}

impl From<AnswerTable> for WindOutputTable {
    fn from(AnswerTable { bandwidth_hz, every_s, fixed }: AnswerTable) -> Self {
        Self { bandwidth_hz, interval_s: every_s, fixed }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct GasTable {
    pub species: Species,
    pub pressure_pa: f64,
    pub temperature_c: f64,
    pub swing: Option<GasSwingTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct GasSwingTable {
    amplitude_k: f64,
    period_s: f64,
    #[serde(default)]
    start_s: f64,
}

impl From<GasSwingTable> for GasSwing {
    fn from(GasSwingTable { amplitude_k, period_s, start_s }: GasSwingTable) -> Self {
        Self { amplitude_k, period_s, start_s }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SupportTable {
    pub temperature_c: f64,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
pub(super) struct FrontEndTable {
    noise_v_rms: f64,
    resistance_error_percent: f64,
    coefficient_error_percent: f64,
    current_error_percent: f64,
}

impl From<FrontEndTable> for Imperfections {
    fn from(table: FrontEndTable) -> Self {
        let FrontEndTable { noise_v_rms, resistance_error_percent, coefficient_error_percent, current_error_percent } =
            table;
        Self { noise_v_rms, resistance_error_percent, coefficient_error_percent, current_error_percent }
    }
}

/// Written as a word, or as a table of one key.
#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum DriveTable {
    Passive,
    Level(LevelName),
    PowerW(f64),
    TemperatureC(f64),
    Prbs(PrbsTable),
    Setpoints(SetpointsTable),
}

#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "lowercase")]
pub(super) enum LevelName {
    Low,
    High,
}

impl From<LevelName> for Level {
    fn from(name: LevelName) -> Self {
        match name {
            LevelName::Low => Self::Low,
            LevelName::High => Self::High,
        }
    }
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
pub(super) struct PrbsTable {
    pub order: u8,
    pub bit_time_s: f64,
    pub seed: u32,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SetpointsTable {
    pub low_c: f64,
    pub high_c: f64,
    pub dwell_s: f64,
    pub seed: u32,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WindTable {
    pub start_s: f64,
    label: Option<String>,
    pub speed_m_s: f64,
    #[serde(default)]
    azimuth_deg: f64,
    #[serde(default)]
    elevation_deg: f64,
    swing: Option<SwingTable>,
    sine: Option<SineTable>,
    gust: Option<GustTable>,
    dust_devil: Option<DustDevilTable>,
    turbulence: Option<TurbulenceTable>,
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

impl WindTable {
    /// Times in it that count from its start, by their keys.
    pub fn moments(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let gust = self.gust.as_ref().map(|gust| ("gust.start_s", gust.start_s));
        gust.into_iter().chain(self.dust_devil.as_ref().map(|devil| ("dust_devil.time_s", devil.time_s)))
    }

    /// An entry without a label is called after its number, so that every event of a recording has
    /// a name.
    pub fn entry(self, index: usize, source: &TomlSource) -> Result<WindEntry, FileError> {
        let turbulence = self.turbulence.map(|table| table.turbulence(source, &format!("wind[{index}].turbulence")));
        Ok(WindEntry {
            start_s: self.start_s,
            label: self.label.unwrap_or_else(|| format!("wind {}", index + 1)),
            speed_m_s: self.speed_m_s,
            azimuth_deg: self.azimuth_deg,
            elevation_deg: self.elevation_deg,
            swing: self.swing.map(Into::into),
            sine: self.sine.map(Into::into),
            gust: self.gust.map(Into::into),
            dust_devil: self.dust_devil.map(Into::into),
            turbulence: turbulence.transpose()?,
        })
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FaultTable {
    pub start_s: f64,
    pub element: String,
    pub kind: FaultName,
}

#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "lowercase")]
pub(super) enum FaultName {
    Open,
    Shorted,
}

impl From<FaultName> for ResistorFault {
    fn from(name: FaultName) -> Self {
        match name {
            FaultName::Open => Self::Open,
            FaultName::Shorted => Self::Shorted,
        }
    }
}
