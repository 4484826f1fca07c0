//! Crash record in RAM that survives a reset: start counter, and cause of the last crash.
//!
//! The start of the firmware does not clear this RAM. The record is the postcard encoding of its
//! fields between two words: the complement of the start counter, since RAM is random after
//! power-on and the CRC alone would accept it once in 4·10⁹, and a CRC-32 of all before it.
//!
//! An invalid record, after power-on or a bit flip, counts as a first start.

use dr_core::control::{Cause, Lockout};
use wire::settings::CHECK;
use wire::{Crash, CrashKind, Name, ResetCause};

/// Room for the fields: two counts of five bytes at most, a text of 32, and five bytes more.
const MOST_BYTES: usize = 48;

/// What RAM keeps beside this record: a firmware that has been flashed over another one does not
/// look for what that has not kept.
const LAYOUT: u32 = 3;

/// The record as words in RAM.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct CrashWords {
    /// Complement of the start counter, changed by `LAYOUT`.
    complement: u32,
    fields: [u8; MOST_BYTES],
    check: u32,
}

impl CrashWords {
    /// Words that are no record.
    pub const BLANK: Self = Self { complement: 0, fields: [0; MOST_BYTES], check: 0 };

    fn sum(&self) -> u32 {
        let mut digest = CHECK.digest();
        digest.update(&self.complement.to_le_bytes());
        digest.update(&self.fields);
        digest.finalize()
    }
}

/// Start counter, and the last crash.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CrashRecord {
    /// Starts since power-on, this one included.
    pub starts: u32,
    /// The crash that has not been acknowledged yet.
    pub crash: Option<Crash>,
    /// The firmware has asked for the last reset itself, after a panic or a fault.
    pub requested: bool,
}

impl CrashRecord {
    /// The record after power-on.
    pub const FIRST: Self = Self { starts: 1, crash: None, requested: false };

    /// Decodes a record; none if it is invalid.
    pub fn read(words: &CrashWords) -> Option<Self> {
        let (starts, crash, requested) = postcard::from_bytes::<(u32, _, _)>(&words.fields).ok()?;
        let is_valid = words.check == words.sum() && words.complement == !starts ^ LAYOUT;
        is_valid.then_some(Self { starts, crash, requested })
    }

    /// Encodes the record.
    #[inline(never)] // start, crash and acknowledgement share it
    pub fn record(&self) -> CrashWords {
        let mut words = CrashWords { complement: !self.starts ^ LAYOUT, ..CrashWords::BLANK };
        // It has room for the longest.
        postcard::to_slice(&(self.starts, &self.crash, self.requested), &mut words.fields).ok();
        words.check = words.sum();
        words
    }

    /// The record to be kept from this start on: the next reset has not been asked for.
    pub fn kept(&self) -> Self {
        Self { requested: false, ..self.clone() }
    }

    /// The record after a reset of any cause: a supply that has left it valid has only dipped.
    pub fn after(record: &CrashWords) -> Self {
        Self::read(record).map_or(Self::FIRST, |past| Self { starts: past.starts.wrapping_add(1), ..past })
    }

    /// The trip counter after this reset, given what RAM has kept of it. A gap of the supply in
    /// which RAM has lost this record or the counter clears it. Otherwise a counter that is lost
    /// although this record is whole is taken for locked: no crash may erase it.
    pub fn lockout(&self, reset: ResetCause, kept: Option<Lockout>) -> Lockout {
        match (reset, kept) {
            (ResetCause::PowerOn | ResetCause::Pin, _) | (ResetCause::BrownOut, None) => Lockout::new(),
            (ResetCause::BrownOut, _) if self.starts == 1 => Lockout::new(),
            (_, Some(kept)) => kept,
            (_, None) if self.starts > 1 => Lockout::locked(),
            (_, None) => Lockout::new(),
        }
    }

    /// Cause for which the instrument is tripped after an unrequested start.
    pub fn trip(&self, reset: ResetCause) -> Option<Cause> {
        match (&self.crash, reset) {
            // A crash that has not been acknowledged has counted when it came.
            (_, ResetCause::Software | ResetCause::Unknown) if !self.requested => Some(Cause::Restart),
            (Some(Crash { kind: CrashKind::Panic, .. }), _) => Some(Cause::Panic),
            (Some(Crash { kind: CrashKind::Fault, .. }), _) => Some(Cause::Fault),
            (None, ResetCause::PowerOn | ResetCause::Pin) => None,
            (None, ResetCause::Watchdog) => Some(Cause::Watchdog),
            (None, ResetCause::BrownOut) => Some(Cause::BrownOut),
            (None, ResetCause::Software | ResetCause::Unknown) => Some(Cause::Fault),
        }
    }
}

