//! Panic and fault handlers: heaters to the low level first, then the crash record into RAM that
//! survives the reset, then a log message, then a restart, tripped until it is acknowledged
//! ([`firmware::crash_record`]).

use crate::board;
use crate::crash_memory::{self, read, write};
use core::panic::PanicInfo;
use cortex_m_rt::{ExceptionFrame, exception};
use dr_core::control::Lockout;
use firmware::crash_record::{self, CrashRecord};
use wire::{Crash, CrashKind, Name, ResetCause};

/// Updates the crash record for this start; returns it with the reset cause. Called once per start.
pub fn update_record(reset: ResetCause) -> (ResetCause, CrashRecord) {
    let record = CrashRecord::after(&read());
    write(&record.kept());
    (board::reset_as_remembered(reset, &record), record)
}

/// The trip counter after this reset: as it was, unless the supply or the reset pin has started the
/// board ([`CrashRecord::lockout`]).
pub fn lockout_after(reset: ResetCause, past: &CrashRecord) -> Lockout {
    let lockout = past.lockout(reset, crash_memory::read_lockout());
    crash_memory::write_lockout(&lockout.words());
    lockout
}

/// The crash has been acknowledged: the next start is one like any other.
pub fn acknowledge() {
    if let Some(record) = CrashRecord::read(&read()) {
        write(&CrashRecord { crash: None, ..record });
    }
}

/// Records a crash, and that the reset that follows is our own. An unacknowledged crash stays: the
/// first one is the one to investigate.
fn remember(kind: CrashKind, file: Name, at: u32) {
    let record = CrashRecord::read(&read()).unwrap_or(CrashRecord::FIRST);
    let crash = record.crash.or(Some(Crash { kind, file, at }));
    write(&CrashRecord { crash, requested: true, ..record });
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
