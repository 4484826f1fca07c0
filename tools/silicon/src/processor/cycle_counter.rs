//! The cycle counter of the trace unit (DWT_CYCCNT).
//!
//! It counts the core's cycles, and none while the core sleeps: then its clock stands still. A bit
//! that belongs to the debugger, DBG_SLEEP, keeps that clock running (RM0090, "Debug support for
//! low-power modes").

use crate::time::CYCLES_PER_SECOND;

const CYCCNTENA: u32 = 1;
/// No comparators are modelled.
const NOCYCCNT_CLEAR: u32 = 0x4000_0000;

/// The counter.
#[derive(Clone, Debug, Default)]
pub struct CycleCounter {
    enabled: bool,
    count: u32,
    /// When it had this count.
    since: u64,
}

impl CycleCounter {
    /// Cycles of the core's clock in a time.
    fn core_cycles(time: u64, core_hz: u64) -> u32 {
        (u128::from(time) * u128::from(core_hz) / u128::from(CYCLES_PER_SECOND)) as u32
    }

    /// Takes the count of now over, because the clock changes, or stood still until now.
    pub fn rebase(&mut self, now: u64, core_hz: u64, stood_still_for: u64) {
        self.count = self.read(now - stood_still_for, core_hz);
        self.since = now;
    }

    fn read(&self, now: u64, core_hz: u64) -> u32 {
        if !self.enabled {
            return self.count;
        }
        self.count.wrapping_add(Self::core_cycles(now - self.since, core_hz))
    }

    /// Reads a register by its offset.
    pub fn load(&self, offset: u32, now: u64, core_hz: u64) -> u32 {
        match offset {
            0x0 => NOCYCCNT_CLEAR | u32::from(self.enabled),
            0x4 => self.read(now, core_hz),
            _ => 0,
        }
    }

    /// Writes a register by its offset.
    pub fn store(&mut self, offset: u32, value: u32, now: u64, core_hz: u64) {
        match offset {
            0x0 => {
                self.rebase(now, core_hz, 0);
                self.enabled = value & CYCCNTENA != 0;
            }
            0x4 => (self.count, self.since) = (value, now),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sleep_that_stops_the_clock_is_not_counted() {
        let mut counter = CycleCounter::default();
        counter.store(0, 1, 1_000, CYCLES_PER_SECOND);
        assert_eq!(counter.load(4, 1_500, CYCLES_PER_SECOND), 500);
        counter.rebase(2_500, CYCLES_PER_SECOND, 1_000);
        assert_eq!(counter.load(4, 2_600, CYCLES_PER_SECOND), 600);
        // At 84 MHz two of our cycles are one of the core's.
        counter.rebase(2_600, CYCLES_PER_SECOND, 0);
        assert_eq!(counter.load(4, 2_800, CYCLES_PER_SECOND / 2), 700);
    }
}
