//! Which set-point, and between which levels: low below and high above the power of every wind.

use super::Wish;
use crate::predict::reaching::reaching_time_s;
use crate::predict::windy::Windy;

/// Steps in which a range of set-points is tried, from the highest down.
const STEPS: u32 = 200;

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

/// The highest rise in K of those that would do.
///
/// # Errors
/// If the given levels can hold none of them: what is in the way of the highest, and which rise they could hold.
pub fn set_point(winds: &[Windy], wish: &Wish, reasons: &mut Vec<String>) -> Result<f64, String> {
    let (lowest_k, highest_k) = wish.rise_k;
    for step in 0..=STEPS {
        let rise_k = highest_k - (highest_k - lowest_k) * f64::from(step) / f64::from(STEPS);
        if objection(winds, wish, rise_k).is_some() {
            continue;
        }
        reasons.push(if lowest_k == highest_k {
            format!("set-point: {rise_k} K, as wished")
        } else if step == 0 {
            format!("set-point: {rise_k} K, the highest of those wished, as what the wind takes grows with it and the swing does not")
        } else {
            format!("set-point: {rise_k:.4} K, the highest of those wished that the given levels hold in every wind")
        });
        return Ok(rise_k);
    }
    let why = objection(winds, wish, highest_k).unwrap_or_default();
    // Every rise up to the double and down to a hundredth is one that could have been meant.
    let held = |share: &f64| objection(winds, wish, highest_k * share).is_none();
    let could = (1..=200).map(|percent| f64::from(percent) / 100.0).filter(held);
    let (least, most) = could.fold((f64::NAN, f64::NAN), |(least, most), share| (share.min(least), share.max(most)));
    Err(format!(
        "{highest_k} K cannot be held: {why}{}",
        if least.is_nan() {
            String::new()
        } else {
            format!("; the given levels hold {:.3} to {:.3} K", least * highest_k, most * highest_k)
        }
    ))
}

/// Low and high level in W: those given, or those that the margin and the reaching time ask for.
///
/// # Errors
/// If the set-point is not reached in time.
pub fn levels(winds: &[Windy], wish: &Wish, rise_k: f64, reasons: &mut Vec<String>) -> Result<(f64, f64), String> {
    let [(calm, least_w), (strong, most_w)] = extremes(winds, rise_k);
    let percent = 100.0 * wish.margin;
    let low_w = wish.power_low_w.unwrap_or(least_w * (1.0 - wish.margin));
    reasons.push(match wish.power_low_w {
        Some(_) => format!("low level: as given, below the {least_w:.5} W that `{calm}` takes"),
        None => format!(
            "low level: {low_w:.5} W, {percent} % below the {least_w:.5} W that `{calm}` takes, the least of all winds"
        ),
    });
    let by_margin_w = most_w * (1.0 + wish.margin);
    let target_c = winds[0].unheated_c + rise_k;
    let slowest_s = |high_w: f64| {
        let times = winds.iter().map(|windy| reaching_time_s(&windy.plane, target_c - windy.unheated_c, high_w));
        times.fold(0.0_f64, |worst, time_s| worst.max(time_s.unwrap_or(f64::INFINITY)))
    };
    let mut high_w = wish.power_high_w.unwrap_or(by_margin_w);
    let mut reason = match wish.power_high_w {
        Some(_) => format!("high level: as given, above the {most_w:.5} W that `{strong}` takes"),
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
