//! One entry of the wind: a mean that holds until the next entry, and what blows on top of it.

use super::planned::{DirectionSwing, DustDevil, EntryTable, Gust, HorizontalMean, Sine, added, towards};
use super::turbulence::Turbulence;
use crate::sensor::error::SensorError;

/// A wind that holds from `start_s` to the start of the next entry.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WindEntry {
    /// Since the start of the experiment, s.
    pub start_s: f64,
    /// Name of the conditions; becomes the `event` of a recording.
    pub label: String,
    /// Speed of the mean, m/s.
    pub speed_m_s: f64,
    /// Into which the mean goes, from x to y, °.
    pub azimuth_deg: f64,
    /// Into which the mean goes, above the x-y plane, °.
    pub elevation_deg: f64,
    /// The azimuth oscillates.
    pub swing: Option<DirectionSwing>,
    /// The speed oscillates.
    pub sine: Option<Sine>,
    /// One gust.
    pub gust: Option<Gust>,
    /// One dust devil.
    pub dust_devil: Option<DustDevil>,
    /// Random fluctuations.
    pub turbulence: Option<Turbulence>,
}

impl WindEntry {
    /// Mean wind vector, m/s.
    pub fn mean_m_s(&self) -> [f64; 3] {
        towards(self.azimuth_deg, self.elevation_deg).map(|v| v * self.speed_m_s)
    }

    fn horizontal(&self) -> HorizontalMean {
        let speed_m_s = self.speed_m_s * libm::cos(self.elevation_deg.to_radians());
        HorizontalMean { speed_m_s, azimuth_deg: self.azimuth_deg }
    }

    /// Names of what makes it change by a plan, not by chance.
    pub fn planned(&self) -> Vec<&'static str> {
        let named = [
            (self.swing.is_some(), "swing"),
            (self.sine.is_some(), "sine"),
            (self.gust.is_some(), "gust"),
            (self.dust_devil.is_some(), "dust_devil"),
        ];
        named.into_iter().filter(|(given, _)| *given).map(|(_, name)| name).collect()
    }

    /// Wind without turbulence `time_s` after the entry's start, m/s, and the azimuth of the mean
    /// then, °.
    pub(super) fn planned_m_s(&self, time_s: f64) -> ([f64; 3], f64) {
        let azimuth_deg = self.azimuth_deg + self.swing.map_or(0.0, |swing| swing.angle_deg(time_s));
        let along = towards(azimuth_deg, self.elevation_deg);
        let speed_m_s = self.speed_m_s + self.sine.map_or(0.0, |sine| sine.rise_m_s(time_s));
        let mut wind = along.map(|v| v * speed_m_s);
        if let Some(gust) = self.gust {
            let into = gust.towards(azimuth_deg, self.elevation_deg);
            wind = added(wind, into, gust.rise_at_m_s(time_s));
        }
        if let Some(devil) = self.dust_devil {
            let [x, y] = devil.wind_m_s(time_s, self.horizontal());
            wind = [wind[0] + x, wind[1] + y, wind[2]];
        }
        (wind, azimuth_deg)
    }
}

/// Checks entry `i` of `entries`.
pub(super) fn check(i: usize, entries: &[WindEntry], sample_period_s: f64) -> Result<(), SensorError> {
    let entry = &entries[i];
    let WindEntry { start_s, speed_m_s, azimuth_deg, elevation_deg, .. } = *entry;
    let table = EntryTable { entry: i, name: "" };
    let expected = "0 for the first entry, so that the wind is known from the start";
    table.require(i > 0 || start_s == 0.0, "start_s", start_s, expected)?;
    let after = i == 0 || (start_s > entries[i - 1].start_s && start_s.is_finite());
    table.require(after, "start_s", start_s, "later than the start of the entry before it")?;
    let forward = speed_m_s.is_finite() && speed_m_s >= 0.0;
    table.require(forward, "speed_m_s", speed_m_s, "zero or more; turn the direction instead of the sign")?;
    table.require(azimuth_deg.is_finite(), "azimuth_deg", azimuth_deg, "a finite angle")?;
    table.require((-90.0..=90.0).contains(&elevation_deg), "elevation_deg", elevation_deg, "-90 to 90")?;
    entry.swing.map_or(Ok(()), |swing| swing.check(i, sample_period_s))?;
    entry.sine.map_or(Ok(()), |sine| sine.check(i, speed_m_s, sample_period_s))?;
    entry.gust.map_or(Ok(()), |gust| gust.check(i, speed_m_s, sample_period_s))?;
    entry.dust_devil.map_or(Ok(()), |devil| devil.check(i, entry.horizontal()))?;
    entry.turbulence.map_or(Ok(()), |turbulence| turbulence.check(i, speed_m_s, sample_period_s))
}
