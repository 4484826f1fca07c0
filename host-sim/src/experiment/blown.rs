//! Turbulence as it is written. Ranges are the simulated wind's to judge.

use serde::Deserialize;

use crate::sensor::{Spectrum, Turbulence};
use recording::toml_file::{FileError, TomlSource};

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
    pub fn turbulence(&self, source: &TomlSource, key: &str) -> Result<Turbulence, FileError> {
        let scales =
            [("correlation_time_s", self.correlation_time_s), ("length_m", self.length_m), ("height_m", self.height_m)];
        let (of, (own, scale)) = match self.spectrum {
            None => ("turbulence without a `spectrum`", scales[0]),
            Some(SpectrumName::VonKarman) => ("spectrum \"von-karman\"", scales[1]),
            Some(SpectrumName::Kaimal) => ("spectrum \"kaimal\"", scales[2]),
        };
        if let Some((name, _)) = scales.iter().find(|(name, scale)| scale.is_some() && *name != own) {
            let sentence = format!("does not go with {of}, whose scale is `{own}`");
            return Err(source.refuse(&format!("{key}.{name}"), sentence));
        }
        let missing = || source.refuse(&format!("{key}.{own}"), format!("is missing: it is the scale of {of}"));
        let scale = scale.ok_or_else(missing)?;
        let spectrum = match self.spectrum {
            None => Spectrum::Relaxation { correlation_time_s: scale },
            Some(SpectrumName::VonKarman) => Spectrum::VonKarman { length_m: scale },
            Some(SpectrumName::Kaimal) => Spectrum::Kaimal { height_m: scale },
        };
        Ok(Turbulence { intensity: self.intensity, spectrum })
    }
}
