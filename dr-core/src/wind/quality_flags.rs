//! Quality flags of a wind estimate: one bit for each limitation.

use core::fmt;

/// A set of flags; empty if the standard errors describe the estimate completely.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct QualityFlags(pub u16);

impl QualityFlags {
    /// There is no wind vector: too few surfaces, or no best fit was found.
    pub const FAILED: Self = Self(1);
    /// A conductance or its variance was not a finite positive number and was left out.
    pub const REFUSED: Self = Self(1 << 1);
    /// Fewer surfaces than the head has.
    pub const DEGRADED: Self = Self(1 << 2);
    /// Another wind fits as well.
    pub const AMBIGUOUS: Self = Self(1 << 3);
    /// The head does not determine all components of the wind.
    pub const UNDETERMINED: Self = Self(1 << 4);
    /// The standard error of the direction is above the requested bound.
    pub const NO_DIRECTION: Self = Self(1 << 5);
    /// Beyond the Reynolds numbers of the calibration.
    pub const EXTRAPOLATED: Self = Self(1 << 6);
    /// The head has no calibration: conductances are reported, a wind is not.
    pub const UNCALIBRATED: Self = Self(1 << 7);
    /// Temperature or pressure of the gas is unknown, or outside the range of the gas law.
    pub const NO_GAS: Self = Self(1 << 8);
    /// The instrument is in standby or tripped: no element is controlled.
    pub const NOT_RUNNING: Self = Self(1 << 9);
    /// An element has been at one level too long: its loop no longer controls it.
    pub const SATURATED: Self = Self(1 << 10);
    /// The observer was initialised recently, or on a head that was already warm.
    pub const STARTING: Self = Self(1 << 11);
    /// The overheat of a surface is too small; it was left out.
    pub const COLD: Self = Self(1 << 12);
    /// The measurements contradict each other, by more than the calibration explains.
    pub const INCONSISTENT: Self = Self(1 << 13);
    /// Slower than the slowest wind of the calibration, but not still.
    pub const BELOW_CALIBRATION: Self = Self(1 << 14);
    /// From so near to the stem that no wind of the calibration came from there.
    pub const NEAR_STEM: Self = Self(1 << 15);

    /// All flags with their names, in the order of their bits.
    pub const NAMES: [(Self, &'static str); 16] = [
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
        (Self::INCONSISTENT, "inconsistent"),
        (Self::BELOW_CALIBRATION, "below-calibration"),
        (Self::NEAR_STEM, "near-stem"),
    ];

    /// Tells whether all flags of `other` are set.
    pub const fn has(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// The set with `other` added, if `so`.
    pub const fn with(self, other: Self, so: bool) -> Self {
        if so { Self(self.0 | other.0) } else { self }
    }

    /// The set less `other`.
    pub(super) const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }
}

impl fmt::Display for QualityFlags {
    /// The names, with a blank between them.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut names = Self::NAMES.iter().filter(|(flag, _)| self.has(*flag)).map(|(_, name)| name);
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
        for (place, (flag, _)) in QualityFlags::NAMES.iter().enumerate() {
            assert_eq!(flag.0, 1 << place);
        }
        let two = QualityFlags::default()
            .with(QualityFlags::COLD, true)
            .with(QualityFlags::FAILED, true)
            .with(QualityFlags::NO_GAS, false);
        assert_eq!(two.to_string(), "failed cold");
        assert!(two.has(QualityFlags::COLD) && !two.has(QualityFlags::NO_GAS));
        assert_eq!(QualityFlags::default().to_string(), "");
    }
}
