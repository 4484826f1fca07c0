//! Crash record in RAM that survives a reset: start counter, and cause of the last crash.
//!
//! The start of the firmware does not clear this RAM. The record has thirteen words:
//!
//! | word | |
//! |---|---|
//! | 0 | starts since power-on |
//! | 1 | 0: no crash; 1: panic; 2: fault; bit 15: this firmware has asked for the reset that follows; in the upper half the length of the text |
//! | 2 | line or address |
//! | 3 … 10 | text |
//! | 11 | complement of word 0: RAM is random after power-on, and the CRC alone would accept it once in 4·10⁹; changed by `LAYOUT` |
//! | 12 | CRC-32 of the words before |
//!
//! An invalid record, after power-on or a bit flip, counts as a first start.

use crc::{CRC_32_ISO_HDLC, Crc, NoTable};
use dr_core::control::{Cause, Lockout};
use wire::{Crash, CrashKind, Name, ResetCause};

/// Length of the record.
pub const WORDS: usize = 13;
const TEXT: core::ops::Range<usize> = 3..11;

/// What RAM keeps beside this record: a firmware that has been flashed over another one does not
/// look for what that has not kept.
const LAYOUT: u32 = 2;
/// In word 1.
const REQUESTED: u32 = 1 << 15;

/// The record as words in RAM.
pub type CrashWords = [u32; WORDS];

/// Without a table: small, and fast enough for one use per start.
const CHECK: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

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
    pub fn read(record: &CrashWords) -> Option<Self> {
        let [words @ .., check] = record;
        let [starts, head, at, ..] = *words;
        let complement = words.last().copied()?;
        if check_of(words) != *check || complement != !starts ^ LAYOUT {
            return None;
        }
        let requested = head & REQUESTED != 0;
        let kind = match head & 0xffff & !REQUESTED {
            0 => return Some(Self { starts, crash: None, requested }),
            1 => CrashKind::Panic,
            2 => CrashKind::Fault,
            _ => return None,
        };
        let mut text = [0; 32];
        for (bytes, word) in text.chunks_exact_mut(4).zip(words.get(TEXT)?) {
            bytes.copy_from_slice(&word.to_le_bytes());
        }
        let text = text.get(..(head >> 16) as usize)?;
        let file = Name::try_from(core::str::from_utf8(text).ok()?).ok()?;
        Some(Self { starts, crash: Some(Crash { kind, file, at }), requested })
    }

    /// Encodes the record.
    pub fn record(&self) -> CrashWords {
        let mut record = [0; WORDS];
        let [words @ .., check] = &mut record;
        let [starts, head, at, text @ .., complement] = words;
        (*starts, *complement) = (self.starts, !self.starts ^ LAYOUT);
        if let Some(crash) = &self.crash {
            let kind = match crash.kind {
                CrashKind::Panic => 1,
                CrashKind::Fault => 2,
            };
            *head = kind | (crash.file.len() as u32) << 16;
            *at = crash.at;
            for (word, bytes) in text.iter_mut().zip(crash.file.as_bytes().chunks(4)) {
                let mut four = [0; 4];
                four.iter_mut().zip(bytes).for_each(|(to, from)| *to = *from);
                *word = u32::from_le_bytes(four);
            }
        }
        *head |= if self.requested { REQUESTED } else { 0 };
        *check = check_of(words);
        record
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

fn check_of(words: &[u32]) -> u32 {
    let mut digest = CHECK.digest();
    words.iter().for_each(|word| digest.update(&word.to_le_bytes()));
    digest.finalize()
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
        for word in 0..WORDS {
            for bit in 0..32 {
                let mut record = past().record();
                record[word] ^= 1 << bit;
                assert_eq!(CrashRecord::after(&record), CrashRecord::FIRST, "word {word}, bit {bit}");
            }
        }
        for record in [[0; WORDS], [u32::MAX; WORDS]] {
            assert_eq!(CrashRecord::read(&record), None);
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
