//! Heater levels, restart and loss of power of the virtual board.

use core::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use cortex_m::peripheral::SCB;

/// What would be the heaters' pins.
pub static PINS: AtomicUsize = AtomicUsize::new(0);

/// Puts all heaters at the low level at once.
pub fn heaters_low() {
    PINS.store(0, Relaxed);
}

/// A new start, with the RAM as it is. The emulator's links stay open.
pub fn restart() -> ! {
    heaters_low();
    SCB::sys_reset()
}

/// The supply is gone, and comes back: nothing is known of the life before.
pub fn lose_power() -> ! {
    crate::crash_memory::forget();
    restart()
}
