//! Standard deviation of the direction by the estimator of Yamartino.
//!
//! With s and c the means of sine and cosine of the direction, ε = (1 − s² − c²)^½:
//!
//! σ_θ = asin ε (1 + (2/√3 − 1) ε³)
//!
//! Source: R. J. Yamartino, A comparison of several "single-pass" estimators of the standard
//! deviation of wind direction, J. Climate Appl. Meteor. 23 (1984) 1362–1366. Within 2 % of the
//! standard deviation of a normal distribution up to 60°; of directions all around it is 104°.

/// Standard deviation of directions, °; none of no direction.
pub fn standard_deviation_deg(from_deg: impl Iterator<Item = f64>) -> Option<f64> {
    let (mut sine, mut cosine, mut count) = (0.0, 0.0, 0_u32);
    for direction in from_deg {
        let (sin, cos) = direction.to_radians().sin_cos();
        (sine, cosine, count) = (sine + sin, cosine + cos, count + 1);
    }
    if count == 0 {
        return None;
    }
    let (sine, cosine) = (sine / f64::from(count), cosine / f64::from(count));
    // Rounding may take the square of a steady direction below 0.
    let epsilon = (1.0 - sine * sine - cosine * cosine).clamp(0.0, 1.0).sqrt();
    Some((epsilon.asin() * (1.0 + (2.0 / 3.0_f64.sqrt() - 1.0) * epsilon.powi(3))).to_degrees())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, Normal};

    #[test]
    fn a_normal_distribution_about_north_has_its_own_standard_deviation() {
        for (seed, sd_deg) in [(1, 5.0), (2, 20.0), (3, 40.0), (4, 60.0)] {
            let normal = Normal::<f64>::new(0.0, sd_deg).unwrap();
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let directions = (0..40_000).map(|_| normal.sample(&mut random).rem_euclid(360.0));
            let found = standard_deviation_deg(directions).unwrap();
            // Yamartino's own 2 %, and 0.35 % by 40 000 samples.
            assert!((found / sd_deg - 1.0).abs() < 0.025, "{found} is not {sd_deg}");
        }
    }

    #[test]
    fn a_steady_direction_has_none_and_all_directions_have_104_degrees() {
        assert!(standard_deviation_deg([350.0; 7].into_iter()).unwrap() < 1e-5);
        let around = standard_deviation_deg((0..360).map(f64::from)).unwrap();
        assert!((around - 90.0 * 2.0 / 3.0_f64.sqrt()).abs() < 1e-6, "{around}");
        assert_eq!(standard_deviation_deg(std::iter::empty()), None);
    }
}
