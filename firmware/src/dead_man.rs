//! The dead-man timer: a heater stays high only while its level is decided anew in every tick.
//!
//! A high level starts the timer for two ticks. If nothing has been decided by then, the timer
//! expires: an interrupt above all tasks lowers the heaters, whatever the state of the front end or
//! of the control task. On the sensor board a timer of the processor counts the time
//! ([`timeout_us`]); on the virtual board, where the host is the clock, ticks are counted here.

use core::sync::atomic::{AtomicU8, Ordering::Relaxed};

/// Ticks after which levels that were not decided anew expire.
pub const TIMEOUT_TICKS: u8 = 2;

/// How long levels may stand on a board with a clock, µs: a quarter of a tick less than two. The
/// levels of a tick are set after its readings, so that counted from the reading they are over
/// before it is two ticks old.
pub const fn timeout_us(tick_us: u32) -> u32 {
    // Ten seconds, the longest tick, are far below the overflow of these products.
    tick_us / 4 * (4 * TIMEOUT_TICKS as u32 - 1)
}

/// A dead-man timer that counts ticks.
pub struct DeadManCounter(AtomicU8);

impl DeadManCounter {
    /// Stopped: no heater is high.
    pub const fn stopped() -> Self {
        Self(AtomicU8::new(0))
    }

    /// Levels have been decided: a high one restarts the timer, otherwise it stops.
    pub fn decided(&self, any_high: bool) {
        self.0.store(if any_high { TIMEOUT_TICKS } else { 0 }, Relaxed);
    }

    /// A tick has passed in which nothing was decided; returns whether the timer expires now.
    pub fn tick_passed(&self) -> bool {
        let left = self.0.load(Relaxed);
        self.0.store(left.saturating_sub(1), Relaxed);
        left == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_expires_once_when_two_ticks_have_passed() {
        let timer = DeadManCounter::stopped();
        timer.decided(true);
        assert!(!timer.tick_passed());
        timer.decided(true);
        let expired: [bool; 5] = core::array::from_fn(|_| timer.tick_passed());
        assert_eq!(expired, [false, true, false, false, false]);
    }

    #[test]
    fn low_heaters_may_stand_for_ever() {
        let timer = DeadManCounter::stopped();
        timer.decided(true);
        timer.decided(false);
        assert!((0..10).all(|_| !timer.tick_passed()));
    }

    #[test]
    fn on_a_board_it_expires_between_one_tick_and_two() {
        for tick_us in [1_000, 10_000, 10_000_000] {
            assert!((tick_us * 3 / 2..2 * tick_us).contains(&timeout_us(tick_us)), "{tick_us}");
        }
    }
}
