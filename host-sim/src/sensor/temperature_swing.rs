//! A gas, or a support, whose temperature swings about its mean.
//!
//! ```text
//! T(t) = T_mean + A sin(2π (t − t_start) / P)      from t_start on, T_mean before
//! ```
//!
//! | symbol | key | unit |
//! |---|---|---|
//! | A | `amplitude_k` | K |
//! | P | `period_s` | s |
//! | t_start | `start_s` | s |
//!
//! What follows a gas: the temperature that every surface gives its heat to, and the properties of
//! the gas at constant pressure, density, viscosity, conductivity and heat capacity, in the
//! convection. What does not: the surroundings that the surfaces radiate to and the support stay at
//! their own temperatures, as walls of a tunnel do that are heavier than its gas. What follows a
//! support: the far ends of the rods that lead there, and nothing else.
//!
//! Limits: one temperature everywhere in the gas, held over each sample period as the wind is;
//! convection answers at once.

use std::f64::consts::TAU;

use super::error::{SensorError, require};

/// Shortest period in sample periods: a sine that is held in fewer steps would be another swing.
const LEAST_SAMPLE_PERIODS: f64 = 20.0;

/// How the temperature of a gas or a support swings.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TemperatureSwing {
    /// Amplitude about the mean, K.
    pub amplitude_k: f64,
    /// Period, s.
    pub period_s: f64,
    /// Before, it stands still.
    #[serde(default)]
    pub start_s: f64,
}

impl TemperatureSwing {
    /// Refuses numbers that make no swing, by their keys in the table `of` the gas or the support.
    pub fn check(&self, of: &str, sample_period_s: f64) -> Result<(), SensorError> {
        let Self { amplitude_k, period_s, start_s } = *self;
        let key = |name: &str| format!("{of}.swing.{name}");
        let expected = format!("more than 0; a {of} that stands still has no `swing`");
        require(amplitude_k.is_finite() && amplitude_k > 0.0, &key("amplitude_k"), amplitude_k, &expected)?;
        let slow = period_s.is_finite() && period_s >= LEAST_SAMPLE_PERIODS * sample_period_s;
        let expected = format!("at least 20 sample periods, as the {of} is held over each of them");
        require(slow, &key("period_s"), period_s, &expected)?;
        require(start_s.is_finite() && start_s >= 0.0, &key("start_s"), start_s, "zero or more")
    }

    /// How far it is from its mean, K.
    pub fn offset_k(&self, time_s: f64) -> f64 {
        let since_s = (time_s - self.start_s).max(0.0);
        self.amplitude_k * (TAU * (since_s / self.period_s).fract()).sin()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SWING: TemperatureSwing = TemperatureSwing { amplitude_k: 5.0, period_s: 600.0, start_s: 100.0 };

    #[test]
    fn stands_still_before_its_start_and_swings_about_the_mean_from_there() {
        for (time_s, expected_k) in [
            (0.0, 0.0),
            (99.0, 0.0),
            (100.0, 0.0),
            (150.0, 2.5),
            (250.0, 5.0),
            (400.0, 0.0),
            (550.0, -5.0),
            (6250.0, 5.0),
        ] {
            // Rounding of a sine whose argument is a few turns.
            assert!((SWING.offset_k(time_s) - expected_k).abs() < 1e-12, "{time_s}: {}", SWING.offset_k(time_s));
        }
    }

    #[test]
    fn refuses_what_is_no_swing_by_name() {
        let sentence = |swing: TemperatureSwing| swing.check("gas", 0.01).unwrap_err().to_string();
        assert!(sentence(TemperatureSwing { amplitude_k: 0.0, ..SWING }).contains("`gas.swing.amplitude_k` is 0"));
        assert!(
            sentence(TemperatureSwing { amplitude_k: f64::NAN, ..SWING }).contains("`gas.swing.amplitude_k` is NaN")
        );
        assert!(sentence(TemperatureSwing { period_s: 0.1, ..SWING }).contains("`gas.swing.period_s` is 0.1"));
        assert!(
            sentence(TemperatureSwing { period_s: f64::INFINITY, ..SWING }).contains("`gas.swing.period_s` is inf")
        );
        assert!(sentence(TemperatureSwing { start_s: -1.0, ..SWING }).contains("`gas.swing.start_s` is -1"));
        assert_eq!(TemperatureSwing { period_s: 0.2, ..SWING }.check("gas", 0.01), Ok(()));
    }
}
