//! Proof test of the crystal and the slow oscillator against each other, in the background.
//!
//! The dead-man timer counts microseconds of the crystal, and captures every eighth edge of the
//! slow oscillator (RM0090, "TIM5 option register"): 8/47 kHz … 8/17 kHz by the data sheet, 170 …
//! 471 µs. The watchdog runs on the slow oscillator, all else on the crystal; so it is found that
//! one stands still or is far off. What lies within the oscillator's own spread, a factor of 2.8,
//! is not.

use core::ops::RangeInclusive;
use stm32f4xx_hal::pac::TIM5;
use stm32f4xx_hal::pac::tim5::RegisterBlock;

/// 17 to 47 kHz, and a count of rounding.
const EIGHT_PERIODS_US: RangeInclusive<u32> = 169..=472;
const GIVEN_UP_US: u32 = 1_000;
/// Rounds of 20 cycles and more, over 2 ms: for a timer that does not count at all.
const GIVEN_UP_ROUNDS: u32 = 20_000;
/// TI4_RMP: the slow oscillator is on input 4.
const SLOW_OSCILLATOR: u8 = 1;
/// IC4PSC: every eighth edge.
const EIGHTH: u8 = 3;

/// Lets the timer capture, beside its own work.
pub fn start() {
    let timer = timer();
    // SAFETY: a value that the reference manual has; the other channels are not in use.
    timer.or().write(|w| unsafe { w.it4_rmp().bits(SLOW_OSCILLATOR) });
    timer.ccmr2_input().write(|w| w.cc4s().ti4().ic4psc().set(EIGHTH));
    timer.ccer().write(|w| w.cc4e().set_bit());
}

/// Whether both oscillators run, at frequencies that go together. Waits for two captures, 0.5 ms,
/// or 2 ms for none. If tasks take so long meanwhile that one is missed, the next check decides.
pub fn is_clock_right() -> bool {
    let timer = timer();
    timer.sr().write(|w| w.cc4if().clear().cc4of().clear());
    let (Some(first), Some(second)) = (next_capture(timer), next_capture(timer)) else { return false };
    let has_missed_one = timer.sr().read().cc4of().bit_is_set();
    has_missed_one || EIGHT_PERIODS_US.contains(&second.wrapping_sub(first))
}

fn next_capture(timer: &RegisterBlock) -> Option<u32> {
    let started = timer.cnt().read().bits();
    for _ in 0..GIVEN_UP_ROUNDS {
        let waited = timer.cnt().read().bits().wrapping_sub(started);
        // In this order: a task may come in between.
        if timer.sr().read().cc4if().bit_is_set() {
            return Some(timer.ccr4().read().bits());
        }
        if waited > GIVEN_UP_US {
            break;
        }
    }
    None
}

fn timer() -> &'static RegisterBlock {
    // SAFETY: nobody else uses its channel 4.
    unsafe { &*TIM5::ptr() }
}
