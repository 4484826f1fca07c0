//! Platinum resistors: temperature to resistance and back.
//!
//! | characteristic | law | source | range |
//! |---|---|---|---|
//! | linear (thin film) | R = R0 (1 + αT) | thesis, prototype B: R0 = 175 Ω, α = 0.0031 /°C | −200 … 300 °C |
//! | IEC 60751 (Callendar–Van Dusen) | R = R0 (1 + AT + BT² + C(T−100)T³), C only for T < 0 | IEC 60751:2008 | −200 … 850 °C |
//!
//! T in °C, R in Ω. Both directions use only `+ − × ÷`, so that they may run every tick and give
//! the same bits on every body. The inverse of IEC 60751 is Newton's method with a fixed number of
//! steps from the linear guess.
//!
//! Accuracy against f64 (test `the_inverse_returns_to_the_temperature`): 0.05 mK within −100 … 150
//! °C and 0.3 mK up to the ends of the range, which is what one unit in the last place of an f32
//! resistance is worth.

use crate::error::{self, ConfigError, Parameter};

/// Callendar–Van Dusen coefficients of IEC 60751: /°C, /°C², /°C⁴.
const A: f32 = 3.9083e-3;
const B: f32 = -5.775e-7;
const C: f32 = -4.183e-12;

/// Newton's steps. Three reach the last bits from any guess in the range; the fourth costs little
/// and needs no proof.
const NEWTON_STEPS: usize = 4;

/// The characteristic of one platinum resistor.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Platinum {
    resistance_0c_ohm: f32,
    law: Law,
}

#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
enum Law {
    Linear { coefficient_per_c: f32 },
    Iec60751,
}

impl Platinum {
    /// A linear film resistor.
    ///
    /// # Errors
    /// Names the parameter that is not a finite number greater than zero, or a coefficient above
    /// 0.01 /°C.
    pub fn linear(resistance_0c_ohm: f32, coefficient_per_c: f32) -> Result<Self, ConfigError> {
        error::positive(Parameter::CoefficientPerC, coefficient_per_c)?;
        error::within(Parameter::CoefficientPerC, coefficient_per_c, 0.0, 0.01)?;
        Ok(Self { resistance_0c_ohm: checked_resistance(resistance_0c_ohm)?, law: Law::Linear { coefficient_per_c } })
    }

    /// A resistor after IEC 60751, `resistance_0c_ohm` being 100 for a Pt100.
    ///
    /// # Errors
    /// If the resistance is not a number greater than zero, or above 1 MΩ.
    pub fn iec60751(resistance_0c_ohm: f32) -> Result<Self, ConfigError> {
        Ok(Self { resistance_0c_ohm: checked_resistance(resistance_0c_ohm)?, law: Law::Iec60751 })
    }

    /// Checks values from a link or a file, which no constructor has checked.
    pub(crate) fn checked(self) -> Result<Self, ConfigError> {
        match self.law {
            Law::Linear { coefficient_per_c } => Self::linear(self.resistance_0c_ohm, coefficient_per_c),
            Law::Iec60751 => Self::iec60751(self.resistance_0c_ohm),
        }
    }

    /// Temperatures for which the law is stated, °C.
    pub const fn range_c(&self) -> (f32, f32) {
        match self.law {
            Law::Linear { .. } => (-200.0, 300.0),
            Law::Iec60751 => (-200.0, 850.0),
        }
    }

    /// Resistance in Ω at a temperature in °C.
    pub fn resistance_ohm(&self, temperature_c: f32) -> f32 {
        match self.law {
            Law::Linear { coefficient_per_c } => self.resistance_0c_ohm * (1.0 + coefficient_per_c * temperature_c),
            Law::Iec60751 => self.resistance_0c_ohm * (1.0 + relative_rise(temperature_c).0),
        }
    }

    /// Temperature in °C at a resistance in Ω.
    pub fn temperature_c(&self, resistance_ohm: f32) -> f32 {
        // R − R0 is exact near R0, which R/R0 − 1 is not.
        let rise = (resistance_ohm - self.resistance_0c_ohm) / self.resistance_0c_ohm;
        match self.law {
            Law::Linear { coefficient_per_c } => rise / coefficient_per_c,
            Law::Iec60751 => {
                let mut temperature_c = rise / A;
                for _ in 0..NEWTON_STEPS {
                    let (value, slope) = relative_rise(temperature_c);
                    temperature_c += (rise - value) / slope;
                }
                temperature_c
            }
        }
    }
}

