//! Time that goes on while the core sleeps: timer 2, 32 bit, at 84 MHz.
//!
//! The cycle counter stands still in sleep unless a debugger's bit (DBG_SLEEP) is set. A timer has
//! a clock of its own, which sleep leaves on (RM0090, RCC_APB1LPENR after reset).

use super::clocks::CYCLES_PER_US;
use stm32f4xx_hal::pac::TIM2;
use stm32f4xx_hal::rcc::{Enable, Rcc};

/// Counts in a microsecond: timers of APB1 run at twice its clock, half the core's.
pub const COUNTS_PER_US: u32 = CYCLES_PER_US / 2;

/// Lets it count, up to the end of its 32 bits and again; it wraps every 51 s.
pub fn start(timer: &TIM2, rcc: &mut Rcc) {
    TIM2::enable(rcc);
    timer.cr1().modify(|_, w| w.cen().enabled());
}

/// Counts since the start.
pub fn counts() -> u32 {
    // SAFETY: a read that changes nothing.
    unsafe { (*TIM2::ptr()).cnt().read().bits() }
}
