//! Trip counter with lock-out: three trips in ten minutes, and nothing that a host sends starts the
//! instrument again.
//!
//! Without it a host that acknowledges and starts anew keeps the mean power of a head high, however
//! often the guard trips. What lifts the lock is the supply or the reset pin: somebody who is
//! there.
//!
//! | counts towards the lock | does not |
//! |---|---|
//! | a trip that ends a run or a self-test that heats | a reading that trips in standby, as a plug does that is not in its place: nothing has heated |
//! | a trip of the whole instrument in any state: a crash, a bit flip, a pin | `Restart`: a debug probe has reset the processor, as it does with each flashing |
//! | a supply that dips, once: the falling supply trips, and the start after it trips again | |
//!
//! Time is counted in ticks, so it stands still without a sample period and while the processor
//! restarts. It never runs faster than the clock on the wall: trips look closer together than they
//! are, and lock sooner.
//!
//! The state survives a reset by software or watchdog as [`LockoutWords`], which the board keeps
//! in RAM that a start does not clear. Its checksum is verified before every use: a state with a
//! flipped bit is locked.

use super::guard::{Cause, Trip};
use super::state::RunState;
use crate::checksum::Checksum;
use crate::fields::FieldVisitor;

/// Trips within [`LOCK_WINDOW_S`] that lock the instrument.
pub const LOCK_TRIPS: u32 = 3;

/// Interval within which they have to be, s.
pub const LOCK_WINDOW_S: u32 = 600;

/// The state as words in RAM, the checksum last.
pub type LockoutWords = [u32; 8];

/// The time of a trip that has not been.
const NEVER: u32 = u32::MAX;
const SECOND_US: u32 = 1_000_000;

/// Trips since the supply or the reset pin started the instrument.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TripHistory {
    /// Number of trips, in any state.
    pub trips: u32,
    /// Three of them in ten minutes have locked the instrument.
    pub is_locked: bool,
    /// The first of them.
    pub first: Option<FirstTrip>,
}

/// The first trip, and when it was.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FirstTrip {
    /// Its cause and its element.
    pub trip: Trip,
    /// Seconds of ticks since the supply or the reset pin started the instrument.
    pub at_s: u32,
}

/// The trip counter. It decides whether a trip can be acknowledged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lockout {
    /// Seconds of ticks.
    time_s: u32,
    trips: u32,
    /// Times of the last trips that count, the newest first.
    recent_s: [u32; LOCK_TRIPS as usize - 1],
    /// 0, or locked.
    locked: u32,
    /// The state word of the first trip; 0 without one.
    first: u32,
    first_s: u32,
    /// Checksum of all of the above.
    sealed: Checksum,
    /// Until the next second. Not sealed: a flipped bit makes the time late, or early by a second.
    until_second_us: u32,
}

impl Default for Lockout {
    fn default() -> Self {
        Self::new()
    }
}

impl Lockout {
    /// No trip yet, as after the supply or the reset pin.
    pub fn new() -> Self {
        Self::of([0, 0, NEVER, NEVER, 0, 0, 0])
    }

    /// Locked: for a state that should be there and cannot be read.
    pub fn locked() -> Self {
        Self::of([0, 0, NEVER, NEVER, 1, 0, 0])
    }

    fn of([time_s, trips, newest_s, oldest_s, locked, first, first_s]: [u32; 7]) -> Self {
        let recent_s = [newest_s, oldest_s];
        let (sealed, until_second_us) = (Checksum::default(), SECOND_US);
        let mut new = Self { time_s, trips, recent_s, locked, first, first_s, sealed, until_second_us };
        new.sealed = new.checksum();
        new
    }

    /// The state that these words hold; none if it is not whole.
    pub fn read(&[time_s, trips, newest_s, oldest_s, locked, first, first_s, sealed]: &LockoutWords) -> Option<Self> {
        let read = Self::of([time_s, trips, newest_s, oldest_s, locked, first, first_s]);
        (read.sealed.word_of_it() == sealed).then_some(read)
    }

