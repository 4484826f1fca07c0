//! SysTick: counts core cycles down and raises its exception at zero (ARMv7-M, "System timer").

use crate::time::periods;

const ENABLE: u32 = 1;
const TICKINT: u32 = 1 << 1;
const COUNTFLAG: u32 = 1 << 16;

/// The timer, clocked by the core.
#[derive(Clone, Debug, Default)]
pub struct SysTick {
    control: u32,
    reload: u32,
    /// When the count was last loaded.
    loaded_at: u64,
}

impl SysTick {
    fn period(&self, core_hz: u64) -> u64 {
        periods(u64::from(self.reload) + 1, core_hz)
    }

    /// When it reaches zero next.
    pub fn next_event(&self, core_hz: u64) -> u64 {
        let runs = self.control & ENABLE != 0 && self.reload != 0 && core_hz != 0;
        if runs { self.loaded_at + self.period(core_hz) } else { u64::MAX }
    }

    /// Lets it reach zero if it is time; returns whether its exception waits then.
    pub fn settle(&mut self, now: u64, core_hz: u64) -> bool {
        let mut raised = false;
        while self.next_event(core_hz) <= now {
            self.loaded_at = self.next_event(core_hz);
            self.control |= COUNTFLAG;
            raised |= self.control & TICKINT != 0;
        }
        raised
    }

    /// Reads a register by its offset.
    pub fn load(&mut self, offset: u32, now: u64, core_hz: u64) -> u32 {
        match offset {
            0x0 => {
                let control = self.control;
                self.control &= !COUNTFLAG;
                control
            }
            0x4 => self.reload,
            0x8 if self.control & ENABLE != 0 && core_hz != 0 => {
                let gone = (now - self.loaded_at) / periods(1, core_hz).max(1);
                self.reload.saturating_sub(gone as u32)
            }
            _ => 0,
        }
    }

    /// Writes a register by its offset.
    pub const fn store(&mut self, offset: u32, value: u32, now: u64) {
        match offset {
            0x0 => {
                if value & ENABLE != 0 && self.control & ENABLE == 0 {
                    self.loaded_at = now;
                }
                self.control = value & 7 | self.control & COUNTFLAG;
            }
            0x4 => self.reload = value & 0x00ff_ffff,
            // Any write clears count and flag.
            0x8 => {
                self.loaded_at = now;
                self.control &= !COUNTFLAG;
            }
            _ => {}
        }
    }
}
