//! The dead-man timer of the sensor board: timer 5 lowers the heaters unless their levels are
//! decided anew ([`firmware::dead_man`]).
//!
//! It counts microseconds by itself and raises its interrupt above all tasks, the control task
//! included; nothing that a task can do short of disabling interrupts keeps it from the pins, and
//! the watchdog sees to that.

use firmware::dead_man::timeout_us;
use stm32f4xx_hal::pac::TIM5;
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Rcc;
use stm32f4xx_hal::timer::{CounterUs, Event};

/// The control task's end of it.
pub struct DeadManTimer {
    timer: CounterUs<TIM5>,
    timeout_us: u32,
}

impl DeadManTimer {
    /// At rest, for ticks of this length.
    pub fn new(timer: TIM5, tick_us: u32, rcc: &mut Rcc) -> Self {
        let mut timer = timer.counter_us(rcc);
        timer.listen(Event::Update);
        Self { timer, timeout_us: timeout_us(tick_us) }
    }

    /// Ticks have another length from now on.
    pub const fn set_tick(&mut self, tick_us: u32) {
        self.timeout_us = timeout_us(tick_us);
    }

    /// Levels have been decided: a high one restarts the timer, otherwise it stops.
    pub fn decided(&mut self, any_high: bool) {
        // It is running already, or stands already: both are what is wanted here.
        if any_high {
            self.timer.start(self.timeout_us.micros()).ok();
        } else {
            self.timer.cancel().ok();
        }
    }
}

/// Takes the interrupt back and stands still, for the task that it raises.
pub fn acknowledge_dead_man() {
    // SAFETY: the control task, which has the timer, is of lower priority and does not run
    // meanwhile. If it was just starting or stopping the timer, it goes on with that afterwards,
    // and the levels that it then sets have just been decided.
    let timer = unsafe { &*TIM5::ptr() };
    timer.cr1().modify(|_, w| w.cen().clear_bit());
    timer.sr().modify(|_, w| w.uif().clear_bit());
}
