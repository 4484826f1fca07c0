//! Sliding surface: set-points that a closed loop can reach, and its equivalent control, from an
//! open-loop model (thesis 2.42–2.51).
//!
//! The loop switches between P_off and P_on by the sign of σ = ΔT − y. Sampled infinitely fast it
//! keeps σ = 0, and its mean power is the equivalent control. With z_k = R_k x_k, the share of pole
//! k in the temperature rise in K:
//!
//! | quantity | definition | unit |
//! |---|---|---|
//! | reachable (2.42–2.43) | P_off ΣR_k < ΔT < P_on ΣR_k | |
//! | steady state (2.51) | u_Q = ΔT / ΣR_k | W |
//! | equivalent control (2.49) | u_eq = Σ ξ_k z_k / Γ, with Γ = Σ ξ_k R_k | W |
//! | sliding (2.47) | P_off < u_eq < P_on while σ = 0 | |
//!
//! Exact for a linear model; wind lowers ΣR_k, so that a model of quiescent gas holds in quiescent
//! gas only. Γ must be greater than zero: otherwise heating does not begin by warming, and there is
//! no surface on which the loop could slide. What makes a model checks that.
//!
//! Board and host call the same functions, in f32 and in f64.

use super::real::Real;

/// Verdict on a rise between two levels, and its margin.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Reachability<R = f32> {
    /// It can be held.
    Reachable {
        /// Mean power that holds it, W.
        steady_power_w: R,
    },
    /// Even the low level ends above the set-point.
    LowLevelTooWarm {
        /// Rise in K that the low level ends at.
        least_rise_k: R,
    },
    /// The high level ends below the set-point.
    HighLevelTooCold {
        /// Rise in K that the high level ends at.
        most_rise_k: R,
    },
}

/// Judges a rise of `rise_k` over the reference for a model of `steady_gain_k_per_w` between two
/// levels in W.
///
/// A set-point on a bound counts as out of reach: the loop would only creep towards it.
pub fn reachability<R: Real>(steady_gain_k_per_w: R, rise_k: R, power_low_w: R, power_high_w: R) -> Reachability<R> {
    let least_rise_k = power_low_w * steady_gain_k_per_w;
    let most_rise_k = power_high_w * steady_gain_k_per_w;
    if rise_k <= least_rise_k {
        Reachability::LowLevelTooWarm { least_rise_k }
    } else if rise_k < most_rise_k {
        Reachability::Reachable { steady_power_w: rise_k / steady_gain_k_per_w }
    } else {
        Reachability::HighLevelTooCold { most_rise_k }
    }
}

/// u_eq = Σ ξ_k z_k / Γ (thesis 2.49) in W: the power that, held, would keep the rise as it is at
/// this moment.
///
/// `rates_rad_s` are ξ_k, `weighted_k` the states z_k = R_k x_k in K, of equal number;
/// `high_frequency_gain_k_per_j` is Γ and greater than zero. Summed in the order of the rates:
/// relative rounding is under K ulp where all z_k ≥ 0. Divides once.
#[inline]
pub fn equivalent_control<R: Real>(rates_rad_s: &[R], weighted_k: &[R], high_frequency_gain_k_per_j: R) -> R {
    let mut falling_k_per_s = R::ZERO;
    for (rate, z) in rates_rad_s.iter().zip(weighted_k) {
        falling_k_per_s = falling_k_per_s + *rate * *z;
    }
    falling_k_per_s / high_frequency_gain_k_per_j
}

/// Distance of the equivalent control from either level: (u_eq − P_off, P_on − u_eq) in W. The loop
/// slides while both are greater than zero (thesis 2.47).
#[inline]
pub fn sliding_margins_w<R: Real>(equivalent_w: R, power_low_w: R, power_high_w: R) -> (R, R) {
    (equivalent_w - power_low_w, power_high_w - equivalent_w)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn in_steady_state_the_equivalent_control_is_the_power_that_is_there() {
        let (rates, resistances) = ([0.05_f64, 0.4, 3.0, 25.0], [30.0, 8.0, 2.5, 0.4]);
        let gamma = rates.iter().zip(resistances).map(|(rate, r)| rate * r).sum::<f64>();
        let weighted = resistances.map(|r| 0.02 * r);
        // four products and sums of positive numbers
        assert!((equivalent_control(&rates, &weighted, gamma) / 0.02 - 1.0).abs() < 1e-15);
        let single = weighted.map(|z| z as f32);
        let found = equivalent_control(&rates.map(|rate| rate as f32), &single, gamma as f32);
        assert!((found / 0.02 - 1.0).abs() < 4e-7);
    }

    #[test]
    fn margins_are_counted_from_both_levels() {
        assert_eq!(sliding_margins_w(3.0, 1.0, 7.0), (2.0, 4.0));
        assert!(sliding_margins_w(0.5_f32, 1.0, 7.0).0 < 0.0);
    }

    #[test]
    fn the_interval_is_open_at_both_ends() {
        let judge = |rise_k| reachability(500.0_f32, rise_k, 0.001, 0.04);
        assert_eq!(judge(0.5), Reachability::LowLevelTooWarm { least_rise_k: 0.5 });
        assert_eq!(judge(10.0), Reachability::Reachable { steady_power_w: 0.02 });
        assert_eq!(judge(20.0), Reachability::HighLevelTooCold { most_rise_k: 20.0 });
        assert_eq!(judge(25.0), Reachability::HighLevelTooCold { most_rise_k: 20.0 });
    }

    #[test]
    fn a_model_that_is_no_number_is_never_reachable() {
        assert!(!matches!(reachability(f32::NAN, 10.0, 0.001, 0.04), Reachability::Reachable { .. }));
    }
}
