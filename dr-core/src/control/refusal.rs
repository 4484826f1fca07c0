//! Why the controller refuses a command: an error enum whose sentences name what is wrong and what
//! would be right.

use super::guard::Trip;
use super::lockout::{LOCK_TRIPS, LOCK_WINDOW_S};
use crate::error::ConfigError;
use crate::model::Reachability;
use core::fmt;

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
        /// The requested element.
        element: u8,
    },
    /// The element has no configuration yet.
    NotConfigured {
        /// The requested element.
        element: u8,
    },
    /// The sample period has not been set yet.
    NoSamplePeriod,
    /// A number is wrong.
    Invalid {
        /// The element it was for, if any.
        element: Option<u8>,
        /// Number, and why it is refused.
        error: ConfigError,
    },
    /// By its model, the element cannot hold the set-point.
    Unreachable {
        /// The element it was for.
        element: u8,
        /// The set-point, °C.
        target_c: f32,
        /// The verdict of the model.
        verdict: Reachability,
    },
    /// A controller alone has no anemometer.
    NoAnemometer,
    /// The command can heat, and the instrument is not armed, or no longer.
    NotArmed,
    /// `Stop` came while the command waited.
    Stopped,
    /// Three trips in ten minutes have locked the instrument.
    LockedOut,
    /// The head on the plug is not that of the fingerprint.
    OtherHead {
        /// The first element that does not fit.
        element: u8,
    },
    /// The place is a capacitor's or its bias's, where a resistor is meant.
    NoResistor {
        /// The place.
        element: u8,
    },
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
            Self::Stopped => {
                write!(f, "a stop came before this was carried out: request it again if it is still wanted")
            }
            Self::NoAnemometer => write!(f, "this controller has no anemometer"),
            Self::NotArmed => {
                write!(f, "this command can heat, and the instrument is not armed, or no longer: arm it first")
            }
            Self::LockedOut => write!(
                f,
                "{LOCK_TRIPS} trips in {} minutes have locked the instrument: mend the cause, then restart it by its supply or its reset pin",
                LOCK_WINDOW_S / 60
            ),
            Self::OtherHead { element } => write!(
                f,
                "by the resistance of element {element} the head is not the one whose fingerprint is kept: plug that one in, let it cool if it was heated, or keep the fingerprint of this one"
            ),
            Self::NoResistor { element } => {
                write!(f, "place {element} is that of a capacitor or of its bias, and no resistor")
            }
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
