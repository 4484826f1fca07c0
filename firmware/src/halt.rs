//! When nothing can go on: heaters to the low level before anything else, then a word for the log, then a new start.

use crate::board;
use core::panic::PanicInfo;
use cortex_m_rt::ExceptionFrame;

/// Exit codes of the virtual board, which cannot be reset without losing its host.
const PANICKED: u8 = 101;
const FAULTED: u8 = 102;

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    cortex_m::interrupt::disable();
    board::heaters_low();
    // The place is enough to find the cause, and needs no formatting of numbers that only panics would use.
    if let Some(place) = info.location() {
        defmt::error!("panic at {=str}:{=u32}", place.file(), place.line());
    }
    board::restart(PANICKED)
}

#[defmt::panic_handler]
fn defmt_panic() -> ! {
    cortex_m::interrupt::disable();
    board::heaters_low();
    board::restart(PANICKED)
}

/// A hard fault, from `fault_entry`. After an overflow of the stack there may be no frame that tells where.
pub fn fault(frame: Option<&ExceptionFrame>) -> ! {
    board::heaters_low();
    defmt::error!("hard fault at {=u32:#x}", frame.map_or(0, ExceptionFrame::pc));
    board::restart(FAULTED)
}
