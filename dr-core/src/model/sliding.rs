//! What a closed loop can reach, read off an open-loop model (thesis 2.42–2.43, 2.51).
//!
//! A set-point ΔT above the reference can be held only if P_off ΣR_k < ΔT < P_on ΣR_k; the power it takes is then
//! u_Q = ΔT / ΣR_k. Exact for a linear model in steady state; wind lowers ΣR_k, so that a model of still gas answers for
//! still gas.

/// Whether a rise can be held between two levels, and by which margin.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Reachability {
    /// It can be held.
    Reachable {
        /// Mean power that holds it, W.
        steady_power_w: f32,
    },
    /// Even the low level ends above the set-point.
    LowLevelTooWarm {
        /// Rise in K that the low level ends at.
        least_rise_k: f32,
    },
    /// The high level ends below the set-point.
    HighLevelTooCold {
        /// Rise in K that the high level ends at.
        most_rise_k: f32,
    },
}

/// Judges a rise of `rise_k` over the reference for a model of `steady_gain_k_per_w` between two levels in W.
///
/// A set-point on a bound counts as out of reach: the loop would only creep towards it.
pub fn reachability(steady_gain_k_per_w: f32, rise_k: f32, power_low_w: f32, power_high_w: f32) -> Reachability {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_is_open_at_both_ends() {
        let judge = |rise_k| reachability(500.0, rise_k, 0.001, 0.04);
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
