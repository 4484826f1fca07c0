//! What is to be doubted in an answer: one bit for each reason.

use crate::sensor::wind::Quality;
use core::fmt;

/// A set of reasons; empty if the answer is as good as its errors say.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Doubts(pub u16);

impl Doubts {
    /// There is no wind vector.
    pub const FAILED: Self = Self(1);
    /// A conductance was no number that makes sense, and was left out.
    pub const REFUSED: Self = Self(1 << 1);
    /// Fewer parts than the head has.
    pub const DEGRADED: Self = Self(1 << 2);
    /// Another wind fits as well.
    pub const AMBIGUOUS: Self = Self(1 << 3);
    /// The head does not tell all of the wind's direction.
    pub const UNDETERMINED: Self = Self(1 << 4);
    /// The direction is more uncertain than was asked for.
    pub const NO_DIRECTION: Self = Self(1 << 5);
    /// Beyond the Reynolds numbers of the calibration.
    pub const EXTRAPOLATED: Self = Self(1 << 6);
    /// The head has no calibration: there are conductances, but no wind.
    pub const UNCALIBRATED: Self = Self(1 << 7);
    /// The gas's temperature or pressure is not known, or beyond what is known of the gas.
    pub const NO_GAS: Self = Self(1 << 8);
    /// The instrument is in standby, or tripped: nothing is held.
    pub const NOT_RUNNING: Self = Self(1 << 9);
    /// An element has been at one level for so long that its loop holds it no more.
    pub const SATURATED: Self = Self(1 << 10);
    /// The observer has only just begun, or begun on a head that was warm already and that it does not know yet.
    pub const STARTING: Self = Self(1 << 11);
    /// A part is hardly warmer than the gas, and was left out.
    pub const COLD: Self = Self(1 << 12);

    /// All of them with their names, in the order of their bits.
    pub const NAMES: [(Self, &'static str); 13] = [
        (Self::FAILED, "failed"),
        (Self::REFUSED, "refused"),
        (Self::DEGRADED, "degraded"),
        (Self::AMBIGUOUS, "ambiguous"),
        (Self::UNDETERMINED, "undetermined"),
        (Self::NO_DIRECTION, "no-direction"),
        (Self::EXTRAPOLATED, "extrapolated"),
        (Self::UNCALIBRATED, "uncalibrated"),
        (Self::NO_GAS, "no-gas"),
        (Self::NOT_RUNNING, "not-running"),
        (Self::SATURATED, "saturated"),
        (Self::STARTING, "starting"),
        (Self::COLD, "cold"),
    ];

    /// Whether all of `other` are in it.
    pub const fn has(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// With `other`, if `so`.
    pub const fn with(self, other: Self, so: bool) -> Self {
        if so { Self(self.0 | other.0) } else { self }
    }

    /// What an inverse says of its answer.
    pub(super) const fn of(quality: &Quality) -> Self {
        Self(0)
            .with(Self::FAILED, quality.failed)
            .with(Self::REFUSED, quality.refused)
            .with(Self::DEGRADED, quality.degraded)
            .with(Self::AMBIGUOUS, quality.ambiguous)
            .with(Self::UNDETERMINED, quality.undetermined)
            .with(Self::NO_DIRECTION, quality.no_direction)
            .with(Self::EXTRAPOLATED, quality.extrapolated)
    }
}

impl fmt::Display for Doubts {
    /// The names, with a blank between them.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut names = Self::NAMES.iter().filter(|(doubt, _)| self.has(*doubt)).map(|(_, name)| name);
        if let Some(name) = names.next() {
            f.write_str(name)?;
        }
        names.try_for_each(|name| write!(f, " {name}"))
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::ToString;

    #[test]
    fn every_bit_has_a_name_of_its_own() {
        for (place, (doubt, _)) in Doubts::NAMES.iter().enumerate() {
            assert_eq!(doubt.0, 1 << place);
        }
        let two = Doubts::default().with(Doubts::COLD, true).with(Doubts::FAILED, true).with(Doubts::NO_GAS, false);
        assert_eq!(two.to_string(), "failed cold");
        assert!(two.has(Doubts::COLD) && !two.has(Doubts::NO_GAS));
        assert_eq!(Doubts::default().to_string(), "");
    }
}
