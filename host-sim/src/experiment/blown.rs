//! What blows on top of a `[[wind]]`'s mean, as it is written. Ranges are the simulated wind's to
//! judge.

use serde::Deserialize;

use crate::sensor::{DirectionSwing, DustDevil, Gust, Sine, Spectrum, Turbulence};
use recording::toml_file::{FileError, TomlSource};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SwingTable {
    amplitude_deg: f64,
    frequency_hz: f64,
}

impl From<SwingTable> for DirectionSwing {
    fn from(SwingTable { amplitude_deg, frequency_hz }: SwingTable) -> Self {
        Self { amplitude_deg, frequency_hz }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SineTable {
    amplitude_m_s: f64,
    frequency_hz: f64,
}

impl From<SineTable> for Sine {
    fn from(SineTable { amplitude_m_s, frequency_hz }: SineTable) -> Self {
        Self { amplitude_m_s, frequency_hz }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct GustTable {
    pub start_s: f64,
    duration_s: f64,
    rise_m_s: f64,
    azimuth_deg: Option<f64>,
    elevation_deg: Option<f64>,
}

impl From<GustTable> for Gust {
    fn from(GustTable { start_s, duration_s, rise_m_s, azimuth_deg, elevation_deg }: GustTable) -> Self {
        Self { start_s, duration_s, rise_m_s, azimuth_deg, elevation_deg }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DustDevilTable {
    pub time_s: f64,
    miss_m: f64,
    core_radius_m: f64,
    swirl_m_s: f64,
    #[serde(default)]
    inflow_m_s: f64,
    travel_m_s: Option<f64>,
    travel_azimuth_deg: Option<f64>,
}

impl From<DustDevilTable> for DustDevil {
    fn from(table: DustDevilTable) -> Self {
        let DustDevilTable { time_s, miss_m, core_radius_m, swirl_m_s, inflow_m_s, travel_m_s, travel_azimuth_deg } =
            table;
        Self { time_s, miss_m, core_radius_m, swirl_m_s, inflow_m_s, travel_m_s, travel_azimuth_deg }
    }
}

/// A spectrum by its name with its scale, or one relaxation by its correlation time.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TurbulenceTable {
    spectrum: Option<SpectrumName>,
    intensity: f64,
    correlation_time_s: Option<f64>,
    length_m: Option<f64>,
    height_m: Option<f64>,
}

#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "kebab-case")]
enum SpectrumName {
    VonKarman,
    Kaimal,
}

impl TurbulenceTable {
    /// Refuses scales of another spectrum under `key`.
    pub fn turbulence(self, source: &TomlSource, key: &str) -> Result<Turbulence, FileError> {
        let of = match self.spectrum {
            None => "turbulence without a `spectrum`",
            Some(SpectrumName::VonKarman) => "spectrum \"von-karman\"",
            Some(SpectrumName::Kaimal) => "spectrum \"kaimal\"",
        };
        let own = match self.spectrum {
            None => "correlation_time_s",
            Some(SpectrumName::VonKarman) => "length_m",
            Some(SpectrumName::Kaimal) => "height_m",
        };
        let mut found = None;
        for (name, value) in
            [("correlation_time_s", self.correlation_time_s), ("length_m", self.length_m), ("height_m", self.height_m)]
        {
            match value {
                Some(_) if name != own => {
                    let sentence = format!("does not go with {of}, whose scale is `{own}`");
                    return Err(source.refuse(&format!("{key}.{name}"), sentence));
                }
                Some(value) => found = Some(value),
                None => {}
            }
        }
        let Some(scale) = found else {
            return Err(source.refuse(&format!("{key}.{own}"), format!("is missing: it is the scale of {of}")));
        };
        let spectrum = match self.spectrum {
            None => Spectrum::Relaxation { correlation_time_s: scale },
            Some(SpectrumName::VonKarman) => Spectrum::VonKarman { length_m: scale },
            Some(SpectrumName::Kaimal) => Spectrum::Kaimal { height_m: scale },
        };
        Ok(Turbulence { intensity: self.intensity, spectrum })
    }
}