/// A resistance that a resistor can have, Ω.
fn checked_resistance(resistance_0c_ohm: f32) -> Result<f32, ConfigError> {
    error::positive(Parameter::Resistance0cOhm, resistance_0c_ohm)?;
    error::within(Parameter::Resistance0cOhm, resistance_0c_ohm, 0.0, 1e6)
}

/// R/R0 − 1 of IEC 60751 and its derivative to temperature.
fn relative_rise(temperature_c: f32) -> (f32, f32) {
    let t = temperature_c;
    if t < 0.0 {
        // C (t − 100) t³ = t·t·(C t (t − 100)), and its derivative C t² (4t − 300)
        (t * (A + t * (B + C * t * (t - 100.0))), A + t * (2.0 * B) + C * t * t * (4.0 * t - 300.0))
    } else {
        (t * (A + t * B), A + t * (2.0 * B))
    }
}

crate::fields::fields!(enum Law { 0 Linear { coefficient_per_c }, 1 Iec60751 });

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn iec60751_meets_the_table_of_the_standard() {
        let pt100 = Platinum::iec60751(100.0).unwrap();
        // Table 1 of IEC 60751, two decimals.
        for (t, r) in [
            (-200.0, 18.52),
            (-100.0, 60.26),
            (-50.0, 80.31),
            (0.0, 100.0),
            (100.0, 138.51),
            (500.0, 280.98),
            (850.0, 390.48),
        ] {
            assert!((pt100.resistance_ohm(t) - r).abs() <= 0.0051, "{t} °C: {}", pt100.resistance_ohm(t));
        }
    }

    #[test]
    fn the_inverse_returns_to_the_temperature() {
        for platinum in [Platinum::iec60751(100.0).unwrap(), Platinum::linear(175.0, 0.0031).unwrap()] {
            let (from, to) = platinum.range_c();
            let mut t = from;
            while t <= to {
                let error_k = (platinum.temperature_c(platinum.resistance_ohm(t)) - t).abs();
                let bound_k = if (-100.0..=150.0).contains(&t) { 5e-5 } else { 3e-4 };
                assert!(error_k <= bound_k, "{platinum:?} {t} °C: {error_k} K");
                t += 0.37;
            }
        }
    }

    #[test]
    fn the_resistance_agrees_with_f64() {
        let pt100 = Platinum::iec60751(100.0).unwrap();
        for i in -2000..8500 {
            let t = f64::from(i) * 0.1;
            let cubic = if t < 0.0 { -4.183e-12 * (t - 100.0) * t * t * t } else { 0.0 };
            let exact = 100.0 * (1.0 + 3.9083e-3 * t - 5.775e-7 * t * t + cubic);
            // Two roundings of a value up to 390 Ω and a coefficient rounded to f32.
            assert!((f64::from(pt100.resistance_ohm(t as f32)) - exact).abs() < 1.0e-4, "{t}");
        }
    }

    #[test]
    fn refuses_what_is_no_resistor() {
        for (r, a) in
            [(0.0, 0.003), (-1.0, 0.003), (f32::NAN, 0.003), (100.0, 0.0), (100.0, 0.5), (100.0, f32::INFINITY)]
        {
            assert!(Platinum::linear(r, a).is_err(), "{r} {a}");
        }
        assert_eq!(Platinum::iec60751(f32::NAN).unwrap_err().parameter, Parameter::Resistance0cOhm);
    }

    #[test]
    fn what_came_over_a_link_is_checked_as_if_it_were_made_here() {
        for sound in [Platinum::iec60751(100.0).unwrap(), Platinum::linear(175.0, 0.0031).unwrap()] {
            assert_eq!(sound.checked(), Ok(sound));
            for resistance_0c_ohm in [0.0, f32::NAN, 2e6] {
                let broken = Platinum { resistance_0c_ohm, ..sound };
                assert_eq!(broken.checked().unwrap_err().parameter, Parameter::Resistance0cOhm, "{broken:?}");
            }
        }
        let steep = Platinum { resistance_0c_ohm: 100.0, law: Law::Linear { coefficient_per_c: 0.5 } };
        assert_eq!(steep.checked().unwrap_err().parameter, Parameter::CoefficientPerC);
    }

    #[test]
    fn a_checksum_distinguishes_resistors() {
        let of = |platinum: Platinum| crate::checksum::Checksum::of(&platinum);
        let all = [
            Platinum::iec60751(100.0).unwrap(),
            Platinum::iec60751(1000.0).unwrap(),
            Platinum::linear(100.0, 0.0031).unwrap(),
            Platinum::linear(100.0, 0.0038).unwrap(),
        ];
        for (place, one) in all.iter().enumerate() {
            assert!(all[..place].iter().all(|other| of(*one) != of(*other)), "{one:?}");
        }
    }
}
