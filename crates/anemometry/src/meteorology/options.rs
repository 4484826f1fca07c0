//! What is averaged, and how.

use recording::head_mounting::HeadMounting;

/// Intervals, mounting, and what fluxes need.
#[derive(Debug, Clone, PartialEq)]
pub struct AveragingOptions {
    /// Length of an interval, s.
    pub interval_s: f64,
    /// Estimates before do not count, and the first interval begins there, s.
    pub from_s: f64,
    /// How the head is mounted; directions count from its x axis where that is not known.
    pub mounting: Option<HeadMounting>,
    /// Height above the ground, m, for fluxes.
    pub height_m: Option<f64>,
    /// Bandwidth of the wind, Hz, in place of that which the recording states.
    pub bandwidth_hz: Option<f64>,
    /// Bandwidth of the gas temperature, Hz.
    pub temperature_bandwidth_hz: Option<f64>,
    /// m/s².
    pub gravity_m_s2: f64,
}
