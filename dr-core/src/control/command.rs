//! What a host may ask of the controller, and why it may say no.
//!
//! Commands set an instrument up in `Standby`; drives may be changed while it runs. The order that a host follows:
//! `Clear`, `SamplePeriod`, `Guard`, `Observe`, `Element` and `Model` for each element, `Drive` for each element, `Arm`, `Start`.

use super::anemometer::WindCommand;
use super::controller::ElementConfig;
use super::drive::Drive;
use super::guard::{GuardConfig, Trip};
use super::self_test::SelfTestPlan;
use crate::error::ConfigError;
use crate::model::{Reachability, SelfHeatingConfig};
use core::fmt;

/// A request.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Command {
    /// Forget every element, model and drive. In standby.
    Clear,
    /// Length of a tick. In standby; models have to be loaded again.
    SamplePeriod {
        /// Seconds, 0.0001 … 10.
        sample_period_s: f32,
    },
    /// Patience of the guard. In standby.
    Guard(GuardConfig),
    /// What an element is. In standby.
    Element {
        /// Which, from 0. Those before it have to be configured already.
        element: u8,
        /// Its wiring and limits.
        config: ElementConfig,
    },
    /// The diffusive model of an element. In standby, after the sample period.
    Model {
        /// Which, from 0.
        element: u8,
        /// Mesh, symbol and reference.
        model: SelfHeatingConfig,
    },
    /// What an element does. At any time but when tripped; takes effect with the next tick.
    Drive {
        /// Which, from 0.
        element: u8,
        /// What.
        drive: Drive,
    },
    /// From standby to running: drives, models and the tick counter start afresh.
    Start,
    /// From running to standby, heaters low.
    Stop,
    /// From tripped to standby.
    Acknowledge,
    /// Whether the models of the elements are held on the measured temperatures, and what their structures take is told beside each
    /// tick. In standby; off after `Clear`.
    Observe {
        /// On or off.
        on: bool,
    },
    /// What the anemometer has to know.
    Wind(WindCommand),
    /// For so long, what can heat may be asked for: `Start`, and while running a drive that heats. After the sample period, at any time
    /// but when tripped. `Start`, `Stop`, `Disarm`, `Clear`, `SamplePeriod` and a trip end it at once.
    Arm {
        /// Seconds, up to [`LONGEST_ARMED_S`]; counted in ticks.
        window_s: f32,
    },
    /// Ends what `Arm` began. What runs goes on.
    Disarm,
    /// Look whether everything is as it should be ([`self_test`](super::self_test)). With a pulse: in standby, armed, in place of
    /// which the length of the test is counted from now on. Without: in standby or tripped, and the state stays what it is. Any other
    /// command that changes something ends it.
    SelfTest(SelfTestPlan),
}

/// Longest time for which an instrument can be armed, s.
pub const LONGEST_ARMED_S: f32 = 600.0;

/// An answer to a command that was carried out.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Reply {
    /// Done.
    Done,
    /// Started, with this many set-points judged reachable by a model, and this many without a model to judge them.
    Started {
        /// Judged reachable.
        judged: u8,
        /// Not judged.
        unjudged: u8,
    },
}

/// Why a command was not carried out. Nothing has changed then.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Refusal {
    /// Only possible in standby.
    NotInStandby,
    /// The instrument is tripped: acknowledge first.
    Tripped(Trip),
    /// There is no trip to acknowledge.
    NotTripped,
    /// The instrument has fewer elements.
    NoSuchElement {
        /// The element asked for.
        element: u8,
    },
    /// The element has no configuration yet.
    NotConfigured {
        /// The element asked for.
        element: u8,
    },
    /// The sample period has not been set yet.
    NoSamplePeriod,
    /// A number is wrong.
    Invalid {
        /// The element it was for, if any.
        element: Option<u8>,
        /// Which number, and why.
        error: ConfigError,
    },
    /// The element's model says that the set-point cannot be held.
    Unreachable {
        /// The element it was for.
        element: u8,
        /// What the set-point asks for, °C.
        target_c: f32,
        /// The model's verdict.
        verdict: Reachability,
    },
    /// A controller by itself knows nothing of the wind.
    NoAnemometer,
    /// This can heat, and the instrument is not armed, or no longer.
    NotArmed,
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::NotInStandby => write!(f, "this can only be set in standby: stop the run first"),
            Self::Tripped(trip) => write!(f, "the instrument is tripped ({trip}): acknowledge it first"),
            Self::NotTripped => write!(f, "there is no trip to acknowledge"),
            Self::NoSuchElement { element } => write!(f, "the instrument has no element {element}"),
            Self::NotConfigured { element } => write!(f, "element {element} has no configuration yet"),
            Self::NoSamplePeriod => write!(f, "the sample period has to be set first"),
            Self::NoAnemometer => write!(f, "this controller has no anemometer"),
            Self::NotArmed => write!(f, "this can heat, and the instrument is not armed, or no longer: arm it first"),
            Self::Invalid { element: Some(element), error } => write!(f, "element {element}: {error}"),
            Self::Invalid { element: None, error } => write!(f, "{error}"),
            Self::Unreachable { element, target_c, verdict } => match verdict {
                Reachability::LowLevelTooWarm { least_rise_k } => write!(
                    f,
                    "element {element} cannot be held at {target_c} °C: even the low level ends {least_rise_k} K above the reference"
                ),
                Reachability::HighLevelTooCold { most_rise_k } => write!(
                    f,
                    "element {element} cannot be held at {target_c} °C: the high level ends {most_rise_k} K above the reference, at the most"
                ),
                Reachability::Reachable { .. } => write!(f, "element {element} can be held at {target_c} °C"),
            },
        }
    }
}

impl core::error::Error for Refusal {}

#[cfg(test)]
mod tests;
