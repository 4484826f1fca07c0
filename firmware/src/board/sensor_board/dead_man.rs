//! The dead-man timer of the sensor board: timer 5 lowers the heaters unless their levels are
//! decided anew ([`firmware::dead_man`]).
//!
//! It counts microseconds without end, and raises its interrupt when the count equals that of
//! channel 1, above all tasks, the control task included; nothing that a task can do short of
//! disabling interrupts keeps it from the pins, and the watchdog sees to that.

use super::has_arrived;
use firmware::dead_man::timeout_us;
use stm32f4xx_hal::pac::TIM5;
use stm32f4xx_hal::pac::tim5::RegisterBlock;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

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
pub fn expire_in(timer: &RegisterBlock, us: u32) {
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

/// Takes the interrupt back and stands still, for the task that it raises.
pub fn acknowledge_dead_man() {
    // SAFETY: the control task, which has the timer, is of lower priority and does not run
    // meanwhile. If it was just starting or stopping the timer, it goes on with that afterwards,
    // and the levels that it then sets have just been decided.
    never_expire(unsafe { &*TIM5::ptr() });
    has_arrived();
}
