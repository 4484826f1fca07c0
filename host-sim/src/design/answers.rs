//! How soon the power shows a change of the wind: between given levels, and at best.

use crate::predict::analysis::{SETTLED, change_between};
use crate::predict::disturbance::Change;
use crate::predict::windy::Windy;

/// A change from one wind to another, at the set-point.
pub struct Step<'a> {
    from: &'a str,
    to: &'a str,
    change: Change,
}

/// All changes from one of the winds to another.
pub fn changes<'a>(winds: &'a [Windy], target_c: f64) -> Vec<Step<'a>> {
    let pairs = winds.iter().flat_map(|from| winds.iter().map(move |to| (from, to)));
    let step = |(from, to): (&'a Windy, &'a Windy)| {
        let change = change_between(from, to, target_c)?;
        Some(Step { from: &from.label, to: &to.label, change })
    };
    pairs.filter(|(from, to)| !std::ptr::eq(*from, *to)).filter_map(step).collect()
}

/// The least and the most power in W that a change asks for at once; nothing where there is no change.
pub fn at_once_w(changes: &[Step<'_>]) -> Option<(f64, f64)> {
    let powers = || changes.iter().map(|step| step.change.at_once_w);
    Some((powers().reduce(f64::min)?, powers().reduce(f64::max)?))
}

/// The longest settling in s of all changes between levels in W; `None` where there is no change.
///
/// # Errors
/// If it is longer than what was wished: whether the structure is in the way, or a level.
pub fn settling_s(
    changes: &[Step<'_>],
    response_s: Option<f64>,
    levels_w: (f64, f64),
    reasons: &mut Vec<String>,
) -> Result<Option<f64>, String> {
    let settled_s = |step: &Step<'_>| step.change.between(SETTLED, levels_w).settled_s.unwrap_or(f64::INFINITY);
    let slowest = changes.iter().max_by(|a, b| settled_s(a).total_cmp(&settled_s(b)));
    let Some(step) = slowest else { return Ok(None) };
    let Step { from, to, change } = step;
    let (between_s, at_best_s) = (settled_s(step), change.settled_s(SETTLED).unwrap_or(f64::INFINITY));
    let limited = between_s > at_best_s * (1.0 + 1e-9);
    if let Some(response_s) = response_s.filter(|response_s| between_s > *response_s) {
        let tail = "That tail is the structure's; wish for that long, or take it out by the observer (`observe`)";
        return Err(if limited {
            let (low_w, high_w) = levels_w;
            let at_once_w = change.at_once_w;
            let level = if at_once_w > high_w { "a high level above" } else { "a low level below" };
            let remedy = if at_once_w < 0.0 {
                format!("{tail}: the change asks for less than no power")
            } else if at_best_s > response_s {
                tail.to_owned()
            } else {
                format!("With {level} {at_once_w:.5} W it would be {at_best_s:.3} s")
            };
            format!(
                "a response in {response_s} s cannot be had between {low_w:.5} and {high_w:.5} W: from `{from}` to `{to}` the power takes {between_s:.3} s to within 2 %. {remedy}"
            )
        } else {
            format!(
                "a response in {response_s} s cannot be had: from `{from}` to `{to}` the power takes {between_s:.3} s to within 2 %, whatever the levels and the sample period. {tail}"
            )
        });
    }
    reasons.push(if limited {
        format!(
            "response: the slowest change of the wind, from `{from}` to `{to}`, shows within 2 % in {between_s:.3} s, and in {at_best_s:.3} s if the levels gave the {:.5} W that it asks for at once",
            change.at_once_w
        )
    } else {
        format!(
            "response: the slowest change of the wind, from `{from}` to `{to}`, shows within 2 % in {between_s:.3} s, by the structure alone"
        )
    });
    Ok(Some(between_s))
}
