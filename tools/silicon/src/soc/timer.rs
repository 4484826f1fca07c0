//! TIM5 (RM0090, "General-purpose timers"): counts up over all its 32 bits, compares with channel
//! 1, and captures the slow oscillator on channel 4.
//!
//! Limits: no reload value and no update by overflow; edges of the slow oscillator begin where the
//! capture does.

use super::access::Access;
use crate::complaint::BrokenRule;
use crate::time::{CYCLES_PER_SECOND, periods};

const ENABLE: u32 = 1;
const COMPARED: u32 = 1 << 1;
const CAPTURED: u32 = 1 << 4;
const OVER_CAPTURED: u32 = 1 << 12;
const UPDATE: u32 = 1;
/// TIM5_ARR.
const RELOAD: u32 = 0x4000_0c2c;

/// The interrupt of TIM5.
pub const INTERRUPT: u16 = 50;

/// The timer.
#[derive(Clone, Copy, Debug)]
pub struct Timer {
    /// The slow oscillator, Hz; zero is one that stands still.
    pub slow_hz: u64,
    control: u32,
    interrupts: u32,
    status: u32,
    capture_mode: u32,
    channels: u32,
    remap: u32,
    /// Value as written, until an update takes it over.
    next_prescaler: u32,
    prescaler: u32,
    compare: u32,
    capture: u32,
    /// The count of a timer that stands; of one that runs, it follows from `zero_at`.
    count: u32,
    zero_at: u64,
    /// Equality is looked for from then on.
    compares_from: u64,
    next_edge: u64,
}

impl Timer {
    /// One that stands, beside this slow oscillator, Hz.
    pub const fn new(slow_hz: u64) -> Self {
        Self {
            slow_hz,
            control: 0,
            interrupts: 0,
            status: 0,
            capture_mode: 0,
            channels: 0,
            remap: 0,
            next_prescaler: 0,
            prescaler: 0,
            compare: 0,
            capture: 0,
            count: 0,
            zero_at: 0,
            compares_from: 0,
            next_edge: 0,
        }
    }

    /// Core cycles that so many counts take, and the counts in so many cycles.
    fn duration(&self, counts: u64, timer_hz: u64) -> u64 {
        let cycles = u128::from(counts) * u128::from(self.prescaler + 1) * u128::from(CYCLES_PER_SECOND);
        cycles.div_ceil(u128::from(timer_hz)) as u64
    }

    fn counts_at(&self, time: u64, timer_hz: u64) -> u64 {
        let passed = u128::from(time.saturating_sub(self.zero_at)) * u128::from(timer_hz);
        (passed / (u128::from(self.prescaler + 1) * u128::from(CYCLES_PER_SECOND))) as u64
    }

    /// When its count equals that of channel 1 next.
    pub fn next_event(&self, timer_hz: u64) -> u64 {
        if self.control & ENABLE == 0 || timer_hz == 0 || self.status & COMPARED != 0 {
            return u64::MAX;
        }
        let from = self.counts_at(self.compares_from, timer_hz);
        let left = self.compare.wrapping_sub(from as u32).wrapping_sub(1);
        self.zero_at + self.duration(from + u64::from(left) + 1, timer_hz)
    }

    /// Lets happen what is due.
    pub fn settle(&mut self, now: u64, timer_hz: u64) {
        if self.next_event(timer_hz) <= now {
            self.status |= COMPARED;
            self.compares_from = now;
        }
        // Input 4 unfiltered, its rising edges, from the slow oscillator.
        let captures = self.capture_mode & 0xf300 == 0x100 && self.channels >> 12 & 0xb == 1 && self.remap == 1 << 6;
        if !captures || self.slow_hz == 0 {
            self.next_edge = now;
            return;
        }
        while self.next_edge <= now {
            self.capture = self.count(self.next_edge, timer_hz);
            self.status |= CAPTURED | if self.status & CAPTURED == 0 { 0 } else { OVER_CAPTURED };
            self.next_edge += periods(1 << (self.capture_mode >> 10 & 3), self.slow_hz);
        }
    }

    /// Tells whether it holds its interrupt.
    pub const fn line(&self) -> bool {
        self.status & self.interrupts & COMPARED != 0
    }

    fn count(&self, time: u64, timer_hz: u64) -> u32 {
        if self.control & ENABLE == 0 { self.count } else { self.counts_at(time, timer_hz) as u32 }
    }

    /// Reads a register.
    pub fn load(&mut self, offset: u32, access: &Access<'_>) -> u32 {
        let timer_hz = access.clocks.timers1_hz;
        self.settle(access.now, timer_hz);
        match offset {
            0x00 => self.control,
            0x0c => self.interrupts,
            0x10 => self.status,
            0x1c => self.capture_mode,
            0x20 => self.channels,
            0x24 => self.count(access.now, timer_hz),
            0x28 => self.next_prescaler,
            0x2c => u32::MAX,
            0x34 => self.compare,
            0x40 => {
                self.status &= !CAPTURED;
                self.capture
            }
            0x50 => self.remap,
            _ => 0,
        }
    }

    /// Writes a register.
    pub fn store(&mut self, offset: u32, value: u32, access: &mut Access<'_>) {
        self.settle(access.now, access.clocks.timers1_hz);
        match offset {
            0x00 => {
                let count = self.count(access.now, access.clocks.timers1_hz);
                self.control = value;
                self.set_count(count, access);
            }
            0x0c => self.interrupts = value,
            0x10 => self.status &= value,
            // An update by software begins anew.
            0x14 if value & UPDATE != 0 => {
                self.prescaler = self.next_prescaler;
                self.set_count(0, access);
            }
            0x1c => self.capture_mode = value,
            0x20 => self.channels = value,
            0x24 => self.set_count(value, access),
            0x28 => self.next_prescaler = value & 0xffff,
            0x2c if value != u32::MAX => access.complain("TIM5_ARR", BrokenRule::Unmodelled(RELOAD)),
            0x34 => (self.compare, self.compares_from) = (value, access.now),
            0x50 => self.remap = value,
            _ => {}
        }
    }

    fn set_count(&mut self, count: u32, access: &Access<'_>) {
        self.count = count;
        let gone = self.duration(u64::from(count), access.clocks.timers1_hz.max(1));
        self.zero_at = access.now.saturating_sub(gone);
        self.compares_from = access.now;
    }
}