    /// The state as words.
    pub const fn words(&self) -> LockoutWords {
        let [newest_s, oldest_s] = self.recent_s;
        let sealed = self.sealed.word_of_it();
        [self.time_s, self.trips, newest_s, oldest_s, self.locked, self.first, self.first_s, sealed]
    }

    /// Tells whether trips cannot be acknowledged any more.
    pub fn is_locked(&self) -> bool {
        self.locked != 0 || !self.is_intact()
    }

    /// Trips so far, for people.
    pub fn history(&self) -> TripHistory {
        let first = RunState::tripped_of(self.first).map(|trip| FirstTrip { trip, at_s: self.first_s });
        TripHistory { trips: self.trips, is_locked: self.is_locked(), first }
    }

    /// Counts a trip of an instrument that was in this state.
    pub(super) fn count(&mut self, before: RunState, trip: Trip) {
        let heated = matches!(before, RunState::Running | RunState::Testing);
        self.change(|new| {
            new.trips = new.trips.saturating_add(1);
            if new.trips == 1 {
                (new.first, new.first_s) = (RunState::Tripped(trip).word(), new.time_s);
            }
            let [newest_s, oldest_s] = new.recent_s;
            let is_same_dip = trip.cause == Cause::BrownOut && newest_s == new.time_s;
            if (!heated && trip.element.is_some()) || trip.cause == Cause::Restart || is_same_dip {
                return;
            }
            if oldest_s != NEVER && new.time_s.wrapping_sub(oldest_s) <= LOCK_WINDOW_S {
                new.locked = 1;
            }
            new.recent_s = [new.time_s, newest_s];
        });
    }

    /// A tick has passed.
    pub(super) fn tick(&mut self, sample_period_s: f32) {
        let period_us = (sample_period_s * SECOND_US as f32) as u32;
        if let Some(left @ 1..) = self.until_second_us.checked_sub(period_us) {
            self.until_second_us = left;
            return;
        }
        let over_us = period_us.saturating_sub(self.until_second_us);
        self.until_second_us = SECOND_US - over_us % SECOND_US;
        self.change(|new| new.time_s = new.time_s.saturating_add(1 + over_us / SECOND_US));
    }

    /// Changes the state, and seals it anew. A flipped bit locks instead of being sealed in.
    fn change(&mut self, change: impl FnOnce(&mut Self)) {
        self.locked |= u32::from(!self.is_intact());
        change(self);
        self.sealed = self.checksum();
    }

    fn is_intact(&self) -> bool {
        self.sealed == self.checksum()
    }

