//! The simulated front end: two-level currents into platinum resistors, and the converter that
//! reads their voltage.
//!
//! ```text
//! P    = I² R(T)                                      heat in the resistor, W
//! code = round((I R(T) + e) / q), held to ±full scale,    e ~ N(0, σ²) V,   q = volt per code
//! ```
//!
//! The true resistors and currents differ from the nominal ones by seeded errors, drawn once: R0,
//! its temperature coefficient and either current of every element, each normal with the standard
//! deviation asked for. The high current of an element can be off by a known error ε besides, which
//! is one of the ratio of its currents:
//!
//! ```text
//! I_high / I_low = (1 + ε) · ratio of the drawn currents,    ε = 10⁻⁶ current_ratio_error_ppm
//! ```
//!
//! The controller only knows the head's values.
//!
//! Faults: an open element drives its current source to the rail, so the code is positive full
//! scale; a shorted one leaves only the noise. Neither takes any heat.
//!
//! Limits: no settling of the currents, no reference drift, no correlation between channels; ideal
//! 24-bit steps.

use dr_core::sensor::platinum::Platinum;

use std::collections::BTreeMap;

use diffusive::random::StandardNormal;
use rand_chacha::ChaCha8Rng;
use rand_distr::Distribution;

use anemometry::head::{NominalElement, PlatinumKind};

use super::error::{SensorError, require};

/// Codes of a 24-bit two's complement converter.
pub const HIGHEST_CODE: i32 = 0x7F_FFFF;
pub const LOWEST_CODE: i32 = -0x80_0000;

/// Imperfections of the front end; all zero by default. Errors are standard deviations in percent
/// of the nominal value.
#[derive(Clone, Debug, Default, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Imperfections {
    /// Noise of the converter's input, V rms.
    pub noise_v_rms: f64,
    /// Error of R0, %.
    pub resistance_error_percent: f64,
    /// Error of its temperature coefficient, %.
    pub coefficient_error_percent: f64,
    /// Error of either current, %.
    pub current_error_percent: f64,
    /// By element, of the true ratio of its high to its low current, ppm of the nominal ratio.
    pub current_ratio_error_ppm: BTreeMap<String, f64>,
}

/// Greatest error of a ratio that can be simulated, ppm: the 2 % by which a sensor board's high
/// current may differ.
const RATIO_ERROR_MOST_PPM: f64 = 20_000.0;

/// Fault of a resistor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ResistorFault {
    /// No current flows.
    Open,
    /// No voltage is left.
    Shorted,
}

#[derive(Clone, Copy, Debug)]
struct FrontEndChannel {
    platinum: Platinum,
    /// Low and high.
    current_a: [f64; 2],
    /// Square of the one that is held, A².
    held_a2: f64,
    fault: Option<ResistorFault>,
    /// Resistance over that of the platinum: what has drifted.
    resistance_factor: f64,
}

#[derive(Clone, Debug)]
pub struct SimulatedFrontEnd {
    elements: Vec<FrontEndChannel>,
    code_per_volt: f64,
    noise_v_rms: f64,
    noise: ChaCha8Rng,
    /// Noise of the last sample.
    noise_v: Vec<f64>,
}

impl SimulatedFrontEnd {
    /// `elements` are names and data sheets; `tolerances` draws their errors, `noise` the noise of
    /// every sample.
    pub fn new(
        elements: &[(&str, NominalElement)],
        volt_per_code: f64,
        imperfections: &Imperfections,
        mut tolerances: ChaCha8Rng,
        noise: ChaCha8Rng,
    ) -> Result<SimulatedFrontEnd, SensorError> {
        let positive = volt_per_code.is_finite() && volt_per_code > 0.0;
        require(positive, "volt_per_code", volt_per_code, "more than 0")?;
        imperfections.check()?;
        let mut made = Vec::with_capacity(elements.len());
        for (i, (name, element)) in elements.iter().enumerate() {
            // All four are always drawn, so that asking for one error does not change the others.
            let errors: [f64; 4] = std::array::from_fn(|_| StandardNormal.sample(&mut tolerances));
            let mut channel = FrontEndChannel::new(element, imperfections, errors, i)?;
            channel.current_a[1] *= 1.0 + 1e-6 * imperfections.current_ratio_error_ppm.get(*name).unwrap_or(&0.0);
            made.push(channel);
        }
        Ok(SimulatedFrontEnd {
            noise_v: vec![0.0; made.len()],
            elements: made,
            code_per_volt: 1.0 / volt_per_code,
            noise_v_rms: imperfections.noise_v_rms,
            noise,
        })
    }

