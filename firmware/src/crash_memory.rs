//! Crash record in RAM that a start does not clear ([`firmware::crash_record`]).

use firmware::crash_record::{CrashRecord, CrashWords, WORDS};

/// The start does not clear this section of the RAM.
#[unsafe(link_section = ".uninit.CRASH_RECORD")]
static mut RECORD: core::mem::MaybeUninit<CrashWords> = core::mem::MaybeUninit::uninit();

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
