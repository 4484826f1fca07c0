//! Panic and fault handlers: heaters to the low level first, then the crash record into RAM that
//! survives the reset, then a log message, then a restart, tripped until it is acknowledged
//! ([`firmware::crash_record`]).
//!
//! RAM keeps the record and the trip counter ([`dr_core::control::lockout`]) across a reset, since a
//! start does not clear them.

use crate::board;
use core::mem::MaybeUninit;
use core::panic::PanicInfo;
use cortex_m_rt::{ExceptionFrame, exception};
use dr_core::control::{Lockout, LockoutWords};
use firmware::crash_record::{self, CrashRecord, CrashWords};
use wire::{Crash, CrashKind, Name, ResetCause};

/// The start does not clear this section of the RAM.
#[unsafe(link_section = ".uninit.CRASH_RECORD")]
static mut RECORD: MaybeUninit<CrashWords> = MaybeUninit::uninit();

/// Twice, since a reset may come in the middle of writing.
type LockoutCopies = [LockoutWords; 2];

#[unsafe(link_section = ".uninit.LOCKOUT")]
static mut LOCKOUT: MaybeUninit<LockoutCopies> = MaybeUninit::uninit();

/// The trip counter of before the reset, if one of its copies is whole.
fn read_lockout() -> Option<Lockout> {
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
fn read() -> CrashWords {
    // SAFETY: any bits are words. Volatile, since the compiler sees no write to them. Only the
    // start and a crash write them, when nothing else runs, and the control task, which alone
    // acknowledges.
    unsafe { (&raw const RECORD).cast::<CrashWords>().read_volatile() }
}

fn write(words: CrashWords) {
    // SAFETY: as for reading.
    unsafe { (&raw mut RECORD).cast::<CrashWords>().write_volatile(words) }
}

/// Clears the record, as a loss of power does.
#[cfg(feature = "emulated")]
pub fn forget() {
    write(CrashWords::BLANK);
}

/// Updates crash record and trip counter for this start; returns both, with the reset cause. Called
/// once per start. The counter is as it was, unless the supply or the reset pin has started the
/// board ([`CrashRecord::lockout`]).
pub fn begin(reset: ResetCause) -> (ResetCause, CrashRecord, Lockout) {
    let record = CrashRecord::after(&read());
    write(record.kept().record());
    let reset = board::reset_as_remembered(reset, &record);
    let lockout = record.lockout(reset, read_lockout());
    write_lockout(&lockout.words());
    (reset, record, lockout)
}

/// The crash has been acknowledged: the next start is one like any other.
pub fn acknowledge() {
    if let Some(record) = CrashRecord::read(&read()) {
        write(CrashRecord { crash: None, ..record }.record());
    }
}

/// Records a crash, and that the reset that follows is our own. An unacknowledged crash stays: the
/// first one is the one to investigate.
fn remember(kind: CrashKind, file: Name, at: u32) {
    let record = CrashRecord::read(&read()).unwrap_or(CrashRecord::FIRST);
    let crash = record.crash.or(Some(Crash { kind, file, at }));
    write(CrashRecord { crash, requested: true, ..record }.record());
}

/// Ends this run of the firmware. Heaters first, in any case.
fn end(kind: CrashKind, file: &str, at: u32) -> ! {
    cortex_m::interrupt::disable();
    board::heaters_low();
    remember(kind, crash_record::end_of(file), at);
    match kind {
        // The place is enough to find the cause, and needs no formatting of numbers that only
        // panics would use.
        CrashKind::Panic => defmt::error!("panic at {=str}:{=u32}", file, at),
        CrashKind::Fault => defmt::error!("fault at {=u32:#x}", at),
    }
    board::restart()
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    let (file, line) = info.location().map_or(("", 0), |place| (place.file(), place.line()));
    end(CrashKind::Panic, file, line)
}

#[defmt::panic_handler]
fn defmt_panic() -> ! {
    end(CrashKind::Panic, "defmt", 0)
}

/// A hard fault, from `fault_entry`. After a stack overflow there may be no frame with the address.
pub fn fault(frame: Option<&ExceptionFrame>) -> ! {
    end(CrashKind::Fault, "", frame.map_or(0, ExceptionFrame::pc))
}

/// An unexpected interrupt: the record holds its number in place of an address.
#[exception]
unsafe fn DefaultHandler(number: i16) -> ! {
    end(CrashKind::Fault, "interrupt", number as u32)
}
