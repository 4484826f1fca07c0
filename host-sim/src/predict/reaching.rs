//! How long a loop heats before it meets its set-point.
//!
//! From rest under the high level the rise is y(t) = Σ R_k P_on (1 − e^(−ξ_k t)), and it reaches ΔT at t_c. The loop looks once a sample
//! period, so it notices at the first tick at or after t_c.

use dr_core::model::mesh;

use super::plane::Plane;

/// By which the search steps before it halves: a symbol of both signs could pass the set-point and return between two steps.
const STEP: f64 = 1.02;

/// t_c in s, to rounding; `None` if this power does not lift it so far. `rise_k` is ΔT over the temperature without heating.
pub fn reaching_time_s(plane: &Plane, rise_k: f64, power_high_w: f64) -> Option<f64> {
    let rise_at = |time_s: f64| -> f64 {
        let poles = plane.rates_rad_s().iter().zip(plane.r_k_per_w());
        power_high_w * poles.map(|(&rate, r)| r * mesh::gain(rate, time_s)).sum::<f64>()
    };
    if rise_k <= 0.0 {
        return Some(0.0);
    }
    // At the beginning the rise is as steep as Γ P_on, and 40 of the slowest time constants end it.
    let mut from_s = 0.0;
    let mut to_s = (1e-3 * rise_k / (plane.gamma_k_per_j() * power_high_w)).min(1e-3 / plane.rates_rad_s()[0]);
    let end_s = 40.0 / plane.rates_rad_s()[0];
    if !(to_s > 0.0 && power_high_w * plane.steady_gain_k_per_w() > rise_k) {
        return None;
    }
    while rise_at(to_s) < rise_k {
        if to_s > end_s {
            return None;
        }
        (from_s, to_s) = (to_s, STEP * to_s);
    }
    loop {
        let middle_s = f64::midpoint(from_s, to_s);
        if middle_s <= from_s || middle_s >= to_s {
            return Some(to_s);
        }
        if rise_at(middle_s) < rise_k { from_s = middle_s } else { to_s = middle_s }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_pole_takes_the_logarithm_of_what_is_left() {
        let plane = Plane::new(&[0.25], &[500.0]).unwrap();
        let exact_s = -(1.0 - 10.0 / (500.0 * 0.04_f64)).ln() / 0.25;
        // a few roundings of the rise, over its slope
        assert!((reaching_time_s(&plane, 10.0, 0.04).unwrap() / exact_s - 1.0).abs() < 1e-14);
    }

    #[test]
    fn what_is_out_of_reach_has_no_reaching_time() {
        let plane = Plane::new(&[0.25, 4.0], &[400.0, 100.0]).unwrap();
        assert_eq!(reaching_time_s(&plane, 20.0, 0.04), None);
        assert_eq!(reaching_time_s(&plane, 30.0, 0.04), None);
        assert_eq!(reaching_time_s(&plane, 1.0, 0.0), None);
        assert_eq!(reaching_time_s(&plane, 0.0, 0.04), Some(0.0));
        assert!(reaching_time_s(&plane, 20.0 * (1.0 - 1e-12), 0.04).unwrap() > 80.0);
    }
}