    /// Sets the currents for [`power_w`](Self::power_w); bit i of `heaters` is element i at its
    /// high level.
    pub fn hold(&mut self, heaters: usize) {
        for (i, element) in self.elements.iter_mut().enumerate() {
            let current_a = element.current_a[heaters >> i & 1];
            element.held_a2 = current_a * current_a;
        }
    }

    /// Heat in an element at `temperature_c` with the current that is held, W.
    pub fn power_w(&self, element: usize, temperature_c: f64) -> f64 {
        let element = &self.elements[element];
        if element.fault.is_some() {
            return 0.0;
        }
        element.held_a2 * element.resistance_ohm(temperature_c)
    }

    /// Converts the voltage of every element into `codes`; bit i of `heaters` is element i at its
    /// high level. Draws fresh noise.
    pub fn sample(&mut self, temperature_c: &[f64], heaters: usize, codes: &mut [i32]) {
        let all = self.elements.iter().zip(temperature_c).zip(codes).zip(&mut self.noise_v);
        for (i, (((element, &temperature_c), code), noise_v)) in all.enumerate() {
            let volt = match element.fault {
                None => element.current_a[heaters >> i & 1] * element.resistance_ohm(temperature_c),
                Some(ResistorFault::Open) => f64::INFINITY,
                Some(ResistorFault::Shorted) => 0.0,
            };
            let noise: f64 = StandardNormal.sample(&mut self.noise);
            *noise_v = self.noise_v_rms * noise;
            *code = code_of((volt + *noise_v) * self.code_per_volt);
        }
    }

    /// Codes that the converters would have made of a voltage that amounts to `code`, at the last
    /// sample, with that sample's noise: neither has an offset, nor is its scale in error.
    pub fn codes_without_elements(&self, code: i32) -> Vec<i32> {
        let code = f64::from(code);
        self.noise_v.iter().map(|noise_v| code_of(code + noise_v * self.code_per_volt)).collect()
    }

    /// The resistance of an element over that of its platinum, from now on.
    pub fn set_resistance_factor(&mut self, element: usize, factor: f64) {
        self.elements[element].resistance_factor = factor;
    }

    pub fn set_fault(&mut self, element: usize, fault: Option<ResistorFault>) {
        self.elements[element].fault = fault;
    }
}

/// The nearest code there is.
fn code_of(exact: f64) -> i32 {
    exact.round().clamp(f64::from(LOWEST_CODE), f64::from(HIGHEST_CODE)) as i32
}

impl Imperfections {
    fn check(&self) -> Result<(), SensorError> {
        let all = [
            ("front_end.noise_v_rms", self.noise_v_rms),
            ("front_end.resistance_error_percent", self.resistance_error_percent),
            ("front_end.coefficient_error_percent", self.coefficient_error_percent),
            ("front_end.current_error_percent", self.current_error_percent),
        ];
        all.into_iter()
            .try_for_each(|(key, value)| require(value.is_finite() && value >= 0.0, key, value, "zero or more"))?;
        self.current_ratio_error_ppm.iter().try_for_each(|(name, &ppm)| {
            let key = format!("front_end.current_ratio_error_ppm.{name}");
            require(ppm.abs() <= RATIO_ERROR_MOST_PPM, &key, ppm, "-20000 to 20000")
        })
    }
}

impl FrontEndChannel {
    fn new(
        nominal: &NominalElement,
        imperfections: &Imperfections,
        [resistance, coefficient, low, high]: [f64; 4],
        index: usize,
    ) -> Result<FrontEndChannel, SensorError> {
        let (low_a, high_a) = (nominal.current_low_a, nominal.current_high_a);
        if !(low_a > 0.0 && low_a < high_a && high_a.is_finite()) {
            return Err(SensorError::Elements(format!(
                "currents of element {index} are {low_a} A low and {high_a} A high; they must be positive and the low one smaller"
            )));
        }
        let off_by = |percent: f64, normal: f64| 1.0 + 0.01 * percent * normal;
        let resistance = off_by(imperfections.resistance_error_percent, resistance);
        let platinum = match nominal.platinum {
            PlatinumKind::Linear { resistance_0c_ohm, coefficient_per_c } => Platinum::linear(
                (resistance_0c_ohm * resistance) as f32,
                (coefficient_per_c * off_by(imperfections.coefficient_error_percent, coefficient)) as f32,
            ),
            PlatinumKind::Iec60751 { resistance_0c_ohm } => Platinum::iec60751((resistance_0c_ohm * resistance) as f32),
        }
        .map_err(|error| SensorError::Elements(format!("platinum of element {index}: {error}")))?;
        let current_error = imperfections.current_error_percent;
        Ok(FrontEndChannel {
            platinum,
            current_a: [low_a * off_by(current_error, low), high_a * off_by(current_error, high)],
            held_a2: 0.0,
            fault: None,
            resistance_factor: 1.0,
        })
    }

