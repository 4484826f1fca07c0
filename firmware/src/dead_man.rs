//! The dead man's handle: a heater stays high only while somebody goes on deciding that it shall.
//!
//! Whoever sets a heater high holds the handle for two ticks. If nothing has been decided anew by then, the heaters go low,
//! whatever has become of the front end or of the control task: the handle bites in an interrupt above all tasks. On the
//! sensor board a timer of the processor counts the time ([`patience_us`]); on the virtual board, where the host is the
//! clock, its ticks are counted here.

use core::sync::atomic::{AtomicU8, Ordering::Relaxed};

/// Ticks after which levels that have not been decided anew are over.
pub const PATIENCE_TICKS: u8 = 2;

/// How long levels may stand on a board with a clock, µs: a quarter of a tick less than two. The levels of a tick are set after its
/// readings, so that counted from the reading they are over before it is two ticks old.
pub const fn patience_us(tick_us: u32) -> u32 {
    // Ten seconds, the longest tick, are far below the overflow of these products.
    tick_us / 4 * (4 * PATIENCE_TICKS as u32 - 1)
}

/// A handle by whole ticks.
pub struct DeadMan(AtomicU8);

impl DeadMan {
    /// Nobody holds it, and no heater is high.
    pub const fn new() -> Self {
        Self(AtomicU8::new(0))
    }

    /// Levels have been decided; without a high one there is nothing to hold.
    pub fn decided(&self, any_high: bool) {
        self.0.store(if any_high { PATIENCE_TICKS } else { 0 }, Relaxed);
    }

    /// A tick has passed in which nothing was decided; says whether the handle bites now.
    pub fn tick_passed(&self) -> bool {
        let left = self.0.load(Relaxed);
        self.0.store(left.saturating_sub(1), Relaxed);
        left == 1
    }
}

impl Default for DeadMan {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_bites_once_when_two_ticks_have_passed() {
        let handle = DeadMan::new();
        handle.decided(true);
        assert!(!handle.tick_passed());
        handle.decided(true);
        let bites: [bool; 5] = core::array::from_fn(|_| handle.tick_passed());
        assert_eq!(bites, [false, true, false, false, false]);
    }

    #[test]
    fn low_heaters_may_stand_for_ever() {
        let handle = DeadMan::new();
        handle.decided(true);
        handle.decided(false);
        assert!((0..10).all(|_| !handle.tick_passed()));
    }

    #[test]
    fn on_a_board_it_bites_between_one_tick_and_two() {
        for tick_us in [1_000, 10_000, 10_000_000] {
            assert!((tick_us * 3 / 2..2 * tick_us).contains(&patience_us(tick_us)), "{tick_us}");
        }
    }
}
