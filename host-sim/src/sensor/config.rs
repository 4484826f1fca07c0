//! Configuration of a simulated sensor: body, gas, support, resistors, front end, wind and faults.
//!
//! The temperature of a gas or of a support may swing about its mean:
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
//! A gas takes along the temperature that every surface gives its heat to, and the properties of
//! the gas at constant pressure, density, viscosity, conductivity and heat capacity, in the
//! convection. The surroundings that the surfaces radiate to and the support stay at their own
//! temperatures, as walls of a tunnel do that are heavier than its gas. A support takes along the
//! far ends of the rods that lead there, and nothing else.
//!
//! Limits: one temperature everywhere in the gas, held over each sample period as the wind is;
//! convection answers at once.

use std::f64::consts::TAU;

use anemometry::gas::Species;
use anemometry::head::{NominalElement, PlatinumKind};

use super::construction::Construction;
use super::error::{SensorError, require};
use super::field::FieldEffects;
use super::front_end::{Imperfections, ResistorFault};
use super::wind::WindEntry;

/// Everything that a simulated sensor is made from. The default is sphere B in still carbon dioxide
/// of 1000 Pa and −53.15 °C, with a perfect front end.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorConfig {
    /// The body.
    pub construction: Construction,
    /// Seed of noise, turbulence and resistor errors.
    pub seed: u64,
    /// Sample period, s.
    pub sample_period_s: f64,
    /// The gas.
    pub species: Species,
    /// Its pressure, Pa.
    pub pressure_pa: f64,
    /// The mean, of a gas that swings.
    pub gas_temperature_c: f64,
    /// Oscillation of its temperature, if there is one.
    pub gas_swing: Option<TemperatureSwing>,
    /// Temperature of the support, °C; the mean, if it swings.
    pub support_temperature_c: f64,
    /// Oscillation, if there is one.
    pub support_swing: Option<TemperatureSwing>,
    /// One for each of the construction's [`elements`](Construction::elements), in their order.
    pub elements: Vec<NominalElement>,
    /// Step of the converter, V.
    pub volt_per_code: f64,
    /// Errors and noise of the front end.
    pub imperfections: Imperfections,
    /// In order of `start_s`, the first at 0; none at all is still gas.
    pub wind: Vec<WindEntry>,
    /// Resistors that break.
    pub faults: Vec<TimedFault>,
    /// Effects of the field; none by default.
    pub field: FieldEffects,
}

/// A fault that an element has from `start_s` on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedFault {
    /// Number of the element, from 0.
    pub element: usize,
    /// Fault.
    pub fault: ResistorFault,
    /// When, s.
    pub start_s: f64,
}

impl Default for SensorConfig {
    fn default() -> SensorConfig {
        let construction = Construction::default();
        let element = NominalElement {
            platinum: PlatinumKind::Linear { resistance_0c_ohm: 175.0, coefficient_per_c: 0.0031 },
            current_low_a: 3e-3,
            current_high_a: 16e-3,
        };
        SensorConfig {
            elements: vec![element; construction.elements().len()],
            construction,
            seed: 0,
            sample_period_s: 0.01,
            species: Species::CarbonDioxide,
            pressure_pa: 1000.0,
            gas_temperature_c: -53.15,
            gas_swing: None,
            support_temperature_c: -43.15,
            support_swing: None,
            volt_per_code: 4.0 / 8_388_608.0,
            imperfections: Imperfections::default(),
            wind: Vec::new(),
            faults: Vec::new(),
            field: FieldEffects::default(),
        }
    }
}

/// Shortest period in sample periods: a sine that is held in fewer steps would be another swing.
const LEAST_SAMPLE_PERIODS: f64 = 20.0;

/// Swing of the temperature of a gas or a support.
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

    /// Distance from its mean, K.
    pub fn offset_k(&self, time_s: f64) -> f64 {
        let since_s = (time_s - self.start_s).max(0.0);
        self.amplitude_k * libm::sin(TAU * (since_s / self.period_s).fract())
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