/// The end of a path, as long as the record has room.
pub fn end_of(path: &str) -> Name {
    let mut from = path.len().saturating_sub(Name::new().capacity());
    while !path.is_char_boundary(from) {
        from += 1;
    }
    path.get(from..).and_then(|end| Name::try_from(end).ok()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn past() -> CrashRecord {
        let file = end_of("/some/where/far/down/in/a/folder/dr-core/src/control/drive.rs");
        CrashRecord { starts: 7, crash: Some(Crash { kind: CrashKind::Panic, file, at: 1234 }), requested: true }
    }

    #[test]
    fn it_comes_out_as_it_went_in() {
        let fault = Crash { kind: CrashKind::Fault, file: Name::new(), at: 0x0800_1234 };
        for life in [past(), CrashRecord::FIRST, CrashRecord { starts: u32::MAX, crash: Some(fault), requested: true }]
        {
            assert_eq!(CrashRecord::read(&life.record()), Some(life.clone()));
            assert_eq!(CrashRecord::read(&life.kept().record()), Some(CrashRecord { requested: false, ..life }));
        }
        assert_eq!(past().crash.unwrap().file, "lder/dr-core/src/control/drive.rs"[1..]);
    }

    #[test]
    fn a_flipped_bit_or_fresh_memory_is_a_first_start() {
        let flips: [fn(&mut CrashWords, u32); 2] =
            [|words, bit| words.complement ^= 1 << bit, |words, bit| words.check ^= 1 << bit];
        for (flip, bit) in flips.into_iter().flat_map(|flip| (0..32).map(move |bit| (flip, bit))) {
            let mut words = past().record();
            flip(&mut words, bit);
            assert_eq!(CrashRecord::after(&words), CrashRecord::FIRST, "bit {bit}");
        }
        for bit in 0..8 * MOST_BYTES {
            let mut words = past().record();
            words.fields[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(CrashRecord::after(&words), CrashRecord::FIRST, "bit {bit} of the fields");
        }
        let ones = CrashWords { complement: u32::MAX, fields: [u8::MAX; MOST_BYTES], check: u32::MAX };
        for words in [CrashWords::BLANK, ones] {
            assert_eq!(CrashRecord::read(&words), None);
        }
    }

    #[test]
    fn a_crash_is_remembered_over_any_reset_that_leaves_the_record() {
        let second = CrashRecord::after(&past().record());
        assert_eq!((second.starts, second.trip(ResetCause::Pin)), (8, Some(Cause::Panic)));
    }

    #[test]
    fn only_supply_and_reset_pin_lift_a_lock_and_a_lost_one_is_a_lock() {
        let is_locked = |reset, kept| past().lockout(reset, kept).is_locked();
        for kept in [None, Some(Lockout::locked())] {
            assert!(!is_locked(ResetCause::PowerOn, kept) && !is_locked(ResetCause::Pin, kept));
            for reset in [ResetCause::Software, ResetCause::Watchdog, ResetCause::Unknown] {
                assert!(is_locked(reset, kept), "{reset:?}");
                assert!(!is_locked(reset, Some(Lockout::new())), "{reset:?}");
            }
        }
        // A dip that RAM has survived keeps the lock; one that has cost RAM, in part or all, lifts
        // it.
        assert!(is_locked(ResetCause::BrownOut, Some(Lockout::locked())));
        assert!(!is_locked(ResetCause::BrownOut, None));
        assert!(!CrashRecord::FIRST.lockout(ResetCause::BrownOut, Some(Lockout::locked())).is_locked());
        // Nothing has been kept at all: RAM was without power, or another firmware's.
        assert!(!CrashRecord::FIRST.lockout(ResetCause::BrownOut, None).is_locked());
    }

    #[test]
    fn an_unrequested_start_trips() {
        let trips = |reset| CrashRecord::FIRST.trip(reset);
        assert_eq!([trips(ResetCause::PowerOn), trips(ResetCause::Pin)], [None; 2]);
        assert_eq!(trips(ResetCause::Watchdog), Some(Cause::Watchdog));
        assert_eq!(trips(ResetCause::BrownOut), Some(Cause::BrownOut));
        // Those of a probe. That of a panic or a fault is asked for.
        assert_eq!([trips(ResetCause::Software), trips(ResetCause::Unknown)], [Some(Cause::Restart); 2]);
        assert_eq!(past().trip(ResetCause::Software), Some(Cause::Panic));
        assert_eq!(past().kept().trip(ResetCause::Software), Some(Cause::Restart));
        assert_eq!(past().kept().trip(ResetCause::Pin), Some(Cause::Panic));
    }
}
