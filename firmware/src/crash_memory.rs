//! What RAM keeps across a reset, since a start does not clear it: the crash record
//! ([`firmware::crash_record`]) and the trip counter ([`dr_core::control::lockout`]).

use dr_core::control::{Lockout, LockoutWords};
use firmware::crash_record::{CrashRecord, CrashWords, WORDS};

/// The start does not clear this section of the RAM.
#[unsafe(link_section = ".uninit.CRASH_RECORD")]
static mut RECORD: core::mem::MaybeUninit<CrashWords> = core::mem::MaybeUninit::uninit();

/// Twice, since a reset may come in the middle of writing.
type LockoutCopies = [LockoutWords; 2];

#[unsafe(link_section = ".uninit.LOCKOUT")]
static mut LOCKOUT: core::mem::MaybeUninit<LockoutCopies> = core::mem::MaybeUninit::uninit();

/// The trip counter of before the reset, if one of its copies is whole.
pub fn read_lockout() -> Option<Lockout> {
    // SAFETY: any bits are words. Volatile, since the compiler sees no write to them. The start
    // reads and writes them, when nothing else runs; then the control task alone.
    let copies = unsafe { (&raw const LOCKOUT).cast::<LockoutCopies>().read_volatile() };
    copies.iter().find_map(Lockout::read)
}

/// Writes the trip counter, one copy after the other.
pub fn write_lockout(words: &LockoutWords) {
    let copies = (&raw mut LOCKOUT).cast::<LockoutWords>();
    for copy in 0..2 {
        // SAFETY: as for reading; there are two of them.
        unsafe { copies.add(copy).write_volatile(*words) }
    }
}

/// The words as they stand in RAM.
pub fn read() -> CrashWords {
    // SAFETY: any bits are words. Volatile, since the compiler sees no write to them. Only the
    // start and a crash write them, when nothing else runs, and the control task, which alone
    // acknowledges.
    unsafe { (&raw const RECORD).cast::<[u32; WORDS]>().read_volatile() }
}

/// Writes a crash record.
pub fn write(life: &CrashRecord) {
    // SAFETY: as for reading.
    unsafe { (&raw mut RECORD).cast::<[u32; WORDS]>().write_volatile(life.record()) }
}

/// Clears the record, as a loss of power does.
#[cfg(feature = "virtual-board")]
pub fn forget() {
    // SAFETY: as for reading; the board restarts at once.
    unsafe { (&raw mut RECORD).cast::<[u32; WORDS]>().write_volatile([0; WORDS]) }
}
