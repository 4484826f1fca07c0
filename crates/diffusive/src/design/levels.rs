//! Set-point and levels: low below and high above the power of every wind.

use super::Requirements;
use crate::model::ModelError;
use crate::predict::loop_model::LoopModel;
use crate::predict::reaching::reaching_time_s;

/// Distance by which the levels that are recommended lie beyond the powers that a change needs.
pub const BEYOND_BELOW: f64 = 0.95;
pub const BEYOND_ABOVE: f64 = 1.05;

/// A wind's label and its u_Q in W for a rise over the first wind's temperature without heating.
fn powers(winds: &[LoopModel], rise_k: f64) -> impl Iterator<Item = (&str, f64)> {
    let target_c = winds[0].unheated_c + rise_k;
    winds.iter().map(move |loop_model| {
        (loop_model.label.as_str(), (target_c - loop_model.unheated_c) / loop_model.surface.steady_gain_k_per_w)
    })
}

/// The winds that take least and most, and how much, W.
fn extremes(winds: &[LoopModel], rise_k: f64) -> [(&str, f64); 2] {
    let first = (winds[0].label.as_str(), f64::NAN);
    let least = powers(winds, rise_k).min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or(first);
    let most = powers(winds, rise_k).max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or(first);
    [least, most]
}

/// Why the given levels cannot hold a rise; empty if they can.
fn objection(winds: &[LoopModel], wanted: &Requirements, rise_k: f64) -> String {
    let [(calm, least_w), (strong, most_w)] = extremes(winds, rise_k);
    let (low_w, high_w) = (least_w * (1.0 - wanted.margin), most_w * (1.0 + wanted.margin));
    let percent = 100.0 * wanted.margin;
    if least_w <= 0.0 {
        return format!("in `{calm}` it is no warmer than without heating, and a heater cannot cool");
    }
    match (wanted.power_low_w, wanted.power_high_w) {
        (Some(given_w), _) if given_w > low_w => format!(
            "in `{calm}` it takes {least_w:.5} W, and the low level of {given_w} W leaves less than {percent} % of that: it must be {low_w:.5} W or less"
        ),
        (_, Some(given_w)) if given_w < high_w => format!(
            "in `{strong}` it takes {most_w:.5} W, and the high level of {given_w} W leaves less than {percent} % beyond: it must be {high_w:.5} W or more"
        ),
        _ => String::new(),
    }
}

/// The rises in K that the given levels hold in every wind, the lowest exclusive where no low level
/// is given.
///
/// u_Q = (ΔT + T_0 − T_w)/ΣR grows with ΔT by a straight line in every wind, so that they are one
/// interval.
fn held_k(winds: &[LoopModel], wanted: &Requirements) -> (f64, f64) {
    let reference_c = winds[0].unheated_c;
    winds.iter().fold((0.0, f64::INFINITY), |(least_k, most_k), loop_model| {
        let rise_k =
            |power_w: f64| power_w * loop_model.surface.steady_gain_k_per_w + loop_model.unheated_c - reference_c;
        let low_w = wanted.power_low_w.map_or(0.0, |low_w| low_w / (1.0 - wanted.margin));
        let high_w = wanted.power_high_w.map_or(f64::INFINITY, |high_w| high_w / (1.0 + wanted.margin));
        (f64::max(least_k, rise_k(low_w)), f64::min(most_k, rise_k(high_w)))
    })
}

/// The highest rise in K of those that would do.
///
/// # Errors
/// If the given levels can hold none of them: what is in the way of the highest, and which rise
/// they could hold.
pub fn set_point(winds: &[LoopModel], wanted: &Requirements, reasons: &mut Vec<String>) -> Result<f64, ModelError> {
    let (lowest_k, highest_k) = wanted.rise_k;
    let (least_k, most_k) = held_k(winds, wanted);
    // The rounding of an end is no objection.
    let near = 1e-12 * highest_k;
    let rise_k = highest_k.min(most_k);
    let needs_heat = wanted.power_low_w.unwrap_or(0.0) > 0.0 || rise_k > least_k;
    if rise_k < lowest_k - near || rise_k < least_k - near || !needs_heat {
        let could = match (least_k < most_k, most_k < f64::INFINITY) {
            (true, true) => format!("; the given levels hold {least_k:.3} to {most_k:.3} K"),
            (true, false) => format!("; the given low level holds {least_k:.3} K and more"),
            (false, _) => String::new(),
        };
        return Err(model_error!("{highest_k} K cannot be held: {}{could}", objection(winds, wanted, highest_k)));
    }
    reasons.push(if lowest_k == highest_k {
        format!("set-point: {rise_k} K, as required")
    } else if rise_k == highest_k {
        format!("set-point: {rise_k} K, the highest of those required, as what the wind takes grows with it and the swing does not")
    } else {
        format!("set-point: {rise_k:.4} K, the highest of those required that the given levels hold in every wind")
    });
    Ok(rise_k)
}

