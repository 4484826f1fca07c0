//! One element's reading: from ADC code to resistance and heating power.
//!
//! The same resistor heats and senses (theory: thesis ch. 4), so its resistance is R = V/I with the
//! current that flowed in that sample, and the power it gives off is I²R: it drifts with R(T) and
//! is worked out every tick.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | V = code · `volt_per_code` | voltage across the resistor | V |
//! | I | current of the level that was on | A |

use super::platinum::Platinum;
use crate::error::{self, ConfigError, Parameter};

/// Reading of one element in one tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Reading {
    /// A fresh conversion, two's complement, 24 bit or fewer.
    Code(i32),
    /// The front end responds, but has converted nothing since the last tick.
    Stale,
    /// The front end did not respond, or its data were damaged.
    Missing,
}

/// Input of the converters of the front end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum FrontEndInput {
    /// The elements.
    #[default]
    Element,
    /// Both inputs of each converter connected to each other.
    Shorted,
    /// A known voltage of the front end, scaled so that it nominally reads [`REFERENCE_CODE`].
    Reference,
}

/// Reading of [`FrontEndInput::Reference`] if voltage and converter are right: half the scale of a
/// converter of 24 bit.
pub const REFERENCE_CODE: i32 = 1 << 22;

/// One of the two currents of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Level {
    /// The sensing current; also what a heater that is off still carries.
    #[default]
    Low,
    /// The heating current.
    High,
}

/// Wiring of one element: its resistor, its two currents and the ADC's scale. Checked when it is
/// made.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Channel {
    platinum: Platinum,
    volt_per_code: f32,
    current_low_a: f32,
    current_high_a: f32,
}

impl Channel {
    /// A channel with `volt_per_code` V a code and its two currents in A.
    ///
    /// # Errors
    /// Names the parameter that is not greater than zero or absurdly large (1 V a code, 1 A, 1 MΩ
    /// at 0 °C: with them no power can overflow), or a high current that is not above the low one.
    pub fn new(
        platinum: Platinum,
        volt_per_code: f32,
        current_low_a: f32,
        current_high_a: f32,
    ) -> Result<Self, ConfigError> {
        error::positive(Parameter::VoltPerCode, volt_per_code)?;
        error::within(Parameter::VoltPerCode, volt_per_code, 0.0, 1.0)?;
        error::positive(Parameter::CurrentLowA, current_low_a)?;
        error::ascending((Parameter::CurrentLowA, current_low_a), (Parameter::CurrentHighA, current_high_a))?;
        error::within(Parameter::CurrentHighA, current_high_a, 0.0, 1.0)?;
        Ok(Self { platinum: platinum.checked()?, volt_per_code, current_low_a, current_high_a })
    }

    pub(crate) fn checked(self) -> Result<Self, ConfigError> {
        Self::new(self.platinum, self.volt_per_code, self.current_low_a, self.current_high_a)
    }

    /// The resistor's characteristic.
    pub const fn platinum(&self) -> &Platinum {
        &self.platinum
    }

    /// The current that a level sends through the resistor, A.
    pub const fn current_a(&self, level: Level) -> f32 {
        match level {
            Level::Low => self.current_low_a,
            Level::High => self.current_high_a,
        }
    }

    /// Resistance in Ω from a code that was taken while `level` was on.
    pub fn resistance_ohm(&self, code: i32, level: Level) -> f32 {
        // A 24-bit code is exact in f32.
        self.volt(code as f32) / self.current_a(level)
    }

    /// Voltage in V of a code, or of a mean of codes.
    pub fn volt(&self, code: f32) -> f32 {
        code * self.volt_per_code
    }

    /// Voltage in V over a resistance in Ω at a level.
    pub fn volt_of_resistance(&self, resistance_ohm: f32, level: Level) -> f32 {
        resistance_ohm * self.current_a(level)
    }

    /// Heating power in W of a resistance in Ω at a level: I²R.
    pub fn power_w(&self, resistance_ohm: f32, level: Level) -> f32 {
        let current_a = self.current_a(level);
        current_a * current_a * resistance_ohm
    }

    /// Heating power in W at a temperature in °C with the current at a level.
    pub fn power_at_w(&self, temperature_c: f32, level: Level) -> f32 {
        self.power_w(self.platinum.resistance_ohm(temperature_c), level)
    }

    /// Heating power in W at the low level and a temperature in °C: what an element has in standby.
    pub fn standing_power_w(&self, temperature_c: f32) -> f32 {
        self.power_at_w(temperature_c, Level::Low)
    }
}

crate::fields::fields!(enum Level { 0 Low, 1 High });

#[cfg(test)]
mod tests {
    use super::*;

    fn channel() -> Channel {
        Channel::new(Platinum::linear(175.0, 0.0031).unwrap(), 4.0 / 8_388_608.0, 3e-3, 16e-3).unwrap()
    }

    #[test]
    fn both_levels_see_the_same_resistance() {
        let channel = channel();
        for level in [Level::Low, Level::High] {
            let volt = 162.5 * f64::from(channel.current_a(level));
            let code = (volt / (4.0 / 8_388_608.0)).round() as i32;
            // Half a code at the low level is 0.08 mΩ, 0.15 mK.
            assert!((channel.resistance_ohm(code, level) - 162.5).abs() < 1e-4);
        }
    }

    #[test]
    fn power_is_current_squared_times_resistance() {
        assert!((channel().power_w(175.0, Level::High) - 0.0448).abs() < 1e-8);
        assert!((channel().power_w(175.0, Level::Low) - 0.001575).abs() < 1e-9);
    }

    #[test]
    fn refuses_levels_that_are_no_pair() {
        let platinum = Platinum::iec60751(100.0).unwrap();
        assert_eq!(Channel::new(platinum, 1e-6, 4e-3, 4e-3).unwrap_err().parameter, Parameter::CurrentHighA);
        assert_eq!(Channel::new(platinum, 0.0, 1e-3, 4e-3).unwrap_err().parameter, Parameter::VoltPerCode);
        assert_eq!(Channel::new(platinum, 1e-6, f32::NAN, 4e-3).unwrap_err().parameter, Parameter::CurrentLowA);
        assert_eq!(Channel::new(platinum, 1e-6, 1e-3, 1e25).unwrap_err().parameter, Parameter::CurrentHighA);
        assert_eq!(Channel::new(platinum, 1e9, 1e-3, 4e-3).unwrap_err().parameter, Parameter::VoltPerCode);
    }
}
