//! Kind of an element: the seam between the controller and the physics of its elements.
//!
//! | transducer | what it measures | its inputs, low and high | places |
//! |---|---|---|---|
//! | resistor | temperature, °C | heating powers of the two currents, W | 1 |
//! | capacitor | voltage shift of its dielectric, V | symbols, −1 and +1 | 2: itself, then its bias |
//!
//! A capacitor is read twice a tick, at the ends of the two parts of a symbol, so it takes two
//! places: the second reading has that of its bias, whose bit is set while symbols are applied. So
//! for either all bits clear is the safe state: no heat, 0 V.

use super::energy::EnergyLimit;
use super::guard::{Cause, ReadingJudgement};
use super::hardware_limits::HardwareLimits;
use super::state::ElementConfig;
use crate::error::{self, ConfigError, Parameter};
use crate::fields::{FieldVisitor, Fields};
use crate::sensor::capacitor::Shift;
use crate::sensor::{Capacitor, Level, Reading};

/// A capacitor and what is plausible for it.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CapacitorConfig {
    /// From codes to the voltage shift.
    pub capacitor: Capacitor,
    /// Above it the membrane has been pulled in, F.
    pub capacitance_max_f: f32,
    /// A voltage shift beyond it, either way, is none, V.
    pub shift_max_v: f32,
    /// Codes from here up (or from its negative down) are the ends of the meter's range.
    pub code_max: i32,
}

impl CapacitorConfig {
    /// The configuration, if it makes sense and this board has such elements.
    pub(super) fn checked(self, hardware: &HardwareLimits) -> Result<Self, ConfigError> {
        let capacitor = self.capacitor.checked()?;
        let (negative_v, positive_v) = capacitor.voltages_v();
        let most_v = hardware.bias_max_v;
        error::within(Parameter::NegativeV, negative_v, 0.0 - most_v, most_v)?;
        error::within(Parameter::PositiveV, positive_v, 0.0 - most_v, most_v)?;
        error::positive(Parameter::CapacitanceMaxF, self.capacitance_max_f)?;
        error::positive(Parameter::ShiftMaxV, self.shift_max_v)?;
        error::within(Parameter::CodeMax, self.code_max as f32, 1.0, 8_388_607.0)?;
        Ok(Self { capacitor, ..self })
    }
}

/// Kind of an element.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Transducer {
    /// A platinum resistor, which heats and senses.
    Resistor(ElementConfig),
    /// A MEMS capacitor.
    Capacitor(CapacitorConfig),
    /// The bias of the capacitor before it.
    Bias,
}

impl Fields for Transducer {
    fn visit(&self, visitor: &mut impl FieldVisitor) {
        match self {
            // The part that every tick of the board verifies has no word more than it needs.
            Self::Resistor(config) => config.visit(visitor),
            Self::Capacitor(config) => {
                visitor.word(1);
                config.visit(visitor);
            }
            Self::Bias => visitor.word(2),
        }
    }
}

impl Transducer {
    /// The resistor, if it is one.
    pub const fn resistor(&self) -> Option<&ElementConfig> {
        if let Self::Resistor(config) = self { Some(config) } else { None }
    }

    /// Least and greatest set-point that it knows.
    pub fn range(&self) -> (f32, f32) {
        match self {
            Self::Resistor(config) => config.channel.platinum().range_c(),
            Self::Capacitor(config) => (-config.shift_max_v, config.shift_max_v),
            Self::Bias => (0.0, 0.0),
        }
    }

    /// Powers that the two levels put in at a resistance in Ω: W, or symbols.
    pub fn inputs(&self, raw: f32) -> (f32, f32) {
        match self {
            Self::Resistor(config) => {
                (config.channel.power_w(raw, Level::Low), config.channel.power_w(raw, Level::High))
            }
            Self::Capacitor(_) => (-1.0, 1.0),
            Self::Bias => (0.0, 0.0),
        }
    }

    /// Powers that the levels put in at a set-point.
    pub fn inputs_at(&self, target: f32) -> (f32, f32) {
        let raw = self.resistor().map_or(0.0, |config| config.channel.platinum().resistance_ohm(target));
        self.inputs(raw)
    }
}

impl ElementConfig {
    /// Power and energy that it may have.
    pub(super) fn bears(&self, hardware: &HardwareLimits) -> EnergyLimit {
        self.limits.energy.unwrap_or(hardware.energy)
    }
}

/// Judges the two readings of a symbol; the second is that of the place of the bias.
pub(super) fn judge_symbol(config: &CapacitorConfig, readings: [Reading; 2], bit: Level) -> ReadingJudgement {
    let mut codes = [0; 2];
    for (code, reading) in codes.iter_mut().zip(readings) {
        *code = match reading {
            Reading::Code(code) => code,
            Reading::Stale => return ReadingJudgement::Absent(Cause::Stale),
            Reading::Missing => return ReadingJudgement::Absent(Cause::Missing),
        };
        if !(1 - config.code_max..config.code_max).contains(code) {
            return ReadingJudgement::Bad(Cause::OutOfRange);
        }
        if config.capacitor.capacitance_f(*code) > config.capacitance_max_f {
            return ReadingJudgement::Bad(Cause::PullIn);
        }
    }
    let Shift { shift_v, offset_f } = config.capacitor.shift(codes, bit);
    if !shift_v.is_finite() {
        ReadingJudgement::Bad(Cause::NonFinite)
    } else if shift_v > config.shift_max_v || shift_v < -config.shift_max_v {
        ReadingJudgement::Bad(Cause::OutOfRange)
    } else {
        ReadingJudgement::Good { raw: offset_f, value: shift_v }
    }
}
