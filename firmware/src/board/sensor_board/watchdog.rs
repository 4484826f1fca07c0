//! Independent watchdog: half a second without a check-in of every task resets the board.
//!
//! It runs on its own oscillator of 17 … 47 kHz, nominally 32 (data sheet), so half a second is
//! 0.34 … 0.95 s, and it cannot be stopped once it runs. A first, longer period covers the start,
//! in which nobody can check in yet. It goes on while a debugger holds the core, unless the probe
//! asks otherwise (RM0090, DBGMCU_APB1_FZ): a breakpoint ends as a reset, with the heaters low.
//!
//! The LED changes with every feeding, 20 times a second while all is well: a dark or steady one
//! means trouble, and its pin that stands still takes the platinum's supply away
//! (`docs/reference/board.md`).

use super::clocks::CycleDelay;
use core::sync::atomic::{AtomicU16, Ordering::Relaxed};
use embedded_hal::delay::DelayNs;
use stm32f4xx_hal::gpio::{Output, PB1};
use stm32f4xx_hal::pac::{DBGMCU, IWDG};

/// The slow oscillator over 256, nominally.
const COUNT_MS: u16 = 8;
/// For the start: the ADC takes 0.5 s, and the slow oscillator may be half as fast again as it
/// says.
const START: u16 = 4_000 / COUNT_MS;
/// From then on.
const CHECK_IN: u16 = 500 / COUNT_MS;
/// Longest erase of a sector is 0.5 s; twice that by the slow oscillator at its fastest.
const LONG: u16 = 2_000 / COUNT_MS;

/// Of the LED's pin; half of them have the supply up at -40 °C (`hardware/cut-off.cir`).
const FIRST_CHANGES: u32 = 8;

/// Of some ten cycles each: 3 ms at 168 MHz, ten times what the slowest oscillator takes.
const SETTLING_LOOPS: u32 = 50_000;

const ENABLE: u16 = 0xCCCC;
const UNLOCK: u16 = 0x5555;
const RELOAD: u16 = 0xAAAA;
static SHORT: AtomicU16 = AtomicU16::new(0);

/// Resets the board unless it is fed.
pub struct HardwareWatchdog {
    watchdog: IWDG,
    led: PB1<Output>,
}

impl HardwareWatchdog {
    /// Feeds the running watchdog, and has the platinum's supply up before the first reading.
    pub fn new(watchdog: IWDG, debug: &DBGMCU, mut led: PB1<Output>) -> Self {
        // Without it a probe cannot read the log while the core sleeps.
        debug.cr().modify(|_, w| w.dbg_sleep().set_bit());
        for _ in 0..FIRST_CHANGES {
            led.toggle();
            CycleDelay.delay_ms(1);
        }
        Self { watchdog, led }
    }

    /// Changes to the short period.
    pub fn expect_check_ins(&mut self) {
        set_period(CHECK_IN);
    }

    /// Everybody is well. While another period is taken over, whoever set it feeds next. The
    /// platinum keeps its supply unless it is `cut`.
    pub fn feed(&mut self, cut: bool) {
        if self.watchdog.sr().read().bits() == 0 {
            // SAFETY: the key as the reference manual has it.
            self.watchdog.kr().write(|w| unsafe { w.key().bits(RELOAD) });
        }
        if !cut {
            self.led.toggle();
        }
    }
}

/// Starts it with the long period, before anything that may hang or fault.
pub fn start(watchdog: &IWDG) {
    // First of all it is enabled: its oscillator runs from then on, and takes the registers over.
    // Until then it counts 0.5 s, the most of the smallest divider.
    // SAFETY: keys and divider as the reference manual has them; nobody else has it yet.
    watchdog.kr().write(|w| unsafe { w.key().bits(ENABLE) });
    watchdog.kr().write(|w| unsafe { w.key().bits(UNLOCK) });
    watchdog.pr().write(|w| w.pr().divide_by256());
    set_period(START);
}

/// For an erase of the flash, during which nobody can check in.
pub fn give_time() {
    SHORT.store(settled().rlr().read().rl().bits(), Relaxed);
    set_period(LONG);
}

/// Everybody can check in again.
pub fn take_time_back() {
    set_period(SHORT.load(Relaxed));
}

/// Both registers are taken over by the slow clock, in five of its periods at the most, 0.3 ms;
/// meanwhile they are neither read nor written (RM0090, IWDG_SR). A slow clock that stands still
/// holds nobody: the clocks' comparison trips.
fn settled() -> &'static stm32f4xx_hal::pac::iwdg::RegisterBlock {
    // SAFETY: but for the key, whose writes are single, only one task at a time uses its registers:
    // the start, then the settings'.
    let watchdog = unsafe { &*IWDG::ptr() };
    let mut timeout = SETTLING_LOOPS;
    while watchdog.sr().read().bits() != 0 && timeout > 0 {
        timeout -= 1;
    }
    watchdog
}

fn set_period(counts: u16) {
    let watchdog = settled();
    // A feeding in between would lock the register again.
    cortex_m::interrupt::free(|_| {
        // SAFETY: the key as the reference manual has it.
        watchdog.kr().write(|w| unsafe { w.key().bits(UNLOCK) });
        watchdog.rlr().write(|w| w.rl().set(counts));
    });
    // Taken over before the counter is loaded from it.
    // SAFETY: as above.
    settled().kr().write(|w| unsafe { w.key().bits(RELOAD) });
}
