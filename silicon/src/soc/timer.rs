//! TIM5, counting up to its reload value (RM0090, "General-purpose timers").
//!
//! Modelled: prescaler and reload taken over at once, update by overflow and by software, one-pulse
//! mode not. Limit: a prescaler written while the timer runs counts at once, not at the next
//! update.

use super::access::Access;
use crate::time::periods;

const ENABLE: u32 = 1;
const UPDATE_DISABLED: u32 = 1 << 1;
const UPDATE_BY_OVERFLOW_ONLY: u32 = 1 << 2;
const UPDATE: u32 = 1;

/// The interrupt of TIM5.
pub const INTERRUPT: u16 = 50;

/// The timer.
#[derive(Clone, Copy, Debug)]
pub struct Timer {
    control: u32,
    interrupts: u32,
    status: u32,
    prescaler: u32,
    reload: u32,
    /// The count of a timer that stands; of one that runs, it follows from `zero_at`.
    count: u32,
    zero_at: u64,
}

impl Default for Timer {
    fn default() -> Self {
        Self { control: 0, interrupts: 0, status: 0, prescaler: 0, reload: u32::MAX, count: 0, zero_at: 0 }
    }
}

impl Timer {
    fn duration(&self, counts: u64, timer_hz: u64) -> u64 {
        periods(counts * (u64::from(self.prescaler) + 1), timer_hz)
    }

    /// When it overflows next.
    pub fn next_event(&self, timer_hz: u64) -> u64 {
        if self.control & ENABLE == 0 || timer_hz == 0 {
            return u64::MAX;
        }
        self.zero_at + self.duration(u64::from(self.reload) + 1, timer_hz)
    }

    /// Lets it overflow if it is time.
    pub fn settle(&mut self, now: u64, timer_hz: u64) {
        while self.next_event(timer_hz) <= now {
            self.zero_at = self.next_event(timer_hz);
            if self.control & UPDATE_DISABLED == 0 {
                self.status |= UPDATE;
            }
        }
    }

    /// Whether it holds its interrupt.
    pub const fn line(&self) -> bool {
        self.status & self.interrupts & UPDATE != 0
    }

    fn count(&self, access: &Access<'_>) -> u32 {
        let timer_hz = access.clocks.timers1_hz;
        if self.control & ENABLE == 0 || timer_hz == 0 {
            return self.count;
        }
        ((access.now - self.zero_at) / self.duration(1, timer_hz).max(1)) as u32
    }

    /// Reads a register.
    pub fn load(&self, offset: u32, access: &Access<'_>) -> u32 {
        match offset {
            0x00 => self.control,
            0x0c => self.interrupts,
            0x10 => self.status,
            0x24 => self.count(access),
            0x28 => self.prescaler,
            0x2c => self.reload,
            _ => 0,
        }
    }

    /// Writes a register.
    pub fn store(&mut self, offset: u32, value: u32, access: &Access<'_>) {
        match offset {
            0x00 => {
                let (was_on, is_on) = (self.control & ENABLE != 0, value & ENABLE != 0);
                if was_on && !is_on {
                    self.count = self.count(access);
                }
                if !was_on && is_on {
                    self.set_count(self.count, access);
                }
                self.control = value;
            }
            0x0c => self.interrupts = value,
            0x10 => self.status &= value,
            // An update by software begins anew.
            0x14 if value & UPDATE != 0 => {
                self.set_count(0, access);
                if self.control & (UPDATE_DISABLED | UPDATE_BY_OVERFLOW_ONLY) == 0 {
                    self.status |= UPDATE;
                }
            }
            0x24 => self.set_count(value, access),
            0x28 => self.prescaler = value & 0xffff,
            0x2c => self.reload = value,
            _ => {}
        }
    }

    fn set_count(&mut self, count: u32, access: &Access<'_>) {
        self.count = count;
        let gone = self.duration(u64::from(count), access.clocks.timers1_hz.max(1));
        self.zero_at = access.now.saturating_sub(gone);
    }
}
