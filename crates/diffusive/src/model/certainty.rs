//! Uncertainty of what follows from a model's resistances: frequency response and thermal
//! impedance, with standard errors by the covariance of all parameters together.
//!
//! ```text
//! var f = gᵀ C g,   g = ∂f/∂θ,   θ = (R_1 … R_K, feed-through, ln ξ_1 … ln ξ_K)
//! Z_th(t) = feed-through + Σ_k R_k (1 − e^(−ξ_k t)),   t counted from the end of the dead time
//! ```
//!
//! Neighbouring resistances are strongly anticorrelated: taken one by one, their standard errors
//! would make f several times less certain than it is. Where models that predict as well have other
//! steady gains, the steady gain's standard error is greater than C says; what it has beyond is
//! taken for an uncertainty of the slowest rate's resistance. All holds for white residuals.

use nalgebra::Complex;

use super::content::{Class, Model, Pair, Structure};

/// 95 % of a normal distribution lie within so many standard deviations.
pub const NORMAL_95: f64 = 1.96;

/// A frequency response at one frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResponseError {
    /// Standard error of ln |H|.
    pub log_magnitude: f64,
    /// Standard error of the phase, °.
    pub phase_deg: f64,
}

/// Standard errors of a pair's response in the class called `label`; `None` where the covariance is
/// not known, as for the wind of structure `conductance`.
pub fn response_error(model: &Model, pair: &Pair, label: &str, omega_rad_s: f64) -> Option<ResponseError> {
    let is_wind = model.wind.as_ref().is_some_and(|wind| wind.reference != label);
    if model.structure == Structure::Conductance && is_wind {
        return None;
    }
    let class = pair.classes.get(label)?;
    let poles = || pair.mesh_rad_s.iter().map(|rate| Complex::new(1.0, omega_rad_s / rate).inv());
    let shares = poles().chain([Complex::from(1.0)]);
    // d/dlnξ of 1/(1 + jω/ξ) is a (1 − a), with a the value itself.
    let of_rates = poles().zip(&class.r_k_per_w).map(|(a, r)| *r * a * (1.0 - a));
    let response: Complex<f64> =
        poles().zip(&class.r_k_per_w).map(|(a, r)| *r * a).sum::<Complex<f64>>() + class.feed_through_k_per_w;
    // Dead time turns response and gradient alike.
    let relative: Vec<Complex<f64>> = shares.chain(of_rates).map(|of| of / response).collect();
    let [log, angle] = [|of: &Complex<f64>| of.re, |of: &Complex<f64>| of.im].map(|part| {
        let gradient: Vec<f64> = relative.iter().map(part).collect();
        standard_error(class, &gradient)
    });
    Some(ResponseError { log_magnitude: log?, phase_deg: angle?.to_degrees() })
}

/// Thermal impedance in K/W a time after a unit step of the input, with its standard error where
/// the covariance is known.
pub fn impedance(model: &Model, pair: &Pair, class: &Class, time_s: f64) -> (f64, Option<f64>) {
    let since_s = time_s - pair.dead_time_samples as f64 * model.sample_period_s;
    if since_s < 0.0 {
        return (0.0, Some(0.0));
    }
    let shares = || pair.mesh_rad_s.iter().map(|rate| -libm::expm1(-rate * since_s)).chain([1.0]);
    let weights = class.r_k_per_w.iter().chain([&class.feed_through_k_per_w]);
    let of_rates = pair.mesh_rad_s.iter().zip(&class.r_k_per_w).map(|(rate, r)| {
        let passed = rate * since_s;
        r * passed * libm::exp(-passed)
    });
    let gradient: Vec<f64> = shares().chain(of_rates).collect();
    (shares().zip(weights).map(|(share, weight)| share * weight).sum(), standard_error(class, &gradient))
}

/// Standard error of the steady gain in which coloured residuals count: they widen what C makes of
/// noise, and not how far models differ that predict as well.
pub fn steady_gain_error(model: &Model, pair: &Pair, class: &Class) -> f64 {
    let (all, of_noise) = (class.se_steady_gain_k_per_w.powi(2), noise_error(class).powi(2));
    (all + (model.inflation(&pair.output).powi(2) - 1.0) * of_noise).sqrt()
}

/// Standard error of a steady gain by the noise alone: without what other hypotheses say.
pub fn noise_error(class: &Class) -> f64 {
    let ones = vec![1.0; class.r_k_per_w.len() + 1];
    let all = class.se_steady_gain_k_per_w;
    class.covariance.as_ref().map_or(all, |triangle| variance(triangle, &ones).sqrt().min(all))
}

/// gᵀ C g of the parameters that `gradient` has.
fn variance(triangle: &[f64], gradient: &[f64]) -> f64 {
    let rows = (0..gradient.len()).filter_map(|i| triangle.get(i * (i + 1) / 2..=i * (i + 3) / 2));
    let of_row = |(i, row): (usize, &[f64])| {
        let twice = |j: usize| if i == j { 1.0 } else { 2.0 };
        row.iter().enumerate().map(|(j, covariance)| twice(j) * covariance * gradient[i] * gradient[j]).sum::<f64>()
    };
    rows.enumerate().map(of_row).sum::<f64>().max(0.0)
}

/// √(gᵀ C g), and what the steady gain has beyond C at the first parameter. `gradient` goes on
/// beyond the parameters where rates are given.
fn standard_error(class: &Class, gradient: &[f64]) -> Option<f64> {
    let triangle = class.covariance.as_ref()?;
    let of_gain = variance(triangle, &vec![1.0; class.r_k_per_w.len() + 1]);
    let beyond = (class.se_steady_gain_k_per_w.powi(2) - of_gain).max(0.0);
    Some((variance(triangle, gradient) + beyond * gradient[0].powi(2)).sqrt())
}

