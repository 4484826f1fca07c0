//! How a meter is set up.

use super::error::MeterError;
use std::time::Duration;

/// How a meter measures, and what it may apply.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeterSettings {
    /// Frequency of the oscillator, Hz.
    pub frequency_hz: f64,
    /// Level of the oscillator, V rms. It pulls at the membrane as a bias does.
    pub level_v: f64,
    /// Largest bias of either sign that may reach the device, V.
    pub most_bias_v: f64,
    /// How long a connection or an answer may take, s: longer than a measurement and a reset, which
    /// take up to a second at low frequencies.
    pub timeout_s: f64,
}

impl MeterSettings {
    /// The time-out.
    pub(super) fn check(&self) -> Result<Duration, MeterError> {
        let positive = [("frequency_hz", self.frequency_hz), ("level_v", self.level_v), ("timeout_s", self.timeout_s)];
        let wrong = positive.into_iter().find(|(_, value)| !(value.is_finite() && *value > 0.0));
        if let Some((name, value)) = wrong {
            return Err(MeterError::Unusable(format!("{name} is {value}: a number above 0 is needed")));
        }
        if !(self.most_bias_v.is_finite() && self.most_bias_v >= 0.0) {
            let value = self.most_bias_v;
            return Err(MeterError::Unusable(format!("most_bias_v is {value}: a number from 0 is needed")));
        }
        // A socket refuses a time-out of zero, which a very small one would round to.
        let timeout = Duration::try_from_secs_f64(self.timeout_s).unwrap_or(Duration::MAX);
        if timeout < Duration::from_millis(1) || timeout > Duration::from_secs(3600) {
            let value = self.timeout_s;
            return Err(MeterError::Unusable(format!("timeout_s is {value}: 0.001 to 3600 is possible")));
        }
        Ok(timeout)
    }

    /// Whether a bias may be applied.
    pub(super) fn allow(&self, bias_v: f64) -> Result<(), MeterError> {
        let most_v = self.most_bias_v;
        // Also refuses what is not a number.
        if bias_v.abs() <= most_v {
            return Ok(());
        }
        Err(MeterError::Unusable(format!("a bias of {bias_v} V is beyond most_bias_v, which is {most_v} V")))
    }
}
