//! The dead-man timer: timer 5 lowers the heaters unless their levels are decided anew
//! ([`firmware::dead_man`]).
//!
//! It counts microseconds without end, and raises its interrupt when the count equals that of
//! channel 1, above all tasks, the control task included; nothing that a task can do short of
//! disabling interrupts keeps it from the pins, and the watchdog sees to that.
//!
//! **Proof test of the timer** ([`prove`]), at every start and with every self-test, without a
//! heater that is high. The heaters' pins become inputs, which the board pulls down, and their
//! output bits are set: a level that would be high if a pin drove it. The timer is started for 0.1
//! ms. Its interrupt has to come in time, above the tasks that are held back meanwhile, and its
//! handler has to clear all bits by the very store that it makes in an emergency. Only then are the
//! pins outputs again. Shown: the timer counts at its rate, raises its vector, goes before the
//! control task, and its store reaches the port. Not shown: that a pin drives what its output bit
//! says.
//!
//! **Proof test of crystal and slow oscillator against each other** ([`is_clock_right`]), in the
//! background. The timer counts microseconds of the crystal, and captures every eighth edge of the
//! slow oscillator (RM0090, "TIM5 option register"): 8/47 kHz … 8/17 kHz by the data sheet, 170 …
//! 471 µs. The watchdog runs on the slow oscillator, all else on the crystal; so it is found that
//! one stands still or is far off. What lies within the oscillator's own spread, a factor of 2.8,
//! is not.

use super::clocks::{CYCLES_PER_US, cycles};
use super::{has_arrived, port};
use core::ops::RangeInclusive;
use firmware::dead_man::timeout_us;
use stm32f4xx_hal::pac::TIM5;
use stm32f4xx_hal::pac::tim5::RegisterBlock;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

const PROOF_US: u32 = 100;
/// What the timer may take: start and handler are some 100 cycles.
const IN_TIME: RangeInclusive<u32> = 98 * CYCLES_PER_US..=105 * CYCLES_PER_US;
const PROOF_GIVEN_UP: u32 = 2 * PROOF_US * CYCLES_PER_US;

/// Eight periods of 17 to 47 kHz, and a count of rounding.
const EIGHT_PERIODS_US: RangeInclusive<u32> = 169..=472;
const CAPTURE_GIVEN_UP_US: u32 = 1_000;
/// Rounds of 20 cycles and more, over 2 ms: for a timer that does not count at all.
const CAPTURE_GIVEN_UP_ROUNDS: u32 = 20_000;
/// TI4_RMP: the slow oscillator is on input 4.
const SLOW_OSCILLATOR: u8 = 1;
/// IC4PSC: every eighth edge.
const EIGHTH: u8 = 3;

/// The control task's end of it.
pub struct DeadManTimer {
    timer: TIM5,
    timeout_us: u32,
}

impl DeadManTimer {
    /// At rest, for ticks of this length.
    pub fn new(timer: TIM5, tick_us: u32, rcc: &mut Rcc) -> Self {
        TIM5::enable(rcc);
        TIM5::reset(rcc);
        timer.psc().write(|w| w.psc().set((rcc.clocks.timclk1().to_MHz() - 1) as u16));
        // Takes the prescaler over.
        timer.egr().write(|w| w.ug().set_bit());
        timer.cr1().write(|w| w.cen().set_bit());
        Self { timer, timeout_us: timeout_us(tick_us) }
    }

    /// Ticks have another length from now on.
    pub const fn set_tick(&mut self, tick_us: u32) {
        self.timeout_us = timeout_us(tick_us);
    }

    /// Levels have been decided: a high one restarts the timer, otherwise it stops.
    pub fn decided(&mut self, any_high: bool) {
        if any_high {
            expire_in(&self.timer, self.timeout_us);
        } else {
            never_expire(&self.timer);
        }
    }
}

/// Starts the timer anew.
fn expire_in(timer: &RegisterBlock, us: u32) {
    let now = timer.cnt().read().bits();
    // SAFETY: any count will do.
    timer.ccr1().write(|w| unsafe { w.bits(now.wrapping_add(us)) });
    // Ones leave the other flags alone; reserved bits stay zero.
    timer.sr().write(|w| w.cc1if().clear());
    timer.dier().write(|w| w.cc1ie().set_bit());
}

fn never_expire(timer: &RegisterBlock) {
    timer.dier().write(|w| w.cc1ie().clear_bit());
}

/// The timer, for those that do not own it. The handler of its interrupt stands above the control
/// task, which does: if that was just starting or stopping the timer, it goes on with that
/// afterwards, and the levels that it then sets have just been decided. The proof test holds the
/// control task back, and channel 4 is the clock's check alone.
fn timer() -> &'static RegisterBlock {
    // SAFETY: as said.
    unsafe { &*TIM5::ptr() }
}

/// Takes the interrupt back and stands still, for the task that it raises.
pub fn acknowledge() {
    never_expire(timer());
    has_arrived();
}

/// Whether the timer works, shown on the heaters' pins of a port, those of `mask` from 0 on; none
/// while one is high. Takes 0.1 ms, 0.2 if it does not. To be called with the dead-man timer's
/// interrupt open and the control task held back.
pub fn prove<const PORT: char>(mask: u32) -> Option<bool> {
    let (port, timer) = (port::registers::<PORT>(), timer());
    // Two bits a pin; zero is an input.
    let modes_mask = (1 << (2 * mask.count_ones())) - 1;
    let is_any_set = || port.odr().read().bits() & mask != 0;
    if is_any_set() {
        return None;
    }
    let modes = port.moder().read().bits();
    // SAFETY: inputs, with output bits of the heaters' pins alone. The control task, which has
    // them, is held back.
    port.moder().write(|w| unsafe { w.bits(modes & !modes_mask) });
    port::write::<PORT>(mask);
    let were_set = port.odr().read().bits() & mask == mask;
    let started = cycles();
    expire_in(timer, PROOF_US);
    let mut took = 0;
    while is_any_set() && took < PROOF_GIVEN_UP {
        took = cycles().wrapping_sub(started);
    }
    never_expire(timer);
    let has_lowered = !is_any_set();
    port::write::<PORT>(mask << 16);
    // SAFETY: all output bits are low, and the pins are as they were.
    port.moder().write(|w| unsafe { w.bits(modes) });
    Some(were_set && has_lowered && IN_TIME.contains(&took))
}

/// Lets the timer capture, beside its own work.
pub fn start_captures() {
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
    for _ in 0..CAPTURE_GIVEN_UP_ROUNDS {
        let waited = timer.cnt().read().bits().wrapping_sub(started);
        // In this order: a task may come in between.
        if timer.sr().read().cc4if().bit_is_set() {
            return Some(timer.ccr4().read().bits());
        }
        if waited > CAPTURE_GIVEN_UP_US {
            break;
        }
    }
    None
}
