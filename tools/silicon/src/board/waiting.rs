//! Loops that wait: they read one register again and again, and most of their rounds are left out.
//!
//! | register | what a round that is read again takes |
//! |---|---|
//! | SPI1_SR | all rounds that would find the same: a whole number of them, so that times are as if all had been emulated |
//! | DWT_CYCCNT | 1/256 of the time waited so far, since nobody knows what it waits for: a delay is too long by so much at the most |
//!
//! Events that are due by themselves come in time. Without this, starting takes five times as long,
//! and a run 1.4 times.

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

impl WaitingLoop {
    /// A register is read at `now`: the cycles that are left out, none beyond the next event, which
    /// is due in `due` cycles. The bus of the converter is busy until `bus_ends_at`.
    pub fn left_out(waiting: &mut Option<Self>, register: u32, now: u64, due: u64, bus_ends_at: Option<u64>) -> u64 {
        let before = match *waiting {
            Some(before) if before.register == register => before,
            _ => Self { register, began: now, last: now },
        };
        let left_out = match register {
            BUS_STATUS => {
                let left = bus_ends_at.map_or(0, |end| end.saturating_sub(now)).min(due);
                // Nobody knows the length of the first round.
                left.checked_rem(now - before.last).map_or(0, |rest| left - rest)
            }
            CYCLE_COUNTER => ((now - before.began) / LENGTHENED_BY).min(due),
            _ => 0,
        };
        *waiting = Some(Self { last: now + left_out, ..before });
        left_out
    }
}
