//! The second way to switch heaters off: the supply of the platinum.
//!
//! A heater whose switch, op-amp or MOSFET is stuck goes on after a trip, and at the low level it
//! then has a voltage that no element can have there. The status LED's pin stands still from then
//! on, and the board's cut-off takes the supply away (`docs/reference/board.md`). Only a reset
//! brings it back.

use dr_core::sensor::Reading;

/// Full scale of the ADC, 4 V.
const FULL_SCALE: i32 = 1 << 23;
/// 1.2 V: 400 Ω at 3 mA. A heater that is stuck high has 2.1 V at least.
const LEAST: i32 = FULL_SCALE / 10 * 3;
/// An element that is open is at the upper end, and has no current.
const MOST: i32 = FULL_SCALE / 1_000 * 998;
/// So many ticks in a row.
const TICKS: u8 = 5;

/// Judges whether a heater goes on while all are lowered.
pub struct CutOff {
    ticks: u8,
}

impl CutOff {
    /// The supply is there.
    pub const fn open() -> Self {
        Self { ticks: 0 }
    }

    /// One tick, with the readings of the low level if the instrument is `tripped`. Whether the
    /// supply is to be cut: for good.
    pub fn judge(&mut self, tripped: bool, readings: &[Reading]) -> bool {
        let heats = |reading: &Reading| matches!(reading, Reading::Code(code) if (LEAST..MOST).contains(code));
        if self.ticks < TICKS {
            self.ticks = if tripped && readings.iter().any(heats) { self.ticks + 1 } else { 0 };
        }
        self.ticks >= TICKS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn code(volt: f64) -> Reading {
        Reading::Code((volt / 4.0 * f64::from(FULL_SCALE)) as i32)
    }

    #[test]
    fn a_heater_that_goes_on_after_a_trip_cuts_the_supply_for_good() {
        // 16 mA through 130 ohm, the coldest; drain and gate shorted; MOSFET shorted.
        for volt in [2.08, 3.24, 3.98] {
            let mut cut_off = CutOff::open();
            let readings = [code(0.5), code(volt), Reading::Missing];
            assert!((1..TICKS).all(|_| !cut_off.judge(true, &readings)), "{volt} V");
            assert!(cut_off.judge(true, &readings), "{volt} V");
            assert!(cut_off.judge(false, &[Reading::Missing]));
        }
    }

    #[test]
    fn nothing_else_cuts_it() {
        let mut cut_off = CutOff::open();
        for _ in 0..3 * u32::from(TICKS) {
            // The high level while it is wanted.
            assert!(!cut_off.judge(false, &[code(2.6)]));
            // The hottest element at the low level, one that is open, one without a reading.
            assert!(!cut_off.judge(true, &[code(0.79), code(4.0), Reading::Missing]));
        }
        // Single bad codes.
        assert!((0..200).all(|tick| !cut_off.judge(true, &[code(if tick % 5 == 0 { 0.5 } else { 2.6 })])));
    }
}
