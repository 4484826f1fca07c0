//! Noise of a reading in kelvins: that of the voltage over what a kelvin changes of it.
//!
//! ```text
//! σ_K = σ_V / (I dR/dT)
//! ```
//!
//! A reading at the high level is so much better than one at the low level as its current is
//! greater. σ_V, with all that adds to the voltage, is best estimated from what the identification
//! leaves of an element that stood at its low level.

use super::kalman::ReadingNoise;
use crate::head::element::HeadElement;
use crate::head::file::Head;
use diffusive::model::Model;
use recording::TEMPERATURE;

/// Of the difference by which dR/dT is taken, K.
const STEP_K: f64 = 1.0;

impl ReadingNoise {
    /// Of a voltage read with a noise of `sigma_v`, about a temperature.
    pub fn of_volts(sigma_v: f64, element: &HeadElement, temperature_c: f64) -> Self {
        let platinum = element.config.channel.platinum();
        let resistance = |temperature_c: f64| f64::from(platinum.resistance_ohm(temperature_c as f32));
        let ohm_per_k = (resistance(temperature_c + STEP_K) - resistance(temperature_c - STEP_K)) / (2.0 * STEP_K);
        let of = |current_a: f64| sigma_v / (current_a * ohm_per_k);
        Self { low_k: of(element.nominal.current_low_a), high_k: of(element.nominal.current_high_a) }
    }

    /// Of what is known at the low level.
    pub fn of_low(low_k: f64, element: &HeadElement) -> Self {
        Self { low_k, high_k: low_k * element.nominal.current_low_a / element.nominal.current_high_a }
    }
}

/// By element of a head, from the residuals that the model of `anemo head identify` leaves at the
/// low level; 0 for an element without a model.
pub fn reading_noise(model: &Model, head: &Head) -> Vec<ReadingNoise> {
    let of = |element: &HeadElement| {
        let output =
            model.outputs.iter().find(|output| output.name == recording::column_name(TEMPERATURE, &element.name));
        ReadingNoise::of_low(output.map_or(0.0, |output| output.residual_rms), element)
    };
    head.elements.iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn four_microvolts_are_two_and_a_half_millikelvins_at_four_milliamperes() {
        let head = Head::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../heads/sphere-a.toml")).unwrap();
        let noise = ReadingNoise::of_volts(4e-6, &head.elements[0], -40.0);
        // IEC 60751: dR/dT = R0 (A + 2 B T + C (4 T³ − 300 T²)) = 0.3967 Ω/K; f32 of the resistance
        // leaves 1e-5.
        let t: f64 = -40.0;
        let ohm_per_k = 100.0 * (3.9083e-3 - 2.0 * 5.775e-7 * t - 4.183e-12 * (4.0 * t.powi(3) - 300.0 * t * t));
        assert!((noise.low_k * 0.004 * ohm_per_k / 4e-6 - 1.0).abs() < 1e-4, "{noise:?}");
        let other = ReadingNoise::of_low(noise.low_k, &head.elements[0]);
        assert!((other.high_k / noise.high_k - 1.0).abs() < 1e-12);
    }
}
