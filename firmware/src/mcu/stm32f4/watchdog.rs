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
//!
//! **Proof test** ([`prove`]) at every start by power-on or reset pin: it is left to reset the
//! processor once, before anything else is set up. The start takes 20 ms longer, most of it to
//! clear RAM once more. A word in RAM that survives the reset tells this one from a watchdog reset
//! of the firmware, and keeps why the processor really started. The host sees nothing of it: the
//! board has not spoken yet, and counts one start. All other starts go without it, so it cannot
//! repeat itself: the reset that it makes is none of the two, and if the word is lost, it is a
//! watchdog reset like any other, which trips.

use super::clocks::CycleDelay;
use core::sync::atomic::{AtomicU16, Ordering::Relaxed};
use cortex_m::asm::delay;
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::StatefulOutputPin;
use stm32f4xx_hal::pac::{DBGMCU, IWDG, iwdg::RegisterBlock};
use wire::ResetCause;

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

/// Of the proof: the slow oscillator over 4, nominally 8 kHz: 2 ms, 1.4 … 3.8 ms at 47 … 17 kHz.
const PROOF_COUNTS: u16 = 15;
/// 20 ms of the oscillator on which the processor starts; five times what the watchdog may take.
const GIVEN_UP_CYCLES: u32 = 20 * 16_000;

const ENABLE: u16 = 0xCCCC;
const UNLOCK: u16 = 0x5555;
const RELOAD: u16 = 0xAAAA;
static SHORT: AtomicU16 = AtomicU16::new(0);

const PROVING: [u32; 2] = [0x5EED_0D06, !0x5EED_0D06];
const AFTER_PIN: [u32; 2] = [0x5EED_0D07, !0x5EED_0D07];
/// The start does not clear this section of the RAM.
#[unsafe(link_section = ".uninit.WATCHDOG_PROOF")]
static mut MARK: core::mem::MaybeUninit<[u32; 2]> = core::mem::MaybeUninit::uninit();

/// Resets the board unless it is fed.
pub struct Watchdog<L> {
    led: L,
}

impl<L: StatefulOutputPin> Watchdog<L> {
    /// Feeds the running watchdog, and has the platinum's supply up before the first reading.
    pub fn new(debug: &DBGMCU, mut led: L) -> Self {
        // Without it a probe cannot read the log while the core sleeps.
        debug.cr().modify(|_, w| w.dbg_sleep().set_bit());
        for _ in 0..FIRST_CHANGES {
            led.toggle().ok();
            CycleDelay.delay_ms(1);
        }
        Self { led }
    }

    /// Changes to the short period.
    pub fn expect_check_ins(&mut self) {
        set_period(CHECK_IN);
    }

    /// Everybody is well. While another period is taken over, whoever set it feeds next. The
    /// platinum keeps its supply unless it is `cut`.
    pub fn feed(&mut self, cut: bool) {
        if registers().sr().read().bits() == 0 {
            key(RELOAD);
        }
        if !cut {
            self.led.toggle().ok();
        }
    }
}

/// Starts it with the long period, before anything that may hang or fault.
pub fn start() {
    // First of all it is enabled: its oscillator runs from then on, and takes the registers over.
    // Until then it counts 0.5 s, the most of the smallest divider.
    key(ENABLE);
    key(UNLOCK);
    registers().pr().write(|w| w.pr().divide_by256());
    set_period(START);
}

/// For an erase of the flash, during which nobody can check in.
pub fn give_time() {
    SHORT.store(settled(SETTLING_LOOPS).rlr().read().rl().bits(), Relaxed);
    set_period(LONG);
}

/// Everybody can check in again.
pub fn take_time_back() {
    set_period(SHORT.load(Relaxed));
}

fn registers() -> &'static RegisterBlock {
    // SAFETY: but for the key, whose writes are single, only one task at a time uses them: the
    // start, then the settings'.
    unsafe { &*IWDG::ptr() }
}

fn key(key: u16) {
    // SAFETY: keys as the reference manual has them.
    registers().kr().write(|w| unsafe { w.key().bits(key) });
}

/// Both registers are taken over by the slow clock, in five of its periods at the most, 0.3 ms;
/// meanwhile they are neither read nor written (RM0090, IWDG_SR). A slow clock that stands still
/// holds nobody: the clocks' comparison trips.
fn settled(mut timeout: u32) -> &'static RegisterBlock {
    let watchdog = registers();
    while watchdog.sr().read().bits() != 0 && timeout > 0 {
        timeout -= 1;
    }
    watchdog
}

fn set_period(counts: u16) {
    let watchdog = settled(SETTLING_LOOPS);
    // A feeding in between would lock the register again.
    cortex_m::interrupt::free(|_| {
        key(UNLOCK);
        watchdog.rlr().write(|w| w.rl().set(counts));
    });
    // Taken over before the counter is loaded from it.
    settled(SETTLING_LOOPS);
    key(RELOAD);
}

/// Proves the watchdog if this start asks for it, by a reset. Returns why the processor really
/// started, and whether the watchdog has passed the last proof that was asked for.
pub fn prove(reset: ResetCause) -> (ResetCause, bool) {
    let mark = (&raw mut MARK).cast::<[u32; 2]>();
    // SAFETY: any bits are words; only the start uses them, alone. Volatile, since the compiler
    // sees no write before.
    let of_before = unsafe { mark.read_volatile() };
    let set = |words| unsafe { mark.write_volatile(words) };
    set([0; 2]);
    match (reset, of_before) {
        (ResetCause::Watchdog, PROVING) => return (ResetCause::PowerOn, true),
        (ResetCause::Watchdog, AFTER_PIN) => return (ResetCause::Pin, true),
        (ResetCause::PowerOn, _) => set(PROVING),
        (ResetCause::Pin, _) => set(AFTER_PIN),
        _ => return (reset, true),
    }
    // Its oscillator runs from then on, and takes the register over.
    key(ENABLE);
    key(UNLOCK);
    registers().rlr().write(|w| w.rl().set(PROOF_COUNTS));
    settled(GIVEN_UP_CYCLES / 16);
    key(RELOAD);
    delay(GIVEN_UP_CYCLES);
    set([0; 2]);
    (reset, false)
}
