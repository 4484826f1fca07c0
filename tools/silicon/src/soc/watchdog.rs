//! The independent watchdog (RM0090, "IWDG"), on its own slow oscillator of 17 to 47 kHz.
//!
//! PR and RLR are taken over by the slow clock within five of its periods; PVU and RVU say that
//! this goes on. A reload meanwhile loads the old value, and so does a start; the prescaler counts
//! as soon as it is taken over, which is at once here.

use super::access::Access;
use crate::complaint::BrokenRule;
use crate::time::periods;

const UNLOCK: u32 = 0x5555;
const RELOAD: u32 = 0xaaaa;
const START: u32 = 0xcccc;

/// The watchdog.
#[derive(Clone, Copy, Debug)]
pub struct IndependentWatchdogModel {
    /// Frequency of its oscillator, Hz: 32 000 nominally.
    pub oscillator_hz: u64,
    prescaler: u32,
    reload: u32,
    /// The reload value that the slow clock has taken over.
    effective: u32,
    prescaler_until: u64,
    reload_until: u64,
    is_open: bool,
    is_on: bool,
    /// It never resets anything.
    pub is_dead: bool,
    ends_at: u64,
    /// Reloads so far.
    pub reloads: u64,
    /// The shortest time that was ever left at a reload.
    pub least_left: u64,
}

impl IndependentWatchdogModel {
    /// A watchdog that is off.
    pub const fn new(oscillator_hz: u64) -> Self {
        Self {
            oscillator_hz,
            prescaler: 0,
            reload: 0xfff,
            effective: 0xfff,
            prescaler_until: 0,
            reload_until: 0,
            is_open: false,
            is_on: false,
            is_dead: false,
            ends_at: 0,
            reloads: 0,
            least_left: u64::MAX,
        }
    }

    /// Tells whether its registers may be written.
    pub const fn is_unlocked(&self) -> bool {
        self.is_open
    }

    /// When it resets the processor.
    pub const fn ends_at(&self) -> u64 {
        if self.is_on && !self.is_dead { self.ends_at } else { u64::MAX }
    }

    /// The period that counts now, in core cycles.
    pub fn period(&self) -> u64 {
        periods((u64::from(self.effective) + 1) * (4 << self.prescaler.min(6)), self.oscillator_hz)
    }

    const fn take_over(&mut self, now: u64) {
        if now >= self.reload_until {
            self.effective = self.reload;
        }
    }

    fn restart(&mut self, now: u64) {
        self.take_over(now);
        self.ends_at = now + self.period();
    }

    /// It has stood still for a time.
    pub const fn postpone(&mut self, time: u64) {
        self.ends_at += time;
    }

    /// Writes the key that reloads the counter, and locks the registers.
    pub fn feed(&mut self, access: &mut Access<'_>) {
        self.store(0x0, RELOAD, access);
    }

    /// Reads a register.
    pub fn load(&self, offset: u32, access: &Access<'_>) -> u32 {
        match offset {
            0x4 => self.prescaler,
            0x8 => self.reload,
            0xc => u32::from(access.now < self.prescaler_until) | u32::from(access.now < self.reload_until) << 1,
            _ => 0,
        }
    }

    /// Writes a register.
    pub fn store(&mut self, offset: u32, value: u32, access: &mut Access<'_>) {
        self.take_over(access.now);
        match (offset, value & 0xffff) {
            (0x0, UNLOCK) => self.is_open = true,
            (0x0, RELOAD) => {
                self.is_open = false;
                if self.is_on {
                    if access.now < self.reload_until || access.now < self.prescaler_until {
                        access.complain("IWDG_KR", BrokenRule::WatchdogReloadedEarly);
                    }
                    self.reloads += 1;
                    self.least_left = self.least_left.min(self.ends_at.saturating_sub(access.now));
                    self.restart(access.now);
                }
            }
            (0x0, START) => {
                self.is_open = false;
                if !self.is_on {
                    self.is_on = true;
                    self.restart(access.now);
                }
            }
            (0x0, _) => self.is_open = false,
            (0x4, prescaler) if self.may_change(self.prescaler_until, "IWDG_PR", access) => {
                self.prescaler = prescaler & 7;
                self.prescaler_until = access.now + periods(5, self.oscillator_hz);
            }
            (0x8, reload) if self.may_change(self.reload_until, "IWDG_RLR", access) => {
                self.reload = reload & 0xfff;
                self.reload_until = access.now + periods(5, self.oscillator_hz);
            }
            _ => {}
        }
    }

    fn may_change(&self, until: u64, register: &'static str, access: &mut Access<'_>) -> bool {
        if !self.is_open {
            access.complain(register, BrokenRule::WatchdogProtected);
        } else if access.now < until {
            access.complain(register, BrokenRule::WatchdogUpdating);
        }
        self.is_open
    }
}
