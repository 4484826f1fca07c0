//! The logarithmic grid of relaxation rates (diffusive mesh), thesis (2.11).
//!
//! ξ_{k+1} = r ξ_k with r = (ξ_K/ξ_1)^{1/(K−1)}, rates in rad/s, ascending. Edges after the thesis:
//! ξ_1 = 2πJ/T and ξ_K = π/Ts with T the duration of the experiment, J its number of event classes
//! and Ts the sample period.
//!
//! Worked out in f64 by `libm` where a configuration is made, so that host and board agree to the
//! bit.

use crate::error::{ConfigError, Parameter, ParameterProblem};

/// The mesh's edges for an experiment, rad/s: (2πJ/T, π/Ts).
pub fn thesis_edges_rad_s(duration_s: f64, sample_period_s: f64, event_classes: u32) -> (f64, f64) {
    (core::f64::consts::TAU * f64::from(event_classes) / duration_s, core::f64::consts::PI / sample_period_s)
}

/// Rate number `k` (from 0) of a mesh of `order` rates from `first_rad_s` to `last_rad_s`, both
/// included.
pub fn rate_rad_s(first_rad_s: f64, last_rad_s: f64, k: usize, order: usize) -> f64 {
    if k == 0 {
        first_rad_s
    } else if k + 1 >= order {
        last_rad_s
    } else {
        first_rad_s * libm::pow(last_rad_s / first_rad_s, k as f64 / (order - 1) as f64)
    }
}

/// A mesh of K rates in rad/s.
///
/// # Errors
/// If an edge is not a finite number greater than zero, or the last does not lie above the first
/// (for K = 1: below it).
pub fn geometric<const K: usize>(first_rad_s: f32, last_rad_s: f32) -> Result<[f32; K], ConfigError> {
    let mut rates = [0.0; K];
    for (k, rate) in rates.iter_mut().enumerate() {
        *rate = rate_rad_s(f64::from(first_rad_s), f64::from(last_rad_s), k, K) as f32;
    }
    if K == 1 && last_rad_s < first_rad_s {
        return Err(ConfigError { parameter: Parameter::RateRadS, problem: ParameterProblem::NotAscending });
    }
    check(&rates)?;
    Ok(rates)
}

/// Rates must be finite, greater than zero and ascending.
pub(crate) fn check(rates_rad_s: &[f32]) -> Result<(), ConfigError> {
    let mut before = 0.0;
    for &rate in rates_rad_s {
        crate::error::positive(Parameter::RateRadS, rate)?;
        if rate <= before {
            return Err(ConfigError { parameter: Parameter::RateRadS, problem: ParameterProblem::NotAscending });
        }
        before = rate;
    }
    Ok(())
}

/// The share of the way to its goal that a relaxation of `rate_rad_s` goes in `time_s`: g = 1 −
/// e^(−ξt), by expm1.
///
/// Never worked out as `1 − exp`: for ξt = 3e-6 that leaves two digits in f32.
pub fn gain(rate_rad_s: f64, time_s: f64) -> f64 {
    -libm::expm1(-rate_rad_s * time_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_geometric_between_the_edges_of_the_thesis() {
        let (first, last) = thesis_edges_rad_s(1000.0, 0.01, 1);
        let mesh = geometric::<8>(first as f32, last as f32).unwrap();
        assert!((mesh[0] - 6.283_185_5e-3).abs() < 1e-9);
        assert!((mesh[7] - 314.159_27).abs() < 1e-4);
        let ratio = libm::pow(last / first, 1.0 / 7.0);
        for k in 0..7 {
            // two f32 roundings
            assert!((f64::from(mesh[k + 1]) / f64::from(mesh[k]) / ratio - 1.0).abs() < 1.2e-7);
        }
    }

    #[test]
    fn event_classes_raise_the_lower_edge() {
        let (one, three) = (thesis_edges_rad_s(100.0, 0.1, 1).0, thesis_edges_rad_s(100.0, 0.1, 3).0);
        assert!((three / one - 3.0).abs() < 1e-15);
    }

    #[test]
    fn refuses_edges_that_are_no_interval() {
        assert!(geometric::<4>(0.0, 1.0).is_err());
        assert!(geometric::<4>(2.0, 1.0).is_err());
        assert!(geometric::<4>(1.0, 1.0).is_err());
        assert!(geometric::<4>(f32::NAN, 1.0).is_err());
        assert!(geometric::<4>(1.0, f32::INFINITY).is_err());
        assert!(geometric::<1>(2.0, 1.0).is_err());
        assert_eq!(geometric::<1>(1.0, 1.0).unwrap(), [1.0]);
    }

    #[test]
    fn small_gains_keep_all_their_digits() {
        // Taylor: 1 − e^−z = z − z²/2 + z³/6
        let z = 3e-6;
        assert!((gain(z, 1.0) / (z - z * z / 2.0 + z * z * z / 6.0) - 1.0).abs() < 1e-15);
    }
}
