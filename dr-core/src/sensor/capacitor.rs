//! A MEMS capacitor under symbols: from two codes of its capacitance to the voltage shift of the
//! charge in its dielectric.
//!
//! C(V) = α (V − V_sh)² + C₀ below pull-in. A symbol has two parts with V₊ and V₋ (bit 1) or V₋ and
//! V₊ (bit 0), and the capacitance is read at the end of each. Their quasi-differential ΔC = C(V₊)
//! − C(V₋) = α (V₊² − V₋²) − 2 α V_sh (V₊ − V₋) (thesis 2.62) holds no C₀, hence
//!
//! V_sh = (V₊ + V₋)/2 − ΔC / (2 α (V₊ − V₋))
//!
//! Where V_sh moves between the two readings, that is its mean, but for V₊ ≠ −V₋ (weights V₊ and
//! −V₋). A C₀ that drifts by ΔC₀ between them moves it by ΔC₀ / (2 α (V₊ − V₋)), with the sign of
//! the bit. The reading before the symbol could cancel that where a bit repeats, but V_sh would
//! then be another mixture there than where the bit changes, and no longer linear in the stream: on
//! the simulated device that costs 2 mV, and a drift of one per cent an hour 0.01 mV.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | α | curvature of C(V) | F/V² |
//! | δ | share of the second part in a symbol | – |

use super::reading::Level;
use crate::error::{self, ConfigError, Parameter};

/// A capacitor's curve, the voltages of its symbols and the meter's scale. Checked when it is made.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Capacitor {
    farad_per_code: f32,
    curvature_f_v2: f32,
    negative_v: f32,
    positive_v: f32,
    second_share: f32,
}

/// Result of two readings of a symbol.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shift {
    /// V_sh, V.
    pub shift_v: f32,
    /// C₀, F.
    pub offset_f: f32,
}

impl Capacitor {
    /// A capacitor of curvature α in F/V² under symbols of two voltages in V with a second part of
    /// a share δ, read with `farad_per_code` F a code.
    ///
    /// # Errors
    /// Names the parameter that is not positive, voltages that are no pair, or a share that is not
    /// between 0.001 and 0.999.
    pub fn new(
        farad_per_code: f32,
        curvature_f_v2: f32,
        negative_v: f32,
        positive_v: f32,
        second_share: f32,
    ) -> Result<Self, ConfigError> {
        error::positive(Parameter::FaradPerCode, farad_per_code)?;
        error::positive(Parameter::CurvatureFV2, curvature_f_v2)?;
        error::ascending((Parameter::NegativeV, negative_v), (Parameter::PositiveV, positive_v))?;
        error::within(Parameter::SecondShare, second_share, 0.001, 0.999)?;
        Ok(Self { farad_per_code, curvature_f_v2, negative_v, positive_v, second_share })
    }

    pub(crate) fn checked(self) -> Result<Self, ConfigError> {
        Self::new(self.farad_per_code, self.curvature_f_v2, self.negative_v, self.positive_v, self.second_share)
    }

    /// V₋ and V₊, V.
    pub const fn voltages_v(&self) -> (f32, f32) {
        (self.negative_v, self.positive_v)
    }

    /// Capacitance of a code, F.
    pub fn capacitance_f(&self, code: i32) -> f32 {
        // A 24-bit code is exact in f32.
        code as f32 * self.farad_per_code
    }

    /// Voltage shift and offset from the codes at the ends of the two parts of a symbol whose bit
    /// is `bit`.
    pub fn shift(&self, [first, second]: [i32; 2], bit: Level) -> Shift {
        // A difference of codes is exact.
        let rise = first.wrapping_sub(second) as f32;
        let (difference, first_v) = match bit {
            Level::High => (rise, self.positive_v),
            Level::Low => (-rise, self.negative_v),
        };
        let volt_per_code = self.farad_per_code / (2.0 * self.curvature_f_v2 * (self.positive_v - self.negative_v));
        let shift_v = (self.positive_v + self.negative_v) * 0.5 - difference * volt_per_code;
        let over_v = first_v - shift_v;
        Shift { shift_v, offset_f: self.capacitance_f(first) - self.curvature_f_v2 * over_v * over_v }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FARAD_PER_CODE: f64 = 1e-18;
    const CURVATURE_F_V2: f64 = 2e-15;

    fn capacitor(negative_v: f32, positive_v: f32) -> Capacitor {
        Capacitor::new(FARAD_PER_CODE as f32, CURVATURE_F_V2 as f32, negative_v, positive_v, 0.25).unwrap()
    }

    fn code(voltage_v: f64, shift_v: f64, offset_f: f64) -> i32 {
        let over_v = voltage_v - shift_v;
        libm::round((CURVATURE_F_V2 * over_v * over_v + offset_f) / FARAD_PER_CODE) as i32
    }

    #[test]
    fn the_shift_is_found_whatever_the_offset_and_the_bit() {
        for (negative_v, positive_v) in [(-10.0, 10.0), (-8.0, 12.5), (2.0, 9.0)] {
            for (shift_v, offset_f) in [(0.0, 1e-12), (1.5, 1e-12), (-2.25, 3e-12)] {
                let at = |voltage_v: f32| code(voltage_v.into(), shift_v, offset_f);
                let [low, high] = [at(negative_v), at(positive_v)];
                for (bit, first, second) in [(Level::Low, low, high), (Level::High, high, low)] {
                    let shift = capacitor(negative_v, positive_v).shift([first, second], bit);
                    // A code is 17 µV and less here.
                    assert!((f64::from(shift.shift_v) - shift_v).abs() < 1e-4, "{shift:?}, {shift_v}");
                    assert!((f64::from(shift.offset_f) / offset_f - 1.0).abs() < 1e-5, "{shift:?}, {offset_f}");
                }
            }
        }
    }

    #[test]
    fn a_shift_that_moves_gives_its_mean_and_a_drift_of_the_offset_what_is_stated() {
        let of = |shifts_v: [f64; 2], drift_f: f64| {
            let codes = [code(10.0, shifts_v[0], 1e-12), code(-10.0, shifts_v[1], 1e-12 + drift_f)];
            f64::from(capacitor(-10.0, 10.0).shift(codes, Level::High).shift_v)
        };
        // Squares of the shift are left: 1.2² − 1² over 4 · 10 V.
        assert!((of([1.2, 1.0], 0.0) - 1.1 + 0.44 / 40.0).abs() < 1e-4, "{}", of([1.2, 1.0], 0.0));
        assert!((of([1.0; 2], 8e-16) - 1.0 - 0.01).abs() < 1e-4, "{}", of([1.0; 2], 8e-16));
    }

    #[test]
    fn refuses_symbols_that_are_no_pair() {
        let refused = |a, b, c, d, e| Capacitor::new(a, b, c, d, e).unwrap_err().parameter;
        assert_eq!(refused(0.0, 1e-15, -1.0, 1.0, 0.5), Parameter::FaradPerCode);
        assert_eq!(refused(1e-18, f32::NAN, -1.0, 1.0, 0.5), Parameter::CurvatureFV2);
        assert_eq!(refused(1e-18, 1e-15, 1.0, 1.0, 0.5), Parameter::PositiveV);
        assert_eq!(refused(1e-18, 1e-15, -1.0, 1.0, 1.0), Parameter::SecondShare);
    }
}
