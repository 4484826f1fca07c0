//! Proof test of the dead-man timer, at every start and with every self-test, without a heater that
//! is high.
//!
//! The six pins become inputs, which the board pulls down, and their output bits are set: a level
//! that would be high if a pin drove it. The timer is started for 0.1 ms. Its interrupt has to come
//! in time, above the tasks that are held back meanwhile, and its handler has to clear all six bits
//! by the very store that it makes in an emergency. Only then are the pins outputs again.
//!
//! Shown: the timer counts at its rate, raises its vector, goes before the control task, and its
//! store reaches the port. Not shown: that a pin drives what its output bit says.

use super::clocks::{CYCLES_PER_US, cycles};
use super::dead_man::expire_in;
use super::front_end::HEATER_MASK;
use core::ops::RangeInclusive;
use stm32f4xx_hal::pac::{GPIOC, TIM5};

const PERIOD_US: u32 = 100;
/// What the timer may take: start and handler are some 100 cycles.
const IN_TIME: RangeInclusive<u32> = 98 * CYCLES_PER_US..=105 * CYCLES_PER_US;
const GIVEN_UP: u32 = 2 * PERIOD_US * CYCLES_PER_US;
/// Two bits a pin; zero is an input.
const MODES: u32 = (1 << (2 * HEATER_MASK.count_ones())) - 1;

/// Whether the timer works; none while a heater is high. Takes 0.1 ms, 0.2 if it does not. To be
/// called with the dead-man timer's interrupt open and the control task held back.
pub fn prove_dead_man() -> Option<bool> {
    // SAFETY: the control task, which has both, is held back, and with all heaters low it does not
    // need the timer.
    let (port, timer) = unsafe { (&*GPIOC::ptr(), &*TIM5::ptr()) };
    let is_any_set = || port.odr().read().bits() & HEATER_MASK != 0;
    if is_any_set() {
        return None;
    }
    let modes = port.moder().read().bits();
    // SAFETY: inputs, and output bits of the heaters' pins alone.
    unsafe {
        port.moder().write(|w| w.bits(modes & !MODES));
        port.bsrr().write(|w| w.bits(HEATER_MASK));
    }
    let were_set = port.odr().read().bits() & HEATER_MASK == HEATER_MASK;
    let started = cycles();
    expire_in(timer, PERIOD_US);
    let mut took = 0;
    while is_any_set() && took < GIVEN_UP {
        took = cycles().wrapping_sub(started);
    }
    timer.dier().write(|w| w.cc1ie().clear_bit());
    let has_lowered = !is_any_set();
    // SAFETY: all output bits low, then pins as they were.
    unsafe {
        port.bsrr().write(|w| w.bits(HEATER_MASK << 16));
        port.moder().write(|w| w.bits(modes));
    }
    Some(were_set && has_lowered && IN_TIME.contains(&took))
}
