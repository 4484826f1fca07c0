//! When nothing can go on: heaters to the low level before anything else, then what happened into RAM that outlasts the
//! reset, then a word for the log, then a new start, tripped until somebody acknowledges it ([`firmware::past_life`]).

use crate::board;
use core::panic::PanicInfo;
use cortex_m_rt::{ExceptionFrame, exception};
use firmware::past_life::{self, PastLife, Record, WORDS};
use wire::{Crash, CrashKind, Name, ResetCause};

/// Left alone by the start, which clears the rest of the RAM.
#[unsafe(link_section = ".uninit.PAST_LIFE")]
static mut RECORD: core::mem::MaybeUninit<Record> = core::mem::MaybeUninit::uninit();

fn read() -> Record {
    // SAFETY: any bits are words. Volatile, since nothing that the compiler knows of has written them. Whoever writes them is the start
    // or an end, when nothing else runs, or the control task, which is alone in acknowledging.
    unsafe { (&raw const RECORD).cast::<[u32; WORDS]>().read_volatile() }
}

fn write(life: &PastLife) {
    // SAFETY: as for reading.
    unsafe { (&raw mut RECORD).cast::<[u32; WORDS]>().write_volatile(life.record()) }
}

/// The life that begins, and why; once a start.
pub fn past_life(reset: ResetCause) -> (ResetCause, PastLife) {
    let life = PastLife::after(&read(), reset);
    write(&life);
    (board::reset_as_remembered(reset, &life), life)
}

/// The crash has been acknowledged: the next start is one like any other.
pub fn acknowledge() {
    if let Some(life) = PastLife::read(&read()) {
        write(&PastLife { crash: None, ..life });
    }
}

/// Nothing is known of any life before, as after the supply was gone.
#[cfg(feature = "virtual-board")]
pub fn forget() {
    // SAFETY: as for reading; the board restarts at once.
    unsafe { (&raw mut RECORD).cast::<[u32; WORDS]>().write_volatile([0; WORDS]) }
}

/// Remembers a crash over the reset that follows. One that nobody has acknowledged stays: the first is the one to look into.
fn remember(kind: CrashKind, file: Name, at: u32) {
    let life = PastLife::read(&read()).unwrap_or(PastLife::FIRST);
    if life.crash.is_none() {
        write(&PastLife { crash: Some(Crash { kind, file, at }), ..life });
    }
}

/// The end of this life. Heaters first, in any case.
fn end(kind: CrashKind, file: &str, at: u32) -> ! {
    cortex_m::interrupt::disable();
    board::heaters_low();
    remember(kind, past_life::end_of(file), at);
    match kind {
        // The place is enough to find the cause, and needs no formatting of numbers that only panics would use.
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

/// A hard fault, from `fault_entry`. After an overflow of the stack there may be no frame that tells where.
pub fn fault(frame: Option<&ExceptionFrame>) -> ! {
    end(CrashKind::Fault, "", frame.map_or(0, ExceptionFrame::pc))
}

/// An interrupt that nobody has asked for; where its number would be an address it can be told from one.
#[exception]
unsafe fn DefaultHandler(number: i16) -> ! {
    end(CrashKind::Fault, "interrupt", number as u32)
}
