//! Time for which a loop is under one level before it meets its set-point.
//!
//! Under a level P the rise is y(t) = Σ z_k + Σ (R_k P − z_k)(1 − e^(−ξ_k t)), from rest Σ R_k P (1
//! − e^(−ξ_k t)), and the set-point is met at y(t) = ΔT. The loop looks once a sample period, so it
//! notices at the first tick at or after that.

use dr_core::model::mesh;
use dr_core::sensor::Level;

use super::sliding_surface::SlidingSurface;

/// By which the search steps before it halves: a symbol of both signs could pass the set-point and
/// return between two steps.
const STEP: f64 = 1.02;
/// Where it begins, in time constants of the fastest pole, and where it ends, in those of the
/// slowest.
const FIRST: f64 = 1e-6;
const LAST: f64 = 40.0;

/// t_c from rest in s, to rounding; `None` if this power does not lift it so far. `rise_k` is ΔT
/// over the temperature without heating.
pub fn reaching_time_s(surface: &SlidingSurface, rise_k: f64, power_high_w: f64) -> Option<f64> {
    if rise_k <= 0.0 {
        return Some(0.0);
    }
    meeting_s(surface, &vec![0.0; surface.order()], -rise_k, (Level::High, power_high_w))
}

/// The same where losses grow with temperature, and the states in K that it is met with, from rest:
/// by steps of a fraction of `at_least_s`, the time without them, with the loss of the middle of
/// each step. `None` if it is not met in a thousand times that.
pub fn with_losses(
    surface: &SlidingSurface,
    rise_k: f64,
    power_w: f64,
    loss_w_per_k2: f64,
    at_least_s: f64,
) -> Option<(f64, Vec<f64>)> {
    const STEPS: f64 = 500.0;
    let step_s = at_least_s / STEPS;
    let gains = [0.5 * step_s, step_s]
        .map(|time_s| surface.rates_rad_s.iter().map(|&rate| mesh::gain(rate, time_s)).collect::<Vec<_>>());
    let mut z = vec![0.0; surface.order()];
    let moved = |z: &[f64], gain: &[f64], y: f64| -> Vec<f64> {
        let left_w = power_w - loss_w_per_k2 * y * y;
        z.iter().zip(gain).zip(&surface.r_k_per_w).map(|((z, gain), r)| z + gain * (r * left_w - z)).collect()
    };
    for n in 0..(1e3 * STEPS) as u32 {
        let now: f64 = z.iter().sum();
        let middle: f64 = moved(&z, &gains[0], now).iter().sum();
        let next = moved(&z, &gains[1], middle);
        let then: f64 = next.iter().sum();
        if then >= rise_k {
            let part = (rise_k - now) / (then - now);
            let met = z.iter().zip(&next).map(|(z, next)| z + part * (next - z)).collect();
            return Some(((f64::from(n) + part) * step_s, met));
        }
        z = next;
    }
    None
}

/// When states z_k in K that are `above_k` over the set-point meet it under a level of a power in
/// W, in s and to rounding; `None` if never.
///
/// From below it is met under the high level, from above under the low one. States on the set-point
/// (`above_k` = 0) have to leave it first, to the side from which the level leads back. A level
/// that in the end would not hold them there never does.
pub fn meeting_s(
    surface: &SlidingSurface,
    weighted_k: &[f64],
    above_k: f64,
    (level, power_w): (Level, f64),
) -> Option<f64> {
    let side = match level {
        Level::High => 1.0,
        Level::Low => -1.0,
    };
    // Distance on the other side.
    let short_k = |time_s: f64| -> f64 {
        let poles = surface.rates_rad_s.iter().zip(&surface.r_k_per_w).zip(weighted_k);
        let moved: f64 = poles.map(|((&rate, r), z)| (r * power_w - z) * mesh::gain(rate, time_s)).sum();
        -side * (above_k + moved)
    };
    let finally_k = above_k + surface.steady_gain_k_per_w * power_w - weighted_k.iter().sum::<f64>();
    if side * finally_k <= 0.0 {
        return None;
    }
    let (slowest, fastest) = (surface.rates_rad_s[0], surface.rates_rad_s[surface.order() - 1]);
    let (mut from_s, mut to_s) = (0.0, FIRST / fastest);
    if above_k == 0.0 && short_k(to_s) <= 0.0 {
        return Some(0.0);
    }
    while short_k(to_s) > 0.0 {
        if to_s > LAST / slowest {
            return None;
        }
        (from_s, to_s) = (to_s, STEP * to_s);
    }
    loop {
        let middle_s = f64::midpoint(from_s, to_s);
        if middle_s <= from_s || middle_s >= to_s {
            return Some(to_s);
        }
        if short_k(middle_s) > 0.0 { from_s = middle_s } else { to_s = middle_s }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_pole_takes_the_logarithm_of_what_is_left() {
        let surface = SlidingSurface::new(&[0.25], &[500.0]).unwrap();
        let exact_s = -libm::log(1.0 - 10.0 / (500.0 * 0.04_f64)) / 0.25;
        // a few roundings of the rise, over its slope
        assert!((reaching_time_s(&surface, 10.0, 0.04).unwrap() / exact_s - 1.0).abs() < 1e-14);
    }

    #[test]
    fn what_is_out_of_reach_has_no_reaching_time() {
        let surface = SlidingSurface::new(&[0.25, 4.0], &[400.0, 100.0]).unwrap();
        assert_eq!(reaching_time_s(&surface, 20.0, 0.04), None);
        assert_eq!(reaching_time_s(&surface, 30.0, 0.04), None);
        assert_eq!(reaching_time_s(&surface, 1.0, 0.0), None);
        assert_eq!(reaching_time_s(&surface, 0.0, 0.04), Some(0.0));
        assert!(reaching_time_s(&surface, 20.0 * (1.0 - 1e-12), 0.04).unwrap() > 80.0);
    }

    #[test]
    fn states_of_another_wind_leave_the_set_point_and_come_back() {
        // A slow and a fast pole, 1 K on the slow one too much and on the fast one too little: y −
        // ΔT = −e^(−0.1t) + e^(−10t) + 0.9 …
        let surface = SlidingSurface::new(&[0.1, 10.0], &[10.0, 10.0]).unwrap();
        let (z, power_w) = ([4.0, 6.0], 0.55);
        let met_s = meeting_s(&surface, &z, 0.0, (Level::High, power_w)).unwrap();
        // 5.5 − 1.5 e^(−0.1t) + 5.5 + 0.5 e^(−10t) = 10: the fast pole has ended long before.
        let exact_s = 10.0 * libm::log(1.5);
        assert!((met_s / exact_s - 1.0).abs() < 1e-12, "{met_s} {exact_s}");
        // From above there is no way back under a low level that is too warm.
        assert_eq!(meeting_s(&surface, &z, 1.0, (Level::Low, 0.55)), None);
        assert!(meeting_s(&surface, &z, 1.0, (Level::Low, 0.40)).is_some());
    }
}