/// Low and high level in W: those given, or those that the margin, the reaching time and changes of
/// the wind need.
///
/// `needed_range_w` is the least and the most power that a change of the wind needs at any time,
/// where a response is required.
///
/// # Errors
/// If the set-point is not reached in time.
pub fn levels(
    winds: &[LoopModel],
    wanted: &Requirements,
    rise_k: f64,
    needed_range_w: Option<(f64, f64)>,
    reasons: &mut Vec<String>,
) -> Result<(f64, f64), ModelError> {
    let [(calm, least_w), (strong, most_w)] = extremes(winds, rise_k);
    let percent = 100.0 * wanted.margin;
    let below_w = needed_range_w.map_or(f64::INFINITY, |(least_w, _)| BEYOND_BELOW * least_w).max(0.0);
    let low_w = wanted.power_low_w.unwrap_or((least_w * (1.0 - wanted.margin)).min(below_w));
    reasons.push(match wanted.power_low_w {
        Some(_) => format!("low level: as given, below the {least_w:.5} W that `{calm}` takes"),
        None if low_w == below_w => format!(
            "low level: {low_w:.5} W, below the least power that a change of the wind needs; {percent} % below the {least_w:.5} W that `{calm}` takes would hold the set-point"
        ),
        None => format!(
            "low level: {low_w:.5} W, {percent} % below the {least_w:.5} W that `{calm}` takes, the least of all winds"
        ),
    });
    let by_margin_w = most_w * (1.0 + wanted.margin);
    let above_w = needed_range_w.map_or(0.0, |(_, most_w)| BEYOND_ABOVE * most_w);
    let target_c = winds[0].unheated_c + rise_k;
    let slowest_s = |high_w: f64| {
        let times = winds
            .iter()
            .map(|loop_model| reaching_time_s(&loop_model.surface, target_c - loop_model.unheated_c, high_w));
        times.fold(0.0_f64, |worst, time_s| worst.max(time_s.unwrap_or(f64::INFINITY)))
    };
    let mut high_w = wanted.power_high_w.unwrap_or(by_margin_w.max(above_w));
    let mut reason = match wanted.power_high_w {
        Some(_) => format!("high level: as given, above the {most_w:.5} W that `{strong}` takes"),
        None if high_w == above_w => format!(
            "high level: {high_w:.5} W, above the most power that a change of the wind needs; {by_margin_w:.5} W would hold the set-point"
        ),
        None => format!(
            "high level: {high_w:.5} W, {percent} % above the {most_w:.5} W that `{strong}` takes, the most of all winds"
        ),
    };
    if let Some(reach_s) = wanted.reach_s.filter(|reach_s| slowest_s(high_w) > *reach_s) {
        let needed_w = least_power_w(&slowest_s, high_w, reach_s)
            .ok_or_else(|| model_error!("{rise_k} K cannot be reached in {reach_s} s by any power"))?;
        if let Some(given_w) = wanted.power_high_w {
            let takes_s = slowest_s(given_w);
            return Err(model_error!(
                "{rise_k} K is not reached in {reach_s} s: the high level of {given_w} W takes {takes_s:.3} s; it must be {needed_w:.5} W or more"
            ));
        }
        high_w = needed_w;
        reason = format!(
            "high level: {high_w:.5} W, to reach the set-point from rest in {reach_s} s in every wind; {by_margin_w:.5} W would hold it"
        );
    }
    reasons.push(reason);
    Ok((low_w, high_w))
}

/// The least power that reaches the set-point in time, W, to one part in 10⁴ and on the safe side.
fn least_power_w(slowest_s: &dyn Fn(f64) -> f64, from_w: f64, reach_s: f64) -> Option<f64> {
    let (mut below_w, mut above_w) = (from_w, 2.0 * from_w);
    while slowest_s(above_w) > reach_s {
        (below_w, above_w) = (above_w, 2.0 * above_w);
        if above_w > 1e6 * from_w {
            return None;
        }
    }
    while above_w / below_w > 1.0001 {
        let middle_w = f64::midpoint(below_w, above_w);
        if slowest_s(middle_w) > reach_s { below_w = middle_w } else { above_w = middle_w }
    }
    Some(above_w)
}
