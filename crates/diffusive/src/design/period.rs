//! Interval at which the loop must look: the longest period at which the temperature swings by no
//! more than is allowed.
//!
//! The swing from peak to peak is S (P_high − P_low) with S = Σ R_k (1 − e^(−ξ_k Ts)), about Γ
//! (P_high − P_low) Ts ([`chatter`](crate::predict::chatter)). It grows with Ts, so that periods of
//! 1, 2, 5 times a power of ten are tried from above.

use crate::model::ModelError;
use crate::predict::chatter::chatter;
use crate::predict::loop_model::LoopModel;

/// The longest and the shortest period of an experiment, s.
pub const LONGEST_S: f64 = 0.1;
pub const SHORTEST_S: f64 = 0.001;

const PERIODS_S: [f64; 7] = [LONGEST_S, 0.05, 0.02, 0.01, 0.005, 0.002, SHORTEST_S];

/// The largest swing of all winds, K.
fn swing_k(winds: &[LoopModel], range_w: f64, period_s: f64) -> f64 {
    let swings =
        winds.iter().map(|loop_model| chatter(&loop_model.surface, period_s, 0.0, 0.0, range_w).peak_to_peak_k());
    swings.fold(0.0, f64::max)
}

/// The longest of the round periods, at most `most_s`, at which levels `range_w` apart swing by
/// `ripple_k` or less.
///
/// # Errors
/// If even the shortest period swings further, or is longer than `most_s`.
pub fn sample_period_s(
    winds: &[LoopModel],
    range_w: f64,
    ripple_k: f64,
    most_s: f64,
    reasons: &mut Vec<String>,
) -> Result<f64, ModelError> {
    refuse_if!(
        most_s < SHORTEST_S,
        model_error!(
            "the response is too short: ten samples of the shortest period, {SHORTEST_S} s, take {} s",
            10.0 * SHORTEST_S
        )
    );
    let found = PERIODS_S.into_iter().filter(|period_s| *period_s <= most_s);
    let found = found.map(|period_s| (period_s, swing_k(winds, range_w, period_s)));
    let Some((period_s, swing_k)) = found.clone().find(|(_, swing_k)| *swing_k <= ripple_k) else {
        let least_k = swing_k(winds, range_w, SHORTEST_S);
        return Err(model_error!(
            "a swing of {ripple_k} K cannot be kept: levels {range_w:.5} W apart swing by {least_k:.4} K at {SHORTEST_S} s, the shortest period. Allow that, or bring the levels nearer (a smaller margin, fewer winds, more time to reach the set-point)"
        ));
    };
    reasons.push(format!(
        "sample period: {period_s} s, the longest at which the temperature swings by {ripple_k} K or less{}: {swing_k:.4} K",
        if most_s < LONGEST_S { " and a response has ten samples" } else { "" }
    ));
    Ok(period_s)
}
