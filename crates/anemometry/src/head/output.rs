//! Bandwidth and interval at which a calibrated head outputs wind estimates.

/// Bandwidth and interval of the wind estimates of a calibrated head.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindOutput {
    /// −3 dB of the convective powers, Hz.
    pub bandwidth_hz: f64,
    /// Time between two estimates, s.
    pub interval_s: f64,
    /// Whether the bandwidth stays, whatever the wind does; else it rises for a while after a jump.
    pub fixed: bool,
}

impl WindOutput {
    /// Bandwidth of who requests none, Hz.
    pub const DEFAULT_BANDWIDTH_HZ: f64 = 2.0;
    /// Bandwidths that may be requested, Hz.
    pub const BANDWIDTHS_HZ: std::ops::RangeInclusive<f64> = 0.5..=50.0;
    const DEFAULT_INTERVAL_S: f64 = 0.01;

    /// Defaults stand for numbers that are not requested: as fast as the loops, and smooth.
    pub fn new(bandwidth_hz: Option<f64>, interval_s: Option<f64>, fixed: bool, sample_period_s: f64) -> Self {
        Self {
            bandwidth_hz: bandwidth_hz.unwrap_or(Self::DEFAULT_BANDWIDTH_HZ),
            interval_s: interval_s.unwrap_or(Self::DEFAULT_INTERVAL_S.max(sample_period_s)),
            fixed,
        }
    }
}