#[cfg(test)]
mod tests {
    use super::super::content::Whiteness;
    use super::super::export::response_in_class;
    use super::super::testing;
    use super::*;

    /// Two resistances of ±1 K/W each whose sum is known to ±0.1 K/W, and rates that were fitted.
    fn model(se_ln_rate: f64) -> Model {
        let mut model = testing::model(&[0.5, 5.0], &[10.0, 3.0]);
        model.pairs[0].se_rate_rad_s = Some(vec![0.5 * se_ln_rate, 5.0 * se_ln_rate]);
        let class = model.pairs[0].classes.get_mut("all").unwrap();
        let mut triangle = vec![1.0, -0.995, 1.0, 0.0, 0.0, 0.0];
        triangle.extend([0.0, 0.0, 0.0, se_ln_rate.powi(2)]);
        triangle.extend([0.0, 0.0, 0.0, 0.0, se_ln_rate.powi(2)]);
        (class.covariance, class.se_steady_gain_k_per_w) = (Some(triangle), 0.1);
        model
    }

    #[test]
    fn what_is_known_of_a_sum_is_known_of_the_response() {
        let model = model(0.0);
        assert!(Model::from_json(&model.to_json()).is_ok());
        let (pair, class) = (&model.pairs[0], &model.pairs[0].classes["all"]);
        let steady = response_error(&model, pair, "all", 1e-6).unwrap();
        assert!((steady.log_magnitude - 0.1 / 13.0).abs() < 1e-6 && steady.phase_deg < 1e-4, "{steady:?}");
        let (gain, se) = impedance(&model, pair, class, 1e6);
        assert!((gain - 13.0).abs() < 1e-12 && (se.unwrap() - 0.1).abs() < 1e-9);
    }

    #[test]
    fn errors_are_those_of_small_changes() {
        // Rates alone are uncertain: by the chain rule the error is the root of the sum of squares
        // of what a small change of each makes.
        let se = 1e-4;
        let mut model = model(se);
        let class = model.pairs[0].classes.get_mut("all").unwrap();
        class.covariance.as_mut().unwrap()[..6].fill(0.0);
        class.se_steady_gain_k_per_w = 0.0;
        let pair = &model.pairs[0];
        let error = response_error(&model, pair, "all", 1.3).unwrap();
        let (value, se_impedance) = impedance(&model, pair, &pair.classes["all"], 0.7);
        let whole = response_in_class(&model, pair, "all", 1.3).unwrap();
        let (mut log, mut angle, mut impedances) = (0.0_f64, 0.0_f64, 0.0_f64);
        for k in 0..2 {
            let mut pair = pair.clone();
            pair.mesh_rad_s[k] *= 1.0 + se;
            let change = nalgebra::ComplexField::ln(response_in_class(&model, &pair, "all", 1.3).unwrap() / whole);
            (log, angle) = (libm::hypot(log, change.re), libm::hypot(angle, change.im));
            impedances = libm::hypot(impedances, impedance(&model, &pair, &pair.classes["all"], 0.7).0 - value);
        }
        // changes of second order are 1e-4 of those of first
        assert!((error.log_magnitude / log - 1.0).abs() < 1e-3, "{error:?} {log}");
        assert!((error.phase_deg / angle.to_degrees() - 1.0).abs() < 1e-3, "{error:?} {angle}");
        assert!((se_impedance.unwrap() / impedances - 1.0).abs() < 1e-3, "{se_impedance:?} {impedances}");
    }

    #[test]
    fn a_steady_gain_of_which_rivals_differ_widens_the_slow_end_only() {
        let mut model = model(0.0);
        model.pairs[0].classes.get_mut("all").unwrap().se_steady_gain_k_per_w = 2.0;
        let class = &model.pairs[0].classes["all"];
        assert!((impedance(&model, &model.pairs[0], class, 1e6).1.unwrap() - 2.0).abs() < 1e-9);
        assert!(impedance(&model, &model.pairs[0], class, 1e-3).1.unwrap() < 0.01);
    }

    #[test]
    fn without_a_covariance_nothing_is_said() {
        let mut plain = testing::model(&[0.5], &[10.0]);
        assert_eq!(response_error(&plain, &plain.pairs[0], "all", 1.0), None);
        testing::add_wind(&mut plain, "gust", 0.2);
        plain.pairs[0].classes.get_mut("still").unwrap().covariance = Some(vec![0.01, 0.0, 0.0]);
        assert!(response_error(&plain, &plain.pairs[0], "still", 1.0).is_some());
        assert_eq!(response_error(&plain, &plain.pairs[0], "gust", 1.0), None);
    }

    #[test]
    fn coloured_residuals_widen_what_noise_makes_of_the_steady_gain_alone() {
        let mut model = model(0.0);
        let of = |model: &Model| steady_gain_error(model, &model.pairs[0], &model.pairs[0].classes["all"]);
        assert!((of(&model) - 0.1).abs() < 1e-9);
        let whiteness = Whiteness { autocorrelation: vec![0.8], q: 1e4, p_value: 0.0, inflation: 3.0 };
        model.outputs[0].whiteness = Some(whiteness);
        assert!((of(&model) - 0.3).abs() < 1e-9);
        model.pairs[0].classes.get_mut("all").unwrap().se_steady_gain_k_per_w = libm::hypot(0.1, 2.0);
        assert!((of(&model) - libm::hypot(0.3, 2.0)).abs() < 1e-9);
    }
}
