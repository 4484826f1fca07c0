//! Clock tree, and time as counted by it.
//!
//! ```text
//! crystal 8 MHz ─► PLL ─► AHB 168 MHz ─┬─► APB1 42 MHz (USART2)
//!                                      └─► APB2 84 MHz (SPI1: 84/8 = 10.5 MHz)
//! ```
//!
//! These are the largest frequencies of the STM32F405 (data sheet: 168, 42, 84 MHz at 2.7 … 3.6 V).
//! The measurements do not hang on this clock: ticks are counted by the ADC's own.

use cortex_m::peripheral::DWT;
use embedded_hal::delay::DelayNs;
use stm32f4xx_hal::pac::TIM2;
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::{Config, Enable, Rcc};

/// Core clock.
pub const CLOCK_HZ: u32 = 168_000_000;
/// Core cycles in a microsecond.
pub const CYCLES_PER_US: u32 = CLOCK_HZ / 1_000_000;
/// Counts of the stopwatch in a microsecond: timers of APB1 run at twice its clock, half the core's.
pub const COUNTS_PER_US: u32 = CYCLES_PER_US / 2;

/// Starts crystal, PLL and cycle counter. If the crystal does not start, neither does the board:
/// heaters stay low. If it stops later, the clock security system puts the core on its own
/// oscillator and raises the NMI, whose handler lowers the heaters and restarts (RM0090, "Clock
/// security system").
pub fn start(rcc: Rcc, core: &mut cortex_m::Peripherals) -> Rcc {
    let config = Config::hse(8.MHz())
        .sysclk(CLOCK_HZ.Hz())
        .hclk(CLOCK_HZ.Hz())
        .pclk1((CLOCK_HZ / 4).Hz())
        .pclk2((CLOCK_HZ / 2).Hz());
    let rcc = rcc.freeze(config);
    // The HAL takes the nearest that it finds.
    assert!(rcc.clocks.hclk().raw() == CLOCK_HZ, "168 MHz can be made of 8 MHz: 8/4·168/2");
    rcc.cr().modify(|_, w| w.csson().on());
    core.DCB.enable_trace();
    core.DWT.enable_cycle_counter();
    rcc
}

/// The cycle counter; wraps every 25.6 s.
pub fn cycles() -> u32 {
    DWT::cycle_count()
}

/// Starts the stopwatch, whose time goes on while the core sleeps: timer 2, 32 bit, at 84 MHz; it
/// wraps every 51 s.
///
/// The cycle counter stands still in sleep unless a debugger's bit (DBG_SLEEP) is set. A timer has
/// a clock of its own, which sleep leaves on (RM0090, RCC_APB1LPENR after reset).
pub fn start_stopwatch(timer: &TIM2, rcc: &mut Rcc) {
    TIM2::enable(rcc);
    timer.cr1().modify(|_, w| w.cen().enabled());
}

/// Counts of the stopwatch since its start.
pub fn counts() -> u32 {
    // SAFETY: a read that changes nothing.
    unsafe { (*TIM2::ptr()).cnt().read().bits() }
}

/// Waits by the cycle counter.
#[derive(Clone, Copy)]
pub struct CycleDelay;

impl DelayNs for CycleDelay {
    fn delay_ns(&mut self, ns: u32) {
        let start = cycles();
        // Rounded up; 4.3 s, the longest that a u32 of nanoseconds can say, is well within the
        // counter.
        let wanted = (u64::from(ns) * u64::from(CYCLES_PER_US)).div_ceil(1_000) as u32;
        while cycles().wrapping_sub(start) < wanted {}
    }
}
