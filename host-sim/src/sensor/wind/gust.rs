//! A gust on top of a wind, of the form that standards of aircraft use.
//!
//! ```text
//! g(t) = ½ G (1 − cos 2π (t − t0)/D)     t0 ≤ t ≤ t0 + D, otherwise 0
//! ```
//!
//! G is reached in the middle and the mean over D is G/2; g and its first derivative are
//! continuous. A negative G is a lull. Sources: EASA CS-25 and 14 CFR 25.341(a), discrete gusts.

use super::direction::towards;
use super::range::{EntryTable, HIGHEST_M_S};
use crate::sensor::error::SensorError;

/// A rise of the wind that comes and goes once.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gust {
    /// After the entry's start.
    pub start_s: f64,
    /// From its start to its end, s.
    pub duration_s: f64,
    /// G, on top of the mean; negative for a lull.
    pub rise_m_s: f64,
    /// Into which it goes; along the mean if not given.
    pub azimuth_deg: Option<f64>,
    /// Its elevation, °; that of the mean if not given.
    pub elevation_deg: Option<f64>,
}

impl Gust {
    /// Speed `time_s` after the entry's start.
    pub(super) fn rise_at_m_s(&self, time_s: f64) -> f64 {
        let phase = (time_s - self.start_s) / self.duration_s;
        if !(0.0..=1.0).contains(&phase) {
            return 0.0;
        }
        0.5 * self.rise_m_s * (1.0 - (std::f64::consts::TAU * phase).cos())
    }

    /// Unit vector of its direction on top of a mean.
    pub(super) fn towards(&self, mean_azimuth_deg: f64, mean_elevation_deg: f64) -> [f64; 3] {
        towards(self.azimuth_deg.unwrap_or(mean_azimuth_deg), self.elevation_deg.unwrap_or(mean_elevation_deg))
    }

    pub(super) fn check(&self, entry: usize, speed_m_s: f64, sample_period_s: f64) -> Result<(), SensorError> {
        let Self { start_s, duration_s, rise_m_s, .. } = *self;
        let (azimuth_deg, elevation_deg) = (self.azimuth_deg.unwrap_or(0.0), self.elevation_deg.unwrap_or(0.0));
        let table = EntryTable { entry, name: "gust" };
        let later = start_s.is_finite() && start_s >= 0.0;
        table.require(later, "start_s", start_s, "0 or more: it counts from the entry's start")?;
        let long = duration_s.is_finite() && duration_s >= 2.0 * sample_period_s;
        table.require(long, "duration_s", duration_s, "two sample periods or more")?;
        let expected = "100 at most, and a lull no more than the entry's `speed_m_s`";
        table.require((-speed_m_s..=HIGHEST_M_S).contains(&rise_m_s), "rise_m_s", rise_m_s, expected)?;
        table.require(azimuth_deg.is_finite(), "azimuth_deg", azimuth_deg, "a finite angle")?;
        table.require((-90.0..=90.0).contains(&elevation_deg), "elevation_deg", elevation_deg, "-90 to 90")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gust_rises_to_its_middle_and_is_smooth_at_its_ends() {
        let gust = Gust { start_s: 2.0, duration_s: 4.0, rise_m_s: 6.0, azimuth_deg: Some(90.0), elevation_deg: None };
        assert_eq!([0.0, 1.99, 2.0, 6.01, 100.0].map(|t| gust.rise_at_m_s(t)), [0.0; 5]);
        assert!((gust.rise_at_m_s(4.0) - 6.0).abs() < 1e-12 && (gust.rise_at_m_s(3.0) - 3.0).abs() < 1e-12);
        // Half of G in the mean; sums of a period of a cosine are exact.
        let mean = (0..400).map(|k| gust.rise_at_m_s(2.005 + 0.01 * f64::from(k))).sum::<f64>() / 400.0;
        assert!((mean - 3.0).abs() < 1e-12, "{mean}");
        // Near an end it begins as G (π t/D)².
        let expected = 6.0 * (std::f64::consts::PI * 1e-3 / 4.0).powi(2);
        assert!((gust.rise_at_m_s(2.001) / expected - 1.0).abs() < 1e-5);
        let [x, y, z] = gust.towards(0.0, 30.0);
        assert!(x.abs() < 1e-15 && (y - 0.75_f64.sqrt()).abs() < 1e-15 && (z - 0.5).abs() < 1e-15);
    }
}
