//! Loops that wait: they read one register again and again, and most of their rounds are left out.
//!
//! | register | what a round that is read again takes |
//! |---|---|
//! | SPI1_SR | all rounds that would find the same: a whole number of them, so that times are as if all had been emulated |
//! | DWT_CYCCNT | 1/256 of the time waited so far, since nobody knows what it waits for: a delay is too long by so much at the most |
//!
//! What is due by itself comes in time. Without this, starting takes five times as long, and a run
//! 1.4 times.

use super::Board;

/// The status of the converter's bus.
const BUS_STATUS: u32 = 0x4001_3008;
const CYCLE_COUNTER: u32 = 0xe000_1004;
const LENGTHENED_BY: u64 = 256;

/// Reads of one register with no other access between them.
#[derive(Clone, Copy, Debug)]
pub(super) struct WaitingLoop {
    register: u32,
    began: u64,
    last: u64,
}

impl Board {
    /// A register is read.
    pub(super) fn leave_out_rounds(&mut self, register: u32) {
        let now = self.now;
        let mut waiting = match self.waiting {
            Some(waiting) if waiting.register == register => waiting,
            _ => WaitingLoop { register, began: now, last: now },
        };
        let due = self.next_event.saturating_sub(now);
        self.now += match register {
            BUS_STATUS => {
                let left = self.spi.ends_at().map_or(0, |end| end.saturating_sub(now)).min(due);
                // Of the first round nobody knows how long it is.
                left.checked_rem(now - waiting.last).map_or(0, |rest| left - rest)
            }
            CYCLE_COUNTER => ((now - waiting.began) / LENGTHENED_BY).min(due),
            _ => 0,
        };
        waiting.last = self.now;
        self.waiting = Some(waiting);
    }
}
