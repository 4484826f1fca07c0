//! The frequency response of a pair, in K/W.
//!
//! ```text
//! H(jω) = (feed-through + Σ_k R_k / (1 + jω/ξ_k)) · e^(−jω · dead time)
//! ```
//!
//! In continuous time: it is that of the structure, not of a structure that is sampled and held.
//! Above the Nyquist frequency π/Ts of its record a model is extrapolated. Structure `conductance`:
//! H is that of the reference, and in another class the wind takes ΔG_i (y_i − T_gas) from element
//! i, so that all pairs of N elements take part:
//!
//! ```text
//! H_wind = (1 + H diag(ΔG))⁻¹ H
//! ```

use nalgebra::{Complex, ComplexField, DMatrix};

use crate::model::ModelError;
use crate::model::content::{Class, Model, Pair, Structure};
use crate::model::pair_class::PairClass;

/// H(jω) of one pair in the class called `label`, wind included; `None` if the model has no such
/// class.
pub fn response_in_class(model: &Model, pair: &Pair, label: &str, omega_rad_s: f64) -> Option<Complex<f64>> {
    let wind = match (model.structure, &model.wind) {
        (Structure::Conductance, Some(wind)) if label != wind.reference => wind,
        _ => return pair.classes.get(label).map(|class| without_wind(model, pair, class, omega_rad_s)),
    };
    let conductance: Vec<f64> =
        wind.elements.iter().map(|element| element.get(label).map(|dg| dg.value)).collect::<Option<_>>()?;
    let elements = conductance.len();
    let still = DMatrix::from_fn(elements, elements, |output, input| {
        let found = model.pair(&model.inputs[input], &model.outputs[output].name);
        let class = found.and_then(|pair| pair.classes.values().next().map(|class| (pair, class)));
        class.map_or(Complex::ZERO, |(pair, class)| without_wind(model, pair, class, omega_rad_s))
    });
    let loop_gain = DMatrix::from_fn(elements, elements, |output, element| {
        let unit = if output == element { 1.0 } else { 0.0 };
        still[(output, element)] * conductance[element] + unit
    });
    let windy = loop_gain.lu().solve(&still)?;
    let output = model.outputs.iter().position(|output| output.name == pair.output)?;
    let input = model.inputs.iter().position(|name| *name == pair.input)?;
    Some(windy[(output, input)])
}

/// H(jω) of one pair and class in K/W.
fn without_wind(model: &Model, pair: &Pair, class: &Class, omega_rad_s: f64) -> Complex<f64> {
    let poles = pair.mesh_rad_s.iter().zip(&class.r_k_per_w);
    let sum: Complex<f64> = poles.map(|(rate, resistance)| *resistance / Complex::new(1.0, omega_rad_s / rate)).sum();
    let dead_time_s = pair.dead_time_samples as f64 * model.sample_period_s;
    (sum + class.feed_through_k_per_w) * ComplexField::exp(Complex::new(0.0, -omega_rad_s * dead_time_s))
}

/// The impulse response in K/J at times in s: Σ R_k ξ_k e^(−ξ_k (t − dead time)), 0 before. A
/// feed-through, a pulse of no width at the dead time, is not in it.
///
/// # Errors
/// In a wind that has no symbol of its own.
pub fn impulse_response(part: &PairClass, time_s: &[f64]) -> Result<Vec<f64>, ModelError> {
    part.refuse_wind()?;
    let at = |time_s: &f64| {
        let since_s = time_s - part.dead_time_s();
        let poles = part.pair.mesh_rad_s.iter().zip(&part.class.r_k_per_w);
        let sum: f64 = poles.map(|(rate, resistance)| resistance * rate * libm::exp(-rate * since_s)).sum();
        if since_s >= 0.0 { sum } else { 0.0 }
    };
    Ok(time_s.iter().map(at).collect())
}

