//! Which set-point, and between which levels: low below and high above the power of every wind.

use super::Wish;
use crate::predict::reaching::reaching_time_s;
use crate::predict::windy::Windy;

/// How far the levels that are recommended lie beyond the powers that a change asks for.
pub const BEYOND_BELOW: f64 = 0.95;
pub const BEYOND_ABOVE: f64 = 1.05;

/// A wind's label and its u_Q in W for a rise over the first wind's temperature without heating.
fn powers(winds: &[Windy], rise_k: f64) -> impl Iterator<Item = (&str, f64)> {
    let target_c = winds[0].unheated_c + rise_k;
    winds
        .iter()
        .map(move |windy| (windy.label.as_str(), (target_c - windy.unheated_c) / windy.plane.steady_gain_k_per_w()))
}

/// The winds that take least and most, and how much, W.
fn extremes(winds: &[Windy], rise_k: f64) -> [(&str, f64); 2] {
    let first = (winds[0].label.as_str(), f64::NAN);
    let least = powers(winds, rise_k).min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or(first);
    let most = powers(winds, rise_k).max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or(first);
    [least, most]
}

/// Why the given levels cannot hold a rise; nothing if they can.
fn objection(winds: &[Windy], wish: &Wish, rise_k: f64) -> Option<String> {
    let [(calm, least_w), (strong, most_w)] = extremes(winds, rise_k);
    let (low_w, high_w) = (least_w * (1.0 - wish.margin), most_w * (1.0 + wish.margin));
    if least_w <= 0.0 {
        return Some(format!("in `{calm}` it is no warmer than without heating, and a heater cannot cool"));
    }
    if let Some(given_w) = wish.power_low_w.filter(|given_w| *given_w > low_w) {
        return Some(format!(
            "in `{calm}` it takes {least_w:.5} W, and the low level of {given_w} W leaves less than {} % of that: it must be {low_w:.5} W or less",
            100.0 * wish.margin
        ));
    }
    if let Some(given_w) = wish.power_high_w.filter(|given_w| *given_w < high_w) {
        return Some(format!(
            "in `{strong}` it takes {most_w:.5} W, and the high level of {given_w} W leaves less than {} % beyond: it must be {high_w:.5} W or more",
            100.0 * wish.margin
        ));
    }
    None
}

/// The rises in K that the given levels hold in every wind, the lowest exclusive where no low level is given.
///
/// u_Q = (ΔT + T_0 − T_w)/ΣR grows with ΔT by a straight line in every wind, so that they are one interval.
fn held_k(winds: &[Windy], wish: &Wish) -> (f64, f64) {
    let reference_c = winds[0].unheated_c;
    winds.iter().fold((0.0, f64::INFINITY), |(least_k, most_k), windy| {
        let rise_k = |power_w: f64| power_w * windy.plane.steady_gain_k_per_w() + windy.unheated_c - reference_c;
        let low_w = wish.power_low_w.map_or(0.0, |low_w| low_w / (1.0 - wish.margin));
        let high_w = wish.power_high_w.map_or(f64::INFINITY, |high_w| high_w / (1.0 + wish.margin));
        (f64::max(least_k, rise_k(low_w)), f64::min(most_k, rise_k(high_w)))
    })
}

