//! Check that the reading rises while an element is heated.
//!
//! A reading that says nothing of the element lets its drive heat for ever. A heated element
//! becomes warmer, or a drive that regulates has what it holds and goes low. So
//!
//! | drive | needs a rise of [`RISE_K`] |
//! |---|---|
//! | holds a temperature | again and again, each in the time of the board at the high level |
//! | any other, which may stand in a steady state | one, before its bucket is as full as that time at high fills it |
//!
//! The bucket gains [`GAIN`] in a tick at the high level, and loses 1 in one at the low level: a
//! drive that alternates is judged, too, in time t / (1.33 d − 0.33) for a share d of high ticks.
//! One that is high for less than a quarter of the time, 11 mW, need not warm an element by much,
//! and six of them so do not warm the sphere above 70 °C. When the bucket is empty, all begins
//! anew.

use crate::sensor::Level;

/// A reading that is so much higher has risen, K. Sphere B rises by 1.9 K or more in the sensor
/// board's time in every experiment here.
const RISE_K: f32 = 1.0;

/// Amount that a tick at the high level adds; one at the low level takes 1.
const GAIN: u32 = 3;

/// Rise of one element.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Rise {
    /// The reading that it is compared with, °C.
    from_c: f32,
    bucket: u32,
    /// It has risen since the bucket was empty.
    is_seen: bool,
}

/// Filling of a bucket after `limit_ticks` at the high level.
pub(super) fn full(limit_ticks: u32) -> u32 {
    limit_ticks.saturating_mul(GAIN).min(u32::MAX - 2 * GAIN)
}

impl Rise {
    /// Takes the reading of a tick; whether the rise is missing that a [`full`] bucket should have
    /// shown.
    #[inline(always)] // into the tick, where time counts
    pub(super) fn is_missing(&mut self, level: Level, temperature_c: f32, regulates: bool, full: u32) -> bool {
        let has_risen = temperature_c >= self.from_c + RISE_K;
        self.bucket = match level {
            Level::High => (self.bucket + GAIN).min(full + GAIN),
            Level::Low if regulates => 0,
            Level::Low => self.bucket.saturating_sub(1),
        };
        if self.bucket == 0 || regulates && has_risen {
            *self = Self { from_c: temperature_c, bucket: 0, is_seen: false };
            return false;
        }
        self.is_seen |= has_risen;
        !self.is_seen && self.bucket > full
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The tick in which a reading that stands still is missed, at so many high ticks of ten.
    fn missed_at(high_of_ten: u32) -> Option<u32> {
        let mut rise = Rise::default();
        (0..100_000).find(|n| {
            let level = if n * high_of_ten / 10 != (n + 1) * high_of_ten / 10 { Level::High } else { Level::Low };
            rise.is_missing(level, 0.1 * (n % 3) as f32, false, full(225))
        })
    }

    #[test]
    fn a_drive_that_alternates_is_judged_by_its_share_of_high_ticks() {
        assert_eq!(missed_at(10), Some(225));
        // 675 by 1.8, 1 and 0.2 a tick.
        for (share, expected) in [(7, 375), (5, 675), (3, 3375)] {
            let at = missed_at(share).unwrap();
            assert!(at.abs_diff(expected) < 20, "{share}: {at}");
        }
        assert_eq!([2, 1, 0].map(missed_at), [None; 3]);
    }

    #[test]
    fn one_rise_lasts_until_the_bucket_is_empty() {
        let mut rise = Rise::default();
        let mut run =
            |level, temperature_c, ticks| (0..ticks).any(|_| rise.is_missing(level, temperature_c, false, full(100)));
        assert!(!run(Level::Low, -2.0, 5));
        assert!(!run(Level::High, 0.0, 10_000));
        // 300 ticks later the heat of before is forgotten.
        assert!(!run(Level::Low, -1.0, 200) && !run(Level::High, -1.0, 200));
        assert!(!run(Level::Low, -1.0, 310) && run(Level::High, -1.0, 102));
    }
}