    fn resistance_ohm(&self, temperature_c: f64) -> f64 {
        self.resistance_factor * f64::from(self.platinum.resistance_ohm(temperature_c as f32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::rand_core::SeedableRng;

    const VOLT_PER_CODE: f64 = 4.0 / 8_388_608.0;
    const NOMINAL: NominalElement = NominalElement {
        platinum: PlatinumKind::Linear { resistance_0c_ohm: 175.0, coefficient_per_c: 0.0031 },
        current_low_a: 3e-3,
        current_high_a: 16e-3,
    };
    const ELEMENTS: usize = 6;
    const ALL_HIGH: usize = 0x3F;

    fn power_w(front_end: &SimulatedFrontEnd, element: usize, temperature_c: f64, heaters: usize) -> f64 {
        let mut front_end = front_end.clone();
        front_end.hold(heaters);
        front_end.power_w(element, temperature_c)
    }

    fn front_end(imperfections: Imperfections, seed: u64) -> SimulatedFrontEnd {
        let (tolerances, noise) = (ChaCha8Rng::seed_from_u64(seed), ChaCha8Rng::seed_from_u64(seed + 1000));
        SimulatedFrontEnd::new(&[("film", NOMINAL); ELEMENTS], VOLT_PER_CODE, &imperfections, tolerances, noise)
            .unwrap()
    }

    fn sample(front_end: &mut SimulatedFrontEnd, temperature_c: f64, heaters: usize) -> [i32; ELEMENTS] {
        let mut codes = [0; ELEMENTS];
        front_end.sample(&[temperature_c; ELEMENTS], heaters, &mut codes);
        codes
    }

    #[test]
    fn a_code_is_the_voltage_at_the_current_that_flows() {
        let mut front_end = front_end(Imperfections::default(), 1);
        let codes = sample(&mut front_end, 0.0, 0b000001);
        // 16 mA and 3 mA through 175 Ω.
        assert_eq!(codes[0], (2.8_f64 / VOLT_PER_CODE).round() as i32);
        assert_eq!(codes[1], (0.525_f64 / VOLT_PER_CODE).round() as i32);
        assert!((power_w(&front_end, 0, 0.0, ALL_HIGH) - 0.0448).abs() < 1e-12);
        assert!((power_w(&front_end, 0, 0.0, 0) - 0.001575).abs() < 1e-12);
    }

    #[test]
    fn quantises_in_steps_of_one_code() {
        let mut front_end = front_end(Imperfections::default(), 1);
        // One code is 4 V/2²³ = 0.477 µV, at 16 mA and 0.5425 Ω/K that is 54.9 µK.
        let kelvin_per_code = VOLT_PER_CODE / (16e-3 * 175.0 * 0.0031);
        let steps: Vec<i32> =
            (0..2000).map(|k| sample(&mut front_end, -23.0 + 0.1 * k as f64 * kelvin_per_code, ALL_HIGH)[0]).collect();
        // Ten points a code: 200 codes in all, never more than one at a time.
        assert!(steps.windows(2).all(|w| (0..=1).contains(&(w[1] - w[0]))));
        assert!((steps[1999] - steps[0] - 200).abs() <= 1);
    }

    #[test]
    fn noise_has_the_rms_asked_for() {
        let mut front_end = front_end(Imperfections { noise_v_rms: 1e-5, ..Imperfections::default() }, 1);
        let count = 20_000;
        let mut samples = Vec::new();
        for _ in 0..count {
            samples.extend(sample(&mut front_end, -23.0, ALL_HIGH).map(|code| f64::from(code) * VOLT_PER_CODE));
        }
        let n = samples.len() as f64;
        let mean = samples.iter().sum::<f64>() / n;
        let rms = (samples.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
        // Four standard errors 1/√(2N) of a standard deviation; quantisation adds 1e-4 of it.
        assert!((rms / 1e-5 - 1.0).abs() < 4.0 / (2.0 * n).sqrt() + 1e-4, "{rms}");
    }

    #[test]
    fn saturates_to_full_scale() {
        let mut front_end = front_end(Imperfections::default(), 1);
        // 4 V at 16 mA is 250 Ω, that is 138 °C.
        assert_eq!(sample(&mut front_end, 150.0, ALL_HIGH), [HIGHEST_CODE; ELEMENTS]);
    }

    #[test]
    fn an_open_element_reads_full_scale_and_a_shorted_one_nothing() {
        let mut front_end = front_end(Imperfections { noise_v_rms: 1.5e-6, ..Imperfections::default() }, 1);
        front_end.set_fault(0, Some(ResistorFault::Open));
        front_end.set_fault(1, Some(ResistorFault::Shorted));
        for heaters in [0, ALL_HIGH] {
            let codes = sample(&mut front_end, -23.0, heaters);
            assert_eq!(codes[0], HIGHEST_CODE);
            // Six sigma of the noise is 19 codes.
            assert!(codes[1].abs() < 20, "{}", codes[1]);
            assert!(codes[2] > 900_000);
        }
        assert_eq!(power_w(&front_end, 0, -23.0, ALL_HIGH), 0.0);
        assert_eq!(power_w(&front_end, 1, -23.0, ALL_HIGH), 0.0);
        front_end.set_fault(0, None);
        assert!(sample(&mut front_end, -23.0, ALL_HIGH)[0] < HIGHEST_CODE);
    }

    #[test]
    fn errors_of_the_elements_have_the_spread_asked_for_and_follow_the_seed() {
        let imperfections = || Imperfections { resistance_error_percent: 0.5, ..Imperfections::default() };
        let count = 2000;
        let mut sum = 0.0;
        for seed in 0..count {
            let front_end = front_end(imperfections(), seed);
            let resistance = power_w(&front_end, 0, 0.0, ALL_HIGH) / (16e-3 * 16e-3);
            sum += (resistance / 175.0 - 1.0).powi(2);
        }
        let spread = (sum / count as f64).sqrt();
        // Four standard errors of a standard deviation.
        assert!((spread / 0.005 - 1.0).abs() < 4.0 / (2.0 * count as f64).sqrt(), "{spread}");
        let power = |seed| power_w(&front_end(imperfections(), seed), 3, 10.0, ALL_HIGH).to_bits();
        assert_eq!(power(7), power(7));
        assert_ne!(power(7), power(8));
    }

    #[test]
    fn an_error_of_the_ratio_is_one_of_the_high_current_alone() {
        let off = |ppm: f64| Imperfections {
            current_error_percent: 0.1,
            current_ratio_error_ppm: [("film".to_owned(), ppm)].into(),
            ..Imperfections::default()
        };
        let ratio = |heaters| {
            let power_w = |ppm| power_w(&front_end(off(ppm), 5), 2, 0.0, heaters);
            power_w(1000.0) / power_w(0.0)
        };
        assert_eq!(ratio(0), 1.0);
        // The power goes with the square of the current.
        assert!((ratio(ALL_HIGH) - 1.001 * 1.001).abs() < 1e-12);
        let none = Imperfections { current_error_percent: 0.1, ..Imperfections::default() };
        let power_w = |imperfections| power_w(&front_end(imperfections, 5), 2, 0.0, ALL_HIGH).to_bits();
        assert_eq!(power_w(none), power_w(off(0.0)));
    }

    #[test]
    fn refuses_impossible_values_by_name() {
        let new = |element: NominalElement, imperfections: Imperfections| {
            let rng = || ChaCha8Rng::seed_from_u64(1);
            SimulatedFrontEnd::new(&[("film", element); ELEMENTS], VOLT_PER_CODE, &imperfections, rng(), rng())
                .unwrap_err()
                .to_string()
        };
        let swapped = NominalElement { current_low_a: 17e-3, ..NOMINAL };
        assert!(new(swapped, Imperfections::default()).contains("current"));
        let noise = Imperfections { noise_v_rms: f64::NAN, ..Imperfections::default() };
        assert!(new(NOMINAL, noise).contains("front_end.noise_v_rms"));
        let ratio = [("film".to_owned(), 30_000.0)].into();
        let ratio = Imperfections { current_ratio_error_ppm: ratio, ..Imperfections::default() };
        assert!(new(NOMINAL, ratio).contains("front_end.current_ratio_error_ppm.film"));
        let platinum = PlatinumKind::Linear { resistance_0c_ohm: -1.0, coefficient_per_c: 0.0031 };
        assert!(new(NominalElement { platinum, ..NOMINAL }, Imperfections::default()).contains("resistance_0c_ohm"));
    }
}
