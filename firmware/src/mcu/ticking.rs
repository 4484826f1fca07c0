//! SysTick, which raises the health task.

use cortex_m::peripheral::{SYST, syst::SystClkSource};

/// Beats of the health task a second. SysTick's 24 bits allow no less than 10 at 168 MHz.
pub const BEATS_PER_SECOND: u32 = 20;

/// Lets SysTick raise the health task, on a core of this clock.
pub fn start(syst: &mut SYST, clock_hz: u32) {
    syst.set_clock_source(SystClkSource::Core);
    syst.set_reload(clock_hz / BEATS_PER_SECOND - 1);
    syst.clear_current();
    syst.enable_counter();
    syst.enable_interrupt();
}
