//! The winds of an experiment entry by entry, as they are written. Ranges of what blows on top of
//! a mean are the simulated wind's to judge.

use super::grid::TickGrid;
use super::table::{SpectrumName, TurbulenceTable, WindTable};
use super::wind::HIGHEST_SPEED_M_S;
use crate::sensor::{Spectrum, Turbulence, WindEntry};
use recording::toml_file::{FileError, TomlSource};

/// The entries of `[[wind]]`.
pub(super) fn entries(grid: &TickGrid, tables: &[WindTable]) -> Result<Vec<WindEntry>, FileError> {
    let source = grid.source;
    let mut entries = Vec::with_capacity(tables.len());
    let ends = tables.iter().skip(1).map(|next| next.start_s).chain([grid.end_s()]);
    for ((index, table), end_s) in tables.iter().enumerate().zip(ends) {
        let key = format!("wind[{index}]");
        // Starts, angles and what blows on top are the simulated wind's to judge.
        source.within(&format!("{key}.speed_m_s"), table.speed_m_s, 0.0..=HIGHEST_SPEED_M_S, "m/s")?;
        grid.check_start(&format!("{key}.start_s"), table.start_s)?;
        // What nobody would feel is a mistake.
        let lasts_s = end_s - table.start_s;
        let gust = table.gust.map(|gust| ("gust.start_s", gust.start_s));
        let devil = table.dust_devil.map(|devil| ("dust_devil.time_s", devil.time_s));
        for (what, time_s) in gust.into_iter().chain(devil) {
            if lasts_s > 0.0 && time_s >= lasts_s {
                let sentence = format!("is {time_s} s after the start of a wind that is over after {lasts_s} s");
                return Err(source.refuse(&format!("{key}.{what}"), sentence));
            }
        }
        let turbulence = table.turbulence.as_ref().map(|table| table.turbulence(source, &format!("{key}.turbulence")));
        entries.push(WindEntry {
            start_s: table.start_s,
            // After its number, so that every event of a recording has a name.
            label: table.label.clone().unwrap_or_else(|| format!("wind {}", index + 1)),
            speed_m_s: table.speed_m_s,
            azimuth_deg: table.azimuth_deg,
            elevation_deg: table.elevation_deg,
            swing: table.swing,
            sine: table.sine,
            gust: table.gust,
            dust_devil: table.dust_devil,
            turbulence: turbulence.transpose()?,
        });
    }
    Ok(entries)
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