/// The highest rise in K of those that would do.
///
/// # Errors
/// If the given levels can hold none of them: what is in the way of the highest, and which rise they could hold.
pub fn set_point(winds: &[Windy], wish: &Wish, reasons: &mut Vec<String>) -> Result<f64, String> {
    let (lowest_k, highest_k) = wish.rise_k;
    let (least_k, most_k) = held_k(winds, wish);
    // The rounding of an end is no objection.
    let near = 1e-12 * highest_k;
    let rise_k = highest_k.min(most_k);
    let needs_heat = wish.power_low_w.unwrap_or(0.0) > 0.0 || rise_k > least_k;
    if rise_k < lowest_k - near || rise_k < least_k - near || !needs_heat {
        let why = objection(winds, wish, highest_k).unwrap_or_default();
        let could = if least_k < most_k && most_k < f64::INFINITY {
            format!("; the given levels hold {least_k:.3} to {most_k:.3} K")
        } else if least_k < most_k {
            format!("; the given low level holds {least_k:.3} K and more")
        } else {
            String::new()
        };
        return Err(format!("{highest_k} K cannot be held: {why}{could}"));
    }
    reasons.push(if lowest_k == highest_k {
        format!("set-point: {rise_k} K, as wished")
    } else if rise_k == highest_k {
        format!("set-point: {rise_k} K, the highest of those wished, as what the wind takes grows with it and the swing does not")
    } else {
        format!("set-point: {rise_k:.4} K, the highest of those wished that the given levels hold in every wind")
    });
    Ok(rise_k)
}

/// Low and high level in W: those given, or those that the margin, the reaching time and changes of the wind ask for.
///
/// `asked_w` is the least and the most power that a change of the wind asks for at any time, where a response is wished.
///
/// # Errors
/// If the set-point is not reached in time.
pub fn levels(
    winds: &[Windy],
    wish: &Wish,
    rise_k: f64,
    asked_w: Option<(f64, f64)>,
    reasons: &mut Vec<String>,
) -> Result<(f64, f64), String> {
    let [(calm, least_w), (strong, most_w)] = extremes(winds, rise_k);
    let percent = 100.0 * wish.margin;
    let below_w = asked_w.map_or(f64::INFINITY, |(least_w, _)| BEYOND_BELOW * least_w).max(0.0);
    let low_w = wish.power_low_w.unwrap_or((least_w * (1.0 - wish.margin)).min(below_w));
    reasons.push(match wish.power_low_w {
        Some(_) => format!("low level: as given, below the {least_w:.5} W that `{calm}` takes"),
        None if low_w == below_w => format!(
            "low level: {low_w:.5} W, below the least power that a change of the wind asks for; {percent} % below the {least_w:.5} W that `{calm}` takes would hold the set-point"
        ),
        None => format!(
            "low level: {low_w:.5} W, {percent} % below the {least_w:.5} W that `{calm}` takes, the least of all winds"
        ),
    });
    let by_margin_w = most_w * (1.0 + wish.margin);
    let above_w = asked_w.map_or(0.0, |(_, most_w)| BEYOND_ABOVE * most_w);
    let target_c = winds[0].unheated_c + rise_k;
    let slowest_s = |high_w: f64| {
        let times = winds.iter().map(|windy| reaching_time_s(&windy.plane, target_c - windy.unheated_c, high_w));
        times.fold(0.0_f64, |worst, time_s| worst.max(time_s.unwrap_or(f64::INFINITY)))
    };
    let mut high_w = wish.power_high_w.unwrap_or(by_margin_w.max(above_w));
    let mut reason = match wish.power_high_w {
        Some(_) => format!("high level: as given, above the {most_w:.5} W that `{strong}` takes"),
        None if high_w == above_w => format!(
            "high level: {high_w:.5} W, above the most power that a change of the wind asks for; {by_margin_w:.5} W would hold the set-point"
        ),
        None => format!(
            "high level: {high_w:.5} W, {percent} % above the {most_w:.5} W that `{strong}` takes, the most of all winds"
        ),
    };
    if let Some(reach_s) = wish.reach_s.filter(|reach_s| slowest_s(high_w) > *reach_s) {
        let needed_w = least_power_w(&slowest_s, high_w, reach_s)
            .ok_or_else(|| format!("{rise_k} K cannot be reached in {reach_s} s by any power"))?;
        if let Some(given_w) = wish.power_high_w {
            return Err(format!(
                "{rise_k} K is not reached in {reach_s} s: the high level of {given_w} W takes {:.3} s; it must be {needed_w:.5} W or more",
                slowest_s(given_w)
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
