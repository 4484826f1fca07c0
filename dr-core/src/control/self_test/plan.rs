//! Phases of a self-test.
//!
//! | phase | ticks | the front end reads | the heaters |
//! |---|---|---|---|
//! | offsets | [`SETTLING_TICKS`] + [`QUIET_TICKS`] | shorted inputs | low |
//! | references | the same | a known voltage | low |
//! | quiet | the same | the elements | low |
//! | heating, of one element after the other | pulse + 1 | the elements | its own high for the pulse |
//! | cooling | twice the pulse | the elements | low |
//!
//! Without a pulse it ends with the phase `quiet`.

use crate::error::{self, ConfigError, Parameter};
use crate::sensor::FrontEndInput;

/// Ticks ignored after a change of the input: the front end receives the change with the tick
/// before.
pub const SETTLING_TICKS: u32 = 2;
/// Readings per mean and noise: their standard deviation has a standard error of 9 %.
pub const QUIET_TICKS: u32 = 64;
/// The shortest pulse, in ticks, and the longest, s.
pub const PULSE_LEAST_TICKS: u32 = 8;
/// See [`PULSE_LEAST_TICKS`].
pub const PULSE_MOST_S: f32 = 10.0;

/// A requested self-test.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SelfTestPlan {
    /// Length of the pulse that each element is heated with, s; without one nothing heats.
    pub pulse_s: Option<f32>,
    /// Start time given by the host, s since 1970, stored with the findings; none if unknown.
    pub unix_s: Option<u32>,
}

impl SelfTestPlan {
    /// Length of the pulse in ticks; 0 without one.
    ///
    /// # Errors
    /// A pulse of under [`PULSE_LEAST_TICKS`], or of over [`PULSE_MOST_S`].
    pub fn pulse_ticks(&self, sample_period_s: f32) -> Result<u32, ConfigError> {
        let Some(pulse_s) = self.pulse_s else { return Ok(0) };
        // Where ticks are slower, no pulse is long enough and short enough.
        error::within(Parameter::SamplePeriodS, sample_period_s, 0.0, PULSE_MOST_S / PULSE_LEAST_TICKS as f32)?;
        let least_s = PULSE_LEAST_TICKS as f32 * sample_period_s;
        let pulse_s = error::within(Parameter::PulseS, pulse_s, f32::MIN, f32::MAX)?;
        let ticks = (pulse_s / sample_period_s + 0.5) as u32;
        if ticks < PULSE_LEAST_TICKS || pulse_s > PULSE_MOST_S {
            return Err(error::out_of_range(Parameter::PulseS, least_s, PULSE_MOST_S));
        }
        Ok(ticks)
    }
}

/// Ticks that a test takes, with pulses of so many ticks or none.
pub const fn test_ticks(pulse_ticks: u32, elements: usize) -> u32 {
    let heated = if pulse_ticks > 0 { elements as u32 * (3 * pulse_ticks + 1) } else { 0 };
    3 * (SETTLING_TICKS + QUIET_TICKS) + heated
}

/// Phase of a test.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Phase {
    Offsets,
    References,
    Quiet,
    Heating(u8),
    Cooling(u8),
    Done,
}

impl Phase {
    /// Input of the front end in this phase.
    pub const fn input(self) -> FrontEndInput {
        match self {
            Self::Offsets => FrontEndInput::Shorted,
            Self::References => FrontEndInput::Reference,
            Self::Quiet | Self::Heating(_) | Self::Cooling(_) | Self::Done => FrontEndInput::Element,
        }
    }

    /// Number of ticks of the phase.
    pub const fn ticks(self, pulse_ticks: u32) -> u32 {
        match self {
            Self::Offsets | Self::References | Self::Quiet => SETTLING_TICKS + QUIET_TICKS,
            Self::Heating(_) => pulse_ticks + 1,
            Self::Cooling(_) => 2 * pulse_ticks,
            Self::Done => 0,
        }
    }

    /// The next phase.
    pub const fn next(self, heats: bool, elements: u8) -> Self {
        match self {
            Self::Offsets => Self::References,
            Self::References => Self::Quiet,
            Self::Quiet if heats => Self::Heating(0),
            Self::Heating(element) => Self::Cooling(element),
            Self::Cooling(element) if element + 1 < elements => Self::Heating(element + 1),
            Self::Quiet | Self::Cooling(_) | Self::Done => Self::Done,
        }
    }
}
