//! Fingerprint of the head: the resistances of its elements at the low level, kept with the
//! settings. Another head on the plug is refused, as it has other limits and other models.
//!
//! It compares the change of each element's resistance since the fingerprint was taken, in K of
//! [`COEFFICIENT_PER_K`]: by a law that nobody can state. The gas changes it for all elements
//! alike, another head changes it for each element otherwise:
//!
//! | change since the fingerprint was taken | at most | why |
//! |---|---|---|
//! | of any element | [`CHANGE_MOST_K`] | gas and weather; resistors of 100, 500 and 1000 Ω are over 200 K apart |
//! | between two elements | [`APART_MOST_K`] | sun, wind and a warm support; it is 3 % of a resistance |
//!
//! Two heads of one design, with resistors within the 0.1 % of their standard, are one to it: their
//! limits are the same, too.
//!
//! Elements that have been heated are not comparable, so a head is compared until it fits once, and
//! again after a start, a new fingerprint, or a trip that looks like a plug that was pulled.

use super::guard::{Cause, Trip};
use super::state::BOARD_ELEMENTS;

/// Resistances of a head at the low level, Ω; 0 for an element that is not compared.
pub type Fingerprint = [f32; BOARD_ELEMENTS];

/// Largest resistance of an element, Ω.
pub const LARGEST_OHM: f32 = 1e6;

/// Share of its resistance by which platinum changes in a kelvin: 0.31 % in thin films, 0.39 % in
/// wires (IEC 60751).
pub const COEFFICIENT_PER_K: f32 = 0.0035;

/// Largest change of any element, K.
pub const CHANGE_MOST_K: f32 = 100.0;

/// Largest difference between the changes of two elements, K.
pub const APART_MOST_K: f32 = 8.0;

/// State of the check of the head on the plug.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum HeadCheck {
    /// Not all of its elements have been read.
    #[default]
    Open,
    /// This element is not that of the fingerprint, or is still warm.
    Other(u8),
    /// It is the one of the fingerprint, or there is none.
    Same,
}

impl HeadCheck {
    /// Compares a head: of each element that has to be compared its number, and its change in K if
    /// it has been read. None, as long as one has not.
    pub(super) fn of(changes_k: impl Iterator<Item = (u8, Option<f32>)>) -> Option<Self> {
        let (mut least_k, mut most_k) = (f32::INFINITY, f32::NEG_INFINITY);
        for (element, change_k) in changes_k {
            let change_k = change_k?;
            (least_k, most_k) = (least_k.min(change_k), most_k.max(change_k));
            let fits = change_k.abs() <= CHANGE_MOST_K && most_k - least_k <= APART_MOST_K;
            if !fits {
                return Some(Self::Other(element));
            }
        }
        Some(Self::Same)
    }

    /// State after a trip.
    pub(super) const fn after(self, trip: Trip) -> Self {
        match trip.cause {
            Cause::Open | Cause::Short | Cause::OutOfRange | Cause::OtherHead => Self::Open,
            _ => self,
        }
    }

    /// One word for a checksum.
    pub(super) const fn word(self) -> u32 {
        match self {
            Self::Open => 0,
            Self::Same => 1,
            Self::Other(element) => 2 + element as u32,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of<const N: usize>(changes_k: [f32; N]) -> HeadCheck {
        HeadCheck::of((0..).zip(changes_k.map(Some))).unwrap()
    }

    #[test]
    fn gas_may_change_all_and_weather_each_a_little() {
        for same in [[0.0; 3], [100.0; 3], [-100.0; 3], [-20.0, -12.0, -16.0]] {
            assert_eq!(of(same), HeadCheck::Same);
        }
        assert_eq!(of([]), HeadCheck::Same);
        assert_eq!(of([101.0, 0.0]), HeadCheck::Other(0));
        assert_eq!(of([3.0, -6.0, 3.0]), HeadCheck::Other(1));
        assert_eq!(of([0.0, 5.0, -4.0]), HeadCheck::Other(2));
        assert_eq!(of([f32::NAN, 0.0]), HeadCheck::Other(0));
    }

    #[test]
    fn an_element_that_was_not_read_decides_nothing() {
        assert_eq!(HeadCheck::of([(0, Some(0.0)), (1, None)].into_iter()), None);
    }

    #[test]
    fn a_plug_that_was_pulled_is_compared_again() {
        assert_eq!(HeadCheck::Same.after(Trip::of(1, Cause::Open)), HeadCheck::Open);
        assert_eq!(HeadCheck::Same.after(Trip::of(1, Cause::OverTemperature)), HeadCheck::Same);
    }

    #[test]
    fn no_two_have_the_same_word() {
        let words = [HeadCheck::Open, HeadCheck::Same, HeadCheck::Other(0), HeadCheck::Other(1)].map(HeadCheck::word);
        assert_eq!(words, [0, 1, 2, 3]);
    }
}
