//! Proof test of the watchdog at every start by power-on or reset pin: it is left to reset the
//! processor once, before anything else is set up. The start takes 20 ms longer, most of it to
//! clear RAM once more.
//!
//! A word in RAM that survives the reset tells this one from a watchdog reset of the firmware, and
//! keeps why the processor really started. The host sees nothing of it: the board has not spoken
//! yet, and counts one start. All other starts go without it, so it cannot repeat itself: the reset
//! that it makes is none of the two, and if the word is lost, it is a watchdog reset like any
//! other, which trips.

use cortex_m::asm::delay;
use stm32f4xx_hal::pac::IWDG;
use wire::ResetCause;

const ENABLE: u16 = 0xCCCC;
const UNLOCK: u16 = 0x5555;
const RELOAD: u16 = 0xAAAA;
/// The slow oscillator over 4, nominally 8 kHz: 2 ms, 1.4 … 3.8 ms at 47 … 17 kHz.
const COUNTS: u16 = 15;
/// 20 ms of the oscillator on which the processor starts; five times what the watchdog may take.
const GIVEN_UP_CYCLES: u32 = 20 * 16_000;

const PROVING: [u32; 2] = [0x5EED_0D06, !0x5EED_0D06];
const AFTER_PIN: [u32; 2] = [0x5EED_0D07, !0x5EED_0D07];
/// The start does not clear this section of the RAM.
#[unsafe(link_section = ".uninit.WATCHDOG_PROOF")]
static mut MARK: core::mem::MaybeUninit<[u32; 2]> = core::mem::MaybeUninit::uninit();

/// Proves the watchdog if this start asks for it, by a reset. Returns why the processor really
/// started, and whether the watchdog has passed the last proof that was asked for.
pub fn prove(watchdog: &IWDG, reset: ResetCause) -> (ResetCause, bool) {
    let mark = (&raw mut MARK).cast::<[u32; 2]>();
    // SAFETY: any bits are words; only the start uses them, alone. Volatile, since the compiler
    // sees no write before.
    let of_before = unsafe { mark.read_volatile() };
    let set = |words| unsafe { mark.write_volatile(words) };
    let proving = match (reset, of_before) {
        (ResetCause::Watchdog, PROVING) => {
            set([0; 2]);
            return (ResetCause::PowerOn, true);
        }
        (ResetCause::Watchdog, AFTER_PIN) => {
            set([0; 2]);
            return (ResetCause::Pin, true);
        }
        (ResetCause::PowerOn, _) => PROVING,
        (ResetCause::Pin, _) => AFTER_PIN,
        _ => {
            set([0; 2]);
            return (reset, true);
        }
    };
    set(proving);
    // SAFETY: keys as the reference manual has them.
    let key = |key| watchdog.kr().write(|w| unsafe { w.key().bits(key) });
    // Its oscillator runs from then on, and takes the register over.
    key(ENABLE);
    key(UNLOCK);
    watchdog.rlr().write(|w| w.rl().set(COUNTS));
    let mut timeout = GIVEN_UP_CYCLES / 16;
    while watchdog.sr().read().bits() != 0 && timeout > 0 {
        timeout -= 1;
    }
    key(RELOAD);
    delay(GIVEN_UP_CYCLES);
    set([0; 2]);
    (reset, false)
}
