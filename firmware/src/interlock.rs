//! Interlock between the tasks of the highest priority and the control task: for what reason no
//! heater may be high.
//!
//! | word | set by | taken by |
//! |---|---|---|
//! | request to trip | supply detector, start, proof tests, the estimator | control, before anything else |
//! | expired | dead-man timer | control, before the next tick |
//! | request to stop | receiver | control, before other commands |
//! | cut | control | health: the status LED's pin stands still then |
//!
//! Every value of a word is one that could have been set, or none: a bit that flips causes a trip
//! or nothing, and no stop.

use crate::flag::Flag;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use dr_core::control::Cause;

/// The words. One writer at a time: what a lower priority sets, a higher one may overwrite by
/// another cause of the same effect.
pub struct Interlock {
    trip: AtomicU32,
    /// The dead-man timer has expired, and has lowered the heaters.
    pub expired: Flag,
    deadlines: AtomicU32,
    stop: AtomicU32,
    /// The platinum is to lose its supply, as control judges it.
    pub cut: Flag,
}

impl Interlock {
    /// No reason.
    pub const fn released() -> Self {
        Self {
            trip: AtomicU32::new(0),
            expired: Flag::new(false),
            deadlines: AtomicU32::new(0),
            stop: AtomicU32::new(0),
            cut: Flag::new(false),
        }
    }

    /// Requests a trip. The control task must be woken.
    pub fn trip(&self, cause: Cause) {
        self.trip.store(cause as u32 + 1, Relaxed);
    }

    /// Takes the cause of a request; it is returned once.
    pub fn take_trip(&self) -> Option<Cause> {
        use Cause::{BrownOut, Clock, Fault, Memory, Panic, ProofTest, Restart, Watchdog};
        let word = self.trip.load(Relaxed).checked_sub(1)?;
        self.trip.store(0, Relaxed);
        let known = [Panic, Fault, Watchdog, BrownOut, Memory, Clock, ProofTest, Restart];
        Some(known.into_iter().find(|&cause| cause as u32 == word).unwrap_or(Cause::BitFlip))
    }

    /// The dead-man timer has expired, and has lowered the heaters.
    pub fn expire(&self) {
        self.expired.raise();
        self.deadlines.store(self.deadlines().wrapping_add(1), Relaxed);
    }

    /// Number of times that it has expired.
    pub fn deadlines(&self) -> u32 {
        self.deadlines.load(Relaxed)
    }

    /// Lets the timer expire on purpose: afterwards it has not. Control must be held back.
    pub fn prove<R>(&self, test: impl FnOnce() -> R) -> R {
        let (expired, deadlines) = (self.expired.is_raised(), self.deadlines());
        let result = test();
        self.expired.set(expired);
        self.deadlines.store(deadlines, Relaxed);
        result
    }

    /// Returns true while a reason waits to be taken: no heater may stay high.
    pub fn forbids(&self) -> bool {
        self.requests_trip() || self.expired.is_raised()
    }

    /// Returns true while a requested trip waits to be taken.
    pub fn requests_trip(&self) -> bool {
        self.trip.load(Relaxed) != 0
    }

    /// The host stops the run, by a command of this number. The control task must be woken.
    pub fn stop(&self, sequence: u16) {
        self.stop.store(u32::from(sequence) | u32::from(!sequence) << 16, Relaxed);
    }

    /// Takes the number of a stop. The upper half is its complement: a bit that flips makes none.
    pub fn take_stop(&self) -> Option<u16> {
        let word = self.stop.swap(0, Relaxed);
        let sequence = word as u16;
        (word >> 16 == u32::from(!sequence)).then_some(sequence)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trip_is_handed_over_once_and_a_flipped_bit_makes_it_another() {
        let interlock = Interlock::released();
        assert_eq!((interlock.take_trip(), interlock.forbids()), (None, false));
        for cause in [Cause::Panic, Cause::Fault, Cause::Watchdog, Cause::BrownOut, Cause::Memory, Cause::BitFlip] {
            interlock.trip(cause);
            assert!(interlock.forbids());
            assert_eq!([interlock.take_trip(), interlock.take_trip()], [Some(cause), None]);
            assert!(!interlock.forbids());
        }
        for bit in 0..32 {
            let flipped = Interlock { trip: AtomicU32::new(1 << bit), ..Interlock::released() };
            assert!(flipped.take_trip().is_some() && flipped.take_trip().is_none());
        }
    }

    #[test]
    fn an_expired_timer_forbids_until_it_is_taken_and_counts_but_for_proofs() {
        let interlock = Interlock::released();
        assert!(!interlock.expired.take());
        interlock.expire();
        assert!(interlock.forbids() && !interlock.requests_trip());
        assert_eq!((interlock.expired.take(), interlock.expired.take(), interlock.deadlines()), (true, false, 1));
        interlock.prove(|| interlock.expire());
        assert_eq!((interlock.forbids(), interlock.deadlines()), (false, 1));
        // One that has expired before a proof is not forgotten by it.
        interlock.expire();
        interlock.prove(|| interlock.expire());
        assert_eq!((interlock.expired.take(), interlock.deadlines()), (true, 2));
    }

    #[test]
    fn a_stop_is_taken_once_and_no_flipped_bit_is_one() {
        let interlock = Interlock::released();
        assert_eq!(interlock.take_stop(), None);
        for sequence in [0, 1, 0x1234, u16::MAX] {
            interlock.stop(sequence);
            assert_eq!([interlock.take_stop(), interlock.take_stop()], [Some(sequence), None]);
            for bit in 0..32 {
                interlock.stop(sequence);
                interlock.stop.store(interlock.stop.load(Relaxed) ^ 1 << bit, Relaxed);
                assert_eq!(interlock.take_stop(), None);
            }
        }
        for bit in 0..32 {
            interlock.stop.store(1 << bit, Relaxed);
            assert_eq!(interlock.take_stop(), None);
        }
    }
}
