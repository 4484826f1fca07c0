//! Winds that go to and fro: speed and direction as sines, for how far a sensor can follow.
//!
//! ```text
//! s(t)  = A sin 2πf t          m/s, along the mean
//! az(t) = az + B sin 2πf t     °
//! ```
//!
//! t counts from the entry's start, so that both begin at the mean. Turbulence of a spectrum, and a
//! gust without a direction of its own, turn with it.

use super::range::EntryTable;
use crate::sensor::error::SensorError;

/// Of the speed.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sine {
    /// Amplitude, m/s.
    pub amplitude_m_s: f64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
}

/// Of the azimuth.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DirectionSwing {
    /// Amplitude, °.
    pub amplitude_deg: f64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
}

impl Sine {
    pub(super) fn rise_m_s(&self, time_s: f64) -> f64 {
        self.amplitude_m_s * (std::f64::consts::TAU * self.frequency_hz * time_s).sin()
    }

    pub(super) fn check(&self, entry: usize, speed_m_s: f64, sample_period_s: f64) -> Result<(), SensorError> {
        let (table, amplitude_m_s) = (EntryTable { entry, name: "sine" }, self.amplitude_m_s);
        let expected = "0 to the entry's `speed_m_s`, so that the wind does not turn";
        table.require((0.0..=speed_m_s).contains(&amplitude_m_s), "amplitude_m_s", amplitude_m_s, expected)?;
        check_frequency(table, self.frequency_hz, sample_period_s)
    }
}

impl DirectionSwing {
    pub(super) fn angle_deg(&self, time_s: f64) -> f64 {
        self.amplitude_deg * (std::f64::consts::TAU * self.frequency_hz * time_s).sin()
    }

    pub(super) fn check(&self, entry: usize, sample_period_s: f64) -> Result<(), SensorError> {
        let (table, amplitude_deg) = (EntryTable { entry, name: "swing" }, self.amplitude_deg);
        table.require((0.0..=180.0).contains(&amplitude_deg), "amplitude_deg", amplitude_deg, "0 to 180")?;
        check_frequency(table, self.frequency_hz, sample_period_s)
    }
}

/// Refuses a frequency that sample periods cannot carry.
fn check_frequency(table: EntryTable, frequency_hz: f64, sample_period_s: f64) -> Result<(), SensorError> {
    // A millionth for a half sample rate that is one but for rounding.
    let right = frequency_hz > 0.0 && frequency_hz * sample_period_s <= 0.5 * (1.0 + 1e-6);
    table.require(right, "frequency_hz", frequency_hz, "more than 0 and at most half the sample rate")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speed_and_direction_swing_about_the_mean() {
        let sine = Sine { amplitude_m_s: 2.0, frequency_hz: 0.5 };
        assert_eq!(sine.rise_m_s(0.0), 0.0);
        assert!((sine.rise_m_s(0.5) - 2.0).abs() < 1e-12 && (sine.rise_m_s(1.5) + 2.0).abs() < 1e-12);
        let swing = DirectionSwing { amplitude_deg: 30.0, frequency_hz: 2.0 };
        assert!((swing.angle_deg(0.125) - 30.0).abs() < 1e-12 && swing.angle_deg(0.5).abs() < 1e-12);
    }
}
