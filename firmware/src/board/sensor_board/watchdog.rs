//! Independent watchdog: half a second without a check-in of every task resets the board.
//!
//! It runs on its own oscillator of 17 … 47 kHz, nominally 32 (data sheet), so half a second is
//! 0.34 … 0.95 s, and it cannot be stopped once it runs. A first, longer period covers the start,
//! in which nobody can check in yet. It stands still while a debugger holds the core.
//!
//! The LED changes with every feeding, 20 times a second while all is well: a dark or steady one
//! means trouble.

use core::sync::atomic::{AtomicU16, Ordering::Relaxed};
use stm32f4xx_hal::gpio::{Output, PB1};
use stm32f4xx_hal::pac::{DBGMCU, IWDG};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::watchdog::IndependentWatchdog;

/// For the start: the ADC takes 0.5 s, and the slow oscillator may be half as fast again as it
/// says.
const START_MS: u32 = 4_000;
/// From then on.
const CHECK_IN_MS: u32 = 500;

/// Resets the board unless it is fed.
pub struct HardwareWatchdog {
    watchdog: IndependentWatchdog,
    led: PB1<Output>,
}

impl HardwareWatchdog {
    /// Starts it with the long period.
    pub fn new(watchdog: IWDG, debug: &DBGMCU, led: PB1<Output>) -> Self {
        let mut watchdog = IndependentWatchdog::new(watchdog);
        watchdog.stop_on_debug(debug, true);
        // Without it a probe cannot read the log while the core sleeps.
        debug.cr().modify(|_, w| w.dbg_sleep().set_bit());
        watchdog.start(START_MS.millis());
        Self { watchdog, led }
    }

    /// Changes to the short period. The registers take it over in some 0.2 ms of the slow clock
    /// (RM0090, IWDG_SR), so they must not have been written just before; between `new` and this
    /// lies the ADC's start, 0.13 s at least.
    pub fn expect_check_ins(&mut self) {
        self.watchdog.start(CHECK_IN_MS.millis());
    }

    /// Everybody is well.
    pub fn feed(&mut self) {
        self.watchdog.feed();
        self.led.toggle();
    }
}

/// Longest erase of a sector is 0.5 s; twice that by the slow oscillator at its fastest, in its
/// counts of 8 ms.
const LONG: u16 = 2_000 / 8;
const UNLOCK: u16 = 0x5555;
const RELOAD: u16 = 0xAAAA;
static SHORT: AtomicU16 = AtomicU16::new(0);

/// For an erase of the flash, during which nobody can check in. Of the priority of the health task,
/// or below: the two do not meet.
pub fn give_time() {
    SHORT.store(period(), Relaxed);
    set_period(LONG);
}

/// Everybody can check in again.
pub fn take_time_back() {
    set_period(SHORT.load(Relaxed));
}

/// Both registers are taken over by the slow clock, in five of its periods at the most, 0.3 ms;
/// meanwhile they are neither read nor written (RM0090, IWDG_SR).
fn settled() -> &'static stm32f4xx_hal::pac::iwdg::RegisterBlock {
    // SAFETY: the health task, which has the watchdog, does not run meanwhile.
    let watchdog = unsafe { &*IWDG::ptr() };
    while watchdog.sr().read().bits() != 0 {}
    watchdog
}

fn period() -> u16 {
    settled().rlr().read().rl().bits()
}

fn set_period(counts: u16) {
    let watchdog = settled();
    // SAFETY: keys as the reference manual has them.
    watchdog.kr().write(|w| unsafe { w.key().bits(UNLOCK) });
    watchdog.rlr().write(|w| w.rl().set(counts));
    // Taken over before the counter is loaded from it.
    // SAFETY: as above.
    settled().kr().write(|w| unsafe { w.key().bits(RELOAD) });
}
