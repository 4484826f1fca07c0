//! From a model and a wish to a loop: set-point, levels and sample period, with the reasons (`anemo design`).
//!
//! | what | by which rule |
//! |---|---|
//! | set-point | the highest of the wished ones that the levels can hold: what wind takes grows with it, and the swing does not |
//! | levels | below and above u_Q = ΔT/ΣR_k (thesis 2.51) of every wind, by a share of it |
//! | high level | besides, reaches the set-point from rest in the time allowed, in the strongest wind |
//! | both | besides, beyond what a change of the wind asks for at any time, where a response is wished |
//! | sample period | the longest of 1, 2, 5 times a power of ten at which the temperature swings by no more than wished |
//!
//! Every number is [`predict`](crate::predict)'s, in the limit of fast sampling of a linear model. What a wish asks beyond the structure
//! (a tail that no level shortens) is refused, with what could be had.

pub mod answers;
pub mod levels;
pub mod period;
pub mod trial;

use crate::predict::analysis::{Conditions, analyse};
use crate::predict::windy::Windy;

pub use trial::Trial;

/// What a loop shall do.
#[derive(Debug, Clone, PartialEq)]
pub struct Wish {
    /// Lowest and highest set-point that would do, K above the first wind's temperature without heating.
    pub rise_k: (f64, f64),
    /// Levels that are given, W.
    pub power_low_w: Option<f64>,
    pub power_high_w: Option<f64>,
    /// How far the levels shall stay from u_Q, as a share of it: between 0 and 1.
    pub margin: f64,
    /// Swing of the temperature that is allowed, from peak to peak, K.
    pub ripple_k: f64,
    /// After a change of the wind the power shall be within 2 % of the change in this time, s.
    pub response_s: Option<f64>,
    /// From rest the set-point shall be reached in this time, s.
    pub reach_s: Option<f64>,
}

/// What one wind asks of the recommended loop, and what a trial of it gave.
#[derive(Debug, Clone, PartialEq)]
pub struct InWind {
    pub label: String,
    /// u_Q, W.
    pub steady_power_w: f64,
    /// u_Q − P_low and P_high − u_Q, W.
    pub margins_w: (f64, f64),
    pub reaching_time_s: f64,
    /// Bound of the swing from peak to peak, K.
    pub chatter_k: f64,
    pub trial: Trial,
}

/// A loop that fulfils a wish.
#[derive(Debug, Clone, PartialEq)]
pub struct Design {
    pub target_c: f64,
    pub rise_k: f64,
    pub power_low_w: f64,
    pub power_high_w: f64,
    pub sample_period_s: f64,
    /// Time over which the bits are averaged for `resolution_w`, s.
    pub window_s: f64,
    /// (P_high − P_low) Ts / window: one bit more or less in a window, W.
    pub resolution_w: f64,
    /// The longest settling of the power after a change from one of the winds to another, s; `None` with one wind.
    pub settling_s: Option<f64>,
    pub winds: Vec<InWind>,
    pub reasons: Vec<String>,
}

/// Averaged over where no response was wished, s.
const WINDOW_S: f64 = 1.0;
/// Samples that a response shall have at least.
const LEAST_SAMPLES: f64 = 10.0;

/// Designs the loop of one element for winds of the same pair.
///
/// # Errors
/// A sentence: which wish cannot be met, in which wind, and what could be had.
pub fn design(winds: &[Windy], wish: &Wish) -> Result<Design, String> {
    check(winds, wish)?;
    let mut reasons = Vec::new();
    let rise_k = levels::set_point(winds, wish, &mut reasons)?;
    let target_c = winds[0].unheated_c + rise_k;
    let changes = answers::changes(winds, target_c);
    let asked_w = wish.response_s.and_then(|_| answers::asked_w(&changes));
    let (power_low_w, power_high_w) = levels::levels(winds, wish, rise_k, asked_w, &mut reasons)?;
    let settling_s = answers::settling_s(&changes, wish.response_s, (power_low_w, power_high_w), &mut reasons)?;
    let most_s = wish.response_s.map_or(period::LONGEST_S, |response_s| response_s / LEAST_SAMPLES);
    let range_w = power_high_w - power_low_w;
    let sample_period_s = period::sample_period_s(winds, range_w, wish.ripple_k, most_s, &mut reasons)?;
    let conditions = Conditions { target_c, power_low_w, power_high_w, sample_period_s };
    let in_wind = |windy: &Windy| {
        let held = analyse(windy, Some(conditions)).held.ok_or("no conditions were given")?;
        let never = || format!("in `{}` the set-point is never reached", windy.label);
        Ok(InWind {
            label: windy.label.clone(),
            steady_power_w: held.rise_k / windy.plane.steady_gain_k_per_w(),
            margins_w: held.margins_w,
            reaching_time_s: held.reaching_time_s.ok_or_else(never)?,
            chatter_k: held.chatter.ok_or_else(never)?.peak_to_peak_k(),
            trial: trial::run(windy, &conditions),
        })
    };
    let window_s = wish.response_s.unwrap_or(WINDOW_S).max(sample_period_s);
    Ok(Design {
        target_c,
        rise_k,
        power_low_w,
        power_high_w,
        sample_period_s,
        window_s,
        resolution_w: range_w * sample_period_s / window_s,
        settling_s,
        winds: winds.iter().map(in_wind).collect::<Result<_, String>>()?,
        reasons,
    })
}

fn check(winds: &[Windy], wish: &Wish) -> Result<(), String> {
    if winds.is_empty() {
        return Err("there is no wind to design for: name one class at least".to_owned());
    }
    let (least_k, most_k) = wish.rise_k;
    if !(least_k.is_finite() && most_k.is_finite() && 0.0 < least_k && least_k <= most_k) {
        let wished = if least_k == most_k { format!("{least_k}") } else { format!("{least_k}..{most_k}") };
        return Err(format!("the set-point {wished} K must be one number above zero, or two that ascend"));
    }
    if !(0.0 < wish.margin && wish.margin < 1.0) {
        return Err(format!("the margin {} must lie between 0 and 1: it is a share of the power", wish.margin));
    }
    let positive =
        [("ripple", Some(wish.ripple_k), "K"), ("response", wish.response_s, "s"), ("reach", wish.reach_s, "s")];
    for (name, value, unit) in positive {
        if value.is_some_and(|value| !(value.is_finite() && value > 0.0)) {
            return Err(format!("the {name} {} {unit} must be greater than zero", value.unwrap_or_default()));
        }
    }
    for (name, value) in [("low", wish.power_low_w), ("high", wish.power_high_w)] {
        if value.is_some_and(|value| !(value.is_finite() && value >= 0.0)) {
            return Err(format!("the {name} level {} W must not be negative", value.unwrap_or_default()));
        }
    }
    if let (Some(low_w), Some(high_w)) = (wish.power_low_w, wish.power_high_w)
        && low_w >= high_w
    {
        return Err(format!("the low level is {low_w} W and the high level {high_w} W: the high one must be above"));
    }
    let runs_away = |windy: &&Windy| analyse(windy, None).runs_away();
    winds.iter().find(runs_away).map_or(Ok(()), |windy| {
        Err(format!("class `{}` has a zero in the right half plane: no loop can hold it for long", windy.label))
    })
}

#[cfg(test)]
mod tests;