/// Angular frequencies that show the whole of a pair, evenly spaced on the logarithmic axis: from a
/// decade below its slowest rate to a decade above its fastest, or to the record's Nyquist
/// frequency π/Ts where that comes first.
pub fn frequencies_rad_s(model: &Model, pair: &Pair, points: usize) -> Vec<f64> {
    let nyquist = std::f64::consts::PI / model.sample_period_s;
    let slowest = pair.mesh_rad_s.first().copied().unwrap_or(nyquist / 100.0);
    let fastest = pair.mesh_rad_s.last().copied().unwrap_or(nyquist);
    let first = (slowest / 10.0).min(nyquist / 100.0);
    let last = (fastest * 10.0).min(nyquist);
    (0..points).map(|n| dr_core::model::mesh::rate_rad_s(first, last, n, points)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::testing;

    #[test]
    fn a_single_pole_falls_to_the_root_of_a_half_at_its_rate() {
        let model = testing::model(&[0.5], &[10.0]);
        let value = response_in_class(&model, &model.pairs[0], "all", 0.5).unwrap();
        assert!((value.re - 5.0).abs() < 1e-14 && (value.im + 5.0).abs() < 1e-14);
    }

    #[test]
    fn dead_time_turns_the_phase_and_feed_through_is_left_at_the_top() {
        let mut model = testing::model(&[0.5], &[10.0]);
        model.pairs[0].dead_time_samples = 3;
        model.pairs[0].classes.get_mut("all").unwrap().feed_through_k_per_w = 2.0;
        let omega = 1e6 * std::f64::consts::TAU + 0.5;
        let Complex { re, im } = response_in_class(&model, &model.pairs[0], "all", omega).unwrap();
        // 3 samples of 0.1 s; the pole is down to 1e-6
        let phase = -omega * 0.3;
        assert!((re - 2.0 * libm::cos(phase)).abs() < 1e-5 && (im - 2.0 * libm::sin(phase)).abs() < 1e-5, "{re} {im}");
    }

    #[test]
    fn wind_is_a_conductance_beside_the_element() {
        let mut model = testing::model(&[0.5, 4.0], &[10.0, 3.0]);
        testing::add_wind(&mut model, "gust", 0.2);
        let pair = &model.pairs[0];
        let windy = response_in_class(&model, pair, "gust", 0.7).unwrap();
        let still = response_in_class(&model, pair, "still", 0.7).unwrap();
        // 1/H_wind = 1/H + ΔG
        let expected = (still.inv() + 0.2).inv();
        assert!((windy - expected).modulus() < 1e-13);
        assert_eq!(response_in_class(&model, pair, "storm", 0.7), None);
    }

    #[test]
    fn an_impulse_response_begins_behind_the_dead_time_and_its_integral_is_the_gain() {
        let mut model = testing::model(&[0.5, 4.0], &[10.0, 3.0]);
        model.pairs[0].dead_time_samples = 3;
        let part = PairClass::find(&model, None, None).unwrap();
        let time_s: Vec<f64> = (0..100_000).map(|n| 0.3 + (f64::from(n) + 0.5) * 1e-3).collect();
        let sum: f64 = impulse_response(&part, &time_s).unwrap().iter().sum();
        // By the middles of 1 ms, each pole is right to (ξ h)²/24.
        assert!((sum * 1e-3 - 13.0).abs() < 1e-4, "{sum}");
        assert_eq!(impulse_response(&part, &[0.1, 0.299]).unwrap(), [0.0, 0.0]);
    }

    #[test]
    fn frequencies_end_at_nyquist() {
        let model = testing::model(&[0.5, 20.0], &[10.0, 3.0]);
        let frequencies = frequencies_rad_s(&model, &model.pairs[0], 50);
        assert_eq!(frequencies.len(), 50);
        assert_eq!(frequencies[0], 0.05);
        assert_eq!(frequencies[49], std::f64::consts::PI / 0.1);
    }
}
