//! When conversions come, and what the filter makes of a step.
//!
//! The third-order sinc looks back over three conversion periods. Of a voltage that was constant
//! within each of them, with the means v₀ of the last, v₁ and v₂ of those before,
//!
//! ```text
//! code = (v₀ + 4 v₁ + v₂) / 6
//! ```
//!
//! so that a step is 1/6, 5/6 and all of itself after one, two and three whole periods (integral of
//! the impulse response, a quadratic B-spline). After START the first conversion is settled, and
//! comes after 4.5 periods and 8 t_CLK (SBAS561, "Settling time").

use super::registers::{AdcRegisters, ChannelInput};
use super::{CHANNELS, t_clk};
use crate::plant::SensorPlant;

/// Codes that half of AVDD and a quarter of DVDD give, on the channels that have them.
const SUPPLY_CODES: [i32; CHANNELS] = [5_242_880, 5_242_880, 1_730_150, 1_730_150, 5_242_880, 5_242_880];
/// Offsets of the six modulators, within the typical 0.35 mV.
pub const OFFSET_CODES: [i32; CHANNELS] = [700, 713, -240, 95, -611, 388];

const HIGHEST: i32 = 0x7f_ffff;
/// The code of an input at or below the lower end of the range.
pub const LOWEST: i32 = -0x80_0000;

/// The modulators and their filters.
#[derive(Clone, Debug, Default)]
pub struct Converter {
    next: Option<u64>,
    /// Codes of the last three periods, the last one first.
    periods: [[i32; CHANNELS]; 3],
    fresh: bool,
}

impl Converter {
    /// When the next conversion is there.
    pub const fn next(&self) -> Option<u64> {
        self.next
    }

    /// Begins to convert.
    pub fn start(&mut self, now: u64, registers: &AdcRegisters, plant: &mut SensorPlant) {
        let period = registers.period_clocks();
        let first = now + t_clk(period * 9 / 2 + 8);
        plant.align(now, first);
        (self.next, self.fresh) = (Some(first), true);
    }

    /// Ends.
    pub const fn stop(&mut self) {
        self.next = None;
    }

    /// The conversion that is due now.
    pub fn convert(&mut self, now: u64, registers: &AdcRegisters, plant: &mut SensorPlant) -> [i32; CHANNELS] {
        let volts = plant.mean_codes(now);
        self.periods =
            if std::mem::take(&mut self.fresh) { [volts; 3] } else { [volts, self.periods[0], self.periods[1]] };
        self.next = Some(now + t_clk(registers.period_clocks()));
        let inputs = registers.inputs();
        std::array::from_fn(|channel| {
            let code = match inputs[channel] {
                ChannelInput::Pins => {
                    let [v0, v1, v2] = self.periods.map(|period| i64::from(period[channel]));
                    ((v0 + 4 * v1 + v2) as f64 / 6.0).round() as i32
                }
                ChannelInput::Supply => SUPPLY_CODES[channel],
                ChannelInput::Shorted | ChannelInput::Other => 0,
            };
            (code + OFFSET_CODES[channel]).clamp(LOWEST, HIGHEST)
        })
    }
}