    fn checksum(&self) -> Checksum {
        let [words @ .., _] = self.words();
        let mut checksum = Checksum::default();
        words.iter().for_each(|&word| checksum.word(word));
        checksum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OPEN: Trip = Trip::of(2, Cause::Open);

    /// So many seconds, in ticks of 10 ms.
    fn wait(lockout: &mut Lockout, seconds: u32) {
        (0..100 * seconds).for_each(|_| lockout.tick(0.01));
    }

    fn after_trips(apart_s: [u32; 2]) -> Lockout {
        let mut lockout = Lockout::new();
        lockout.count(RunState::Running, OPEN);
        for apart_s in apart_s {
            wait(&mut lockout, apart_s);
            lockout.count(RunState::Testing, OPEN);
        }
        lockout
    }

    #[test]
    fn three_trips_in_ten_minutes_lock_and_more_slowly_they_do_not() {
        assert!(after_trips([0, 0]).is_locked() && after_trips([300, 300]).is_locked());
        assert!(!after_trips([300, 301]).is_locked());
        let mut lockout = after_trips([601, 0]);
        assert!(!lockout.is_locked());
        lockout.count(RunState::Running, OPEN);
        assert!(lockout.is_locked(), "the last three are close together");
        wait(&mut lockout, 2 * LOCK_WINDOW_S);
        assert!(lockout.is_locked(), "no waiting lifts the lock");
    }

    #[test]
    fn a_plug_that_is_not_in_its_place_in_standby_does_not_lock_but_counts() {
        let mut lockout = Lockout::new();
        wait(&mut lockout, 7);
        for _ in 0..9 {
            lockout.count(RunState::Standby, OPEN);
        }
        let first = Some(FirstTrip { trip: OPEN, at_s: 7 });
        assert_eq!(lockout.history(), TripHistory { trips: 9, is_locked: false, first });
        // Starts that nobody asked for are found in standby, too.
        for _ in 0..3 {
            lockout.count(RunState::Standby, Trip::whole(Cause::Watchdog));
        }
        assert_eq!(lockout.history(), TripHistory { trips: 12, is_locked: true, first });
    }

    #[test]
    fn a_probes_resets_do_not_lock_and_a_dip_of_the_supply_counts_once() {
        let mut lockout = Lockout::new();
        for state in [RunState::Standby, RunState::Running, RunState::Testing, RunState::Running] {
            lockout.count(state, Trip::whole(Cause::Restart));
        }
        assert!(!lockout.is_locked());
        for is_locked in [false, false, true] {
            wait(&mut lockout, 5);
            lockout.count(RunState::Running, Trip::whole(Cause::BrownOut));
            // RAM has kept the state, and the start trips again.
            let mut restarted = Lockout::read(&lockout.words()).unwrap();
            restarted.count(RunState::Standby, Trip::whole(Cause::BrownOut));
            lockout = restarted;
            assert_eq!(lockout.is_locked(), is_locked);
        }
        assert_eq!(lockout.history().trips, 10);
    }

    #[test]
    fn time_is_that_of_the_ticks_at_any_period_and_never_fast() {
        for (period_s, ticks, time_s) in [(1e-4, 100_000, 10), (0.1, 7_000, 700), (0.3, 1_000, 300), (10.0, 30, 300)] {
            let mut lockout = Lockout::new();
            (0..ticks).for_each(|_| lockout.tick(period_s));
            // 0.3 s is 300 000 µs, 1e-4 s may be 99.
            assert!((time_s - time_s / 50..=time_s).contains(&lockout.time_s), "{period_s}: {}", lockout.time_s);
        }
        let mut lockout = Lockout::new();
        for period_s in [0.0001, 10.0, 0.7, 0.2] {
            lockout.tick(period_s);
        }
        assert_eq!(lockout.time_s, 10);
    }

    #[test]
    fn what_comes_back_from_ram_goes_on_where_it_was() {
        let mut lockout = Lockout::new();
        wait(&mut lockout, 50);
        lockout.count(RunState::Running, OPEN);
        lockout.count(RunState::Running, OPEN);
        let mut restored = Lockout::read(&lockout.words()).unwrap();
        assert_eq!(restored, lockout);
        restored.count(RunState::Standby, Trip::whole(Cause::Fault));
        assert!(restored.is_locked());
        assert!(Lockout::read(&restored.words()).unwrap().is_locked());
    }

    #[test]
    fn no_flipped_bit_unlocks() {
        let words = after_trips([0, 0]).words();
        for word in 0..words.len() {
            for bit in 0..32 {
                let mut flipped = words;
                flipped[word] ^= 1 << bit;
                assert_eq!(Lockout::read(&flipped), None, "word {word}, bit {bit}");
            }
        }
        for memory in [[0; 8], [u32::MAX; 8]] {
            assert_eq!(Lockout::read(&memory), None);
        }
        // In use, one locks, and the next change does not seal it in.
        let mut lockout = Lockout::new();
        lockout.trips ^= 1;
        assert!(lockout.is_locked());
        wait(&mut lockout, 1);
        assert!(lockout.is_intact() && lockout.is_locked());
        assert!(Lockout::locked().is_locked());
    }
}
