//! The supply and what supervises it: voltage detector, brown-out reset, power-down reset (RM0090,
//! "PWR"). Levels are typical ones of the data sheet.
//!
//! Limit: RAM keeps its content down to a level that no manual states. Below it a share of its bytes
//! is lost, which a scenario sets: on a board it depends on time, temperature and capacitors.

use super::rcc::ResetSource;

/// The board's supply, mV.
pub const NOMINAL_MV: u32 = 3_300;
/// Below it the flash is not programmed by words.
pub const PROGRAMMING_MV: u32 = 2_700;
/// Detector, by PLS, falling.
const DETECTOR_MV: [u32; 8] = [2_040, 2_190, 2_350, 2_510, 2_660, 2_840, 2_930, 3_030];
/// Brown-out, by BOR_LEV, falling: 00 is level 3, 11 leaves the power-down reset alone.
const BROWN_OUT_MV: [u32; 4] = [2_830, 2_500, 2_190, POWER_DOWN_MV];
/// Hysteresis of detector and brown-out reset.
const HYSTERESIS_MV: u32 = 100;
const POWER_DOWN_MV: u32 = 1_680;
const RAM_KEEPS_MV: u32 = 800;

const DETECTOR_ENABLE: u32 = 1 << 4;
/// VOS, which 168 MHz need; all of PWR_CR after a reset (RM0090, "PWR_CR" of STM32F405).
const SCALE_1: u32 = 1 << 14;
const DETECTOR_OUTPUT: u32 = 1 << 2;

/// Supply and supervisors.
#[derive(Clone, Copy, Debug)]
pub struct Power {
    control: u32,
    supply_mv: u32,
    /// BOR_LEV, as loaded by the last reset.
    level: u32,
    is_low: bool,
    holds_reset: bool,
    /// Bytes of RAM that a gap of the supply costs, %.
    pub ram_lost_percent: u32,
}

impl Power {
    /// A supply that is there, with these option bytes.
    pub const fn new(options: u32) -> Self {
        let (supply_mv, level) = (NOMINAL_MV, options >> 2 & 3);
        Self { control: SCALE_1, supply_mv, level, is_low: false, holds_reset: false, ram_lost_percent: 100 }
    }

    /// After a reset, which loads the option bytes.
    pub const fn reset(self, options: u32) -> Self {
        let Self { supply_mv, holds_reset, ram_lost_percent, .. } = self;
        Self { supply_mv, holds_reset, ram_lost_percent, ..Self::new(options) }
    }

    /// The supply, mV.
    pub const fn supply_mv(&self) -> u32 {
        self.supply_mv
    }

    /// Tells whether the processor is held in reset.
    pub const fn holds_reset(&self) -> bool {
        self.holds_reset
    }

    /// Tells whether RAM keeps its content in a reset that the supply causes now.
    pub const fn keeps_ram(&self) -> bool {
        self.holds_reset && self.supply_mv >= RAM_KEEPS_MV
    }

    /// The detector's output.
    pub const fn is_low(&self) -> bool {
        self.is_low
    }

    /// The supply changes. Returns the reset that this is.
    pub fn set_supply(&mut self, supply_mv: u32) -> Option<ResetSource> {
        let was_below = self.supply_mv < POWER_DOWN_MV;
        self.supply_mv = supply_mv;
        self.detect();
        let falls_at = BROWN_OUT_MV[self.level as usize];
        if self.holds_reset && supply_mv >= falls_at + HYSTERESIS_MV {
            self.holds_reset = false;
        }
        if supply_mv < POWER_DOWN_MV && !was_below {
            self.holds_reset = true;
            return Some(ResetSource::PowerOn);
        }
        if supply_mv < falls_at && !self.holds_reset {
            self.holds_reset = true;
            return Some(ResetSource::BrownOut);
        }
        None
    }

    fn detect(&mut self) {
        let level = DETECTOR_MV[(self.control >> 5 & 7) as usize];
        let level = if self.is_low { level + HYSTERESIS_MV } else { level };
        self.is_low = self.control & DETECTOR_ENABLE != 0 && self.supply_mv < level;
    }

    /// The fastest clock of the core at the regulator's scale.
    pub const fn fastest_hz(&self) -> u64 {
        if self.control & SCALE_1 == 0 { 144_000_000 } else { 168_000_000 }
    }

    /// Wait states that a clock needs at this supply (RM0090, table "Number of wait states
    /// according to CPU clock frequency").
    pub const fn wait_states(&self, core_hz: u64) -> u32 {
        let each_hz = match self.supply_mv {
            PROGRAMMING_MV.. => 30_000_000,
            2_400.. => 24_000_000,
            2_100.. => 22_000_000,
            _ => 20_000_000,
        };
        (core_hz.div_ceil(each_hz) as u32).saturating_sub(1)
    }

    /// Reads a register.
    pub const fn load(&self, offset: u32) -> u32 {
        match offset {
            0x00 => self.control,
            0x04 if self.is_low => DETECTOR_OUTPUT,
            _ => 0,
        }
    }

    /// Writes a register.
    pub fn store(&mut self, offset: u32, value: u32) {
        if offset == 0x00 {
            self.control = value;
            self.detect();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::soc::flash::{FACTORY_OPTIONS, OPTIONS};

    #[test]
    fn a_falling_supply_meets_detector_brown_out_and_power_down_in_this_order() {
        let mut power = Power::new(OPTIONS);
        assert_eq!(power.load(0), 0x4000);
        power.store(0, SCALE_1 | DETECTOR_ENABLE | 7 << 5);
        assert_eq!((power.set_supply(3_000), power.is_low()), (None, true));
        // The hysteresis of the detector.
        assert_eq!((power.set_supply(3_100), power.is_low()), (None, true));
        assert_eq!((power.set_supply(3_140), power.is_low()), (None, false));
        assert_eq!((power.set_supply(2_800), power.holds_reset()), (Some(ResetSource::BrownOut), true));
        assert_eq!((power.set_supply(2_900), power.holds_reset()), (None, true));
        assert_eq!((power.set_supply(1_500), power.keeps_ram()), (Some(ResetSource::PowerOn), true));
        assert_eq!((power.set_supply(0), power.keeps_ram()), (None, false));
        assert_eq!((power.set_supply(NOMINAL_MV), power.holds_reset()), (None, false));
    }

    #[test]
    fn by_factory_only_the_power_down_resets() {
        let mut power = Power::new(FACTORY_OPTIONS);
        assert_eq!(power.set_supply(1_800), None);
        assert_eq!((power.wait_states(168_000_000), power.is_low()), (8, false));
        assert_eq!(power.set_supply(1_600), Some(ResetSource::PowerOn));
    }
}
