//! What outlasts a reset: how often the board has started, and what it died of.
//!
//! It stands in RAM that the start leaves alone, as thirteen words:
//!
//! | word | |
//! |---|---|
//! | 0 | starts since the supply came up |
//! | 1 | 0: no crash; 1: panic; 2: fault; in the upper half the length of the text |
//! | 2 | line or address |
//! | 3 … 10 | text |
//! | 11 | its complement to word 0: RAM that has just come up is random, and 32 bit of check alone would pass once in 4·10⁹ |
//! | 12 | CRC-32 of the words before |
//!
//! RAM that does not hold it, because the supply was gone or a bit has flipped, is a first start.

use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use crc::{CRC_32_ISO_HDLC, Crc, NoTable};
use dr_core::control::Cause;
use wire::{Crash, CrashKind, Name, ResetCause};

/// Length of the record.
pub const WORDS: usize = 13;
const TEXT: core::ops::Range<usize> = 3..11;

/// As it stands in RAM.
pub type Record = [u32; WORDS];

/// Slow and small: it is computed once a start.
const CHECK: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

/// What is known of the lives before.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PastLife {
    /// Starts since the supply came up, this one included.
    pub starts: u32,
    /// What nobody has acknowledged yet.
    pub crash: Option<Crash>,
}

impl PastLife {
    /// Of a board that has just been switched on.
    pub const FIRST: Self = Self { starts: 1, crash: None };

    /// Reads a record; none if it is not one.
    pub fn read(record: &Record) -> Option<Self> {
        let [words @ .., check] = record;
        let [starts, head, at, ..] = *words;
        let complement = words.last().copied()?;
        if check_of(words) != *check || complement != !starts {
            return None;
        }
        let kind = match head & 0xffff {
            0 => return Some(Self { starts, crash: None }),
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
        Some(Self { starts, crash: Some(Crash { kind, file, at }) })
    }

    /// The record of it.
    pub fn record(&self) -> Record {
        let mut record = [0; WORDS];
        let [words @ .., check] = &mut record;
        let [starts, head, at, text @ .., complement] = words;
        (*starts, *complement) = (self.starts, !self.starts);
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
        *check = check_of(words);
        record
    }

    /// The life that begins with this reset.
    pub fn after(record: &Record, reset: ResetCause) -> Self {
        match Self::read(record) {
            Some(past) if reset != ResetCause::PowerOn => Self { starts: past.starts.wrapping_add(1), ..past },
            _ => Self::FIRST,
        }
    }

    /// What the instrument is tripped for from its start on, if it did not start as it should.
    pub fn trip(&self, reset: ResetCause) -> Option<Cause> {
        match (&self.crash, reset) {
            (Some(Crash { kind: CrashKind::Panic, .. }), _) => Some(Cause::Panic),
            (Some(Crash { kind: CrashKind::Fault, .. }), _) => Some(Cause::Fault),
            (None, ResetCause::PowerOn | ResetCause::Pin) => None,
            (None, ResetCause::Watchdog) => Some(Cause::Watchdog),
            (None, ResetCause::BrownOut) => Some(Cause::BrownOut),
            // Only a panic or a fault asks for a reset, and its record is lost; or the processor does not know.
            (None, ResetCause::Software | ResetCause::Unknown) => Some(Cause::Fault),
        }
    }
}

/// What the instrument is to be tripped for, on its way from the start to the controller. A word, of which every value means something: a
/// flipped bit makes it another trip, and nothing else.
pub struct PastTrip(AtomicU32);

impl PastTrip {
    /// Nothing.
    pub const fn none() -> Self {
        Self(AtomicU32::new(0))
    }

    /// This.
    pub fn put(&self, cause: Cause) {
        self.0.store(cause as u32 + 1, Relaxed);
    }

    /// Once.
    pub fn take(&self) -> Option<Cause> {
        let word = self.0.load(Relaxed).checked_sub(1)?;
        self.0.store(0, Relaxed);
        let known = [Cause::Panic, Cause::Fault, Cause::Watchdog, Cause::BrownOut];
        Some(known.into_iter().find(|&cause| cause as u32 == word).unwrap_or(Cause::Upset))
    }
}

/// The end of a path, as much of it as a record holds.
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

    fn past() -> PastLife {
        let file = end_of("/some/where/far/down/in/a/folder/dr-core/src/control/drive.rs");
        PastLife { starts: 7, crash: Some(Crash { kind: CrashKind::Panic, file, at: 1234 }) }
    }

    #[test]
    fn a_trip_is_handed_over_once_and_a_flipped_bit_makes_it_another() {
        let trip = PastTrip::none();
        assert_eq!(trip.take(), None);
        for cause in [Cause::Panic, Cause::Fault, Cause::Watchdog, Cause::BrownOut] {
            trip.put(cause);
            assert_eq!([trip.take(), trip.take()], [Some(cause), None]);
        }
        for bit in 0..32 {
            let flipped = PastTrip(AtomicU32::new(1 << bit));
            assert!(flipped.take().is_some() && flipped.take().is_none());
        }
    }

    #[test]
    fn it_comes_out_as_it_went_in() {
        let fault = Crash { kind: CrashKind::Fault, file: Name::new(), at: 0x0800_1234 };
        for life in [past(), PastLife::FIRST, PastLife { starts: u32::MAX, crash: Some(fault) }] {
            assert_eq!(PastLife::read(&life.record()), Some(life));
        }
        assert_eq!(past().crash.unwrap().file, "lder/dr-core/src/control/drive.rs"[1..]);
    }

    #[test]
    fn a_flipped_bit_or_fresh_memory_is_a_first_start() {
        for word in 0..WORDS {
            for bit in 0..32 {
                let mut record = past().record();
                record[word] ^= 1 << bit;
                assert_eq!(PastLife::after(&record, ResetCause::Pin), PastLife::FIRST, "word {word}, bit {bit}");
            }
        }
        for record in [[0; WORDS], [u32::MAX; WORDS]] {
            assert_eq!(PastLife::read(&record), None);
        }
    }

    #[test]
    fn a_crash_is_remembered_until_it_is_acknowledged_or_the_supply_goes() {
        let second = PastLife::after(&past().record(), ResetCause::Pin);
        assert_eq!((second.starts, second.trip(ResetCause::Pin)), (8, Some(Cause::Panic)));
        assert_eq!(PastLife::after(&past().record(), ResetCause::PowerOn), PastLife::FIRST);
    }

    #[test]
    fn a_start_that_nobody_asked_for_trips() {
        let trips = |reset| PastLife::FIRST.trip(reset);
        assert_eq!([trips(ResetCause::PowerOn), trips(ResetCause::Pin)], [None; 2]);
        assert_eq!(trips(ResetCause::Watchdog), Some(Cause::Watchdog));
        assert_eq!(trips(ResetCause::BrownOut), Some(Cause::BrownOut));
        assert_eq!(trips(ResetCause::Software), Some(Cause::Fault));
        assert_eq!(trips(ResetCause::Unknown), Some(Cause::Fault));
    }
}
