//! Time after which the power shows a change of the wind: between given levels, and at best.

use super::levels::{BEYOND_ABOVE, BEYOND_BELOW};
use crate::model::ModelError;
use crate::predict::analysis::{SETTLED, change_between};
use crate::predict::disturbance::WindChange;
use crate::predict::loop_model::LoopModel;

const TAIL: &str = "That tail is the structure's; allow that long, or take it out by the observer (`observe`)";

/// A change from one wind to another, at the set-point.
pub struct NamedChange<'a> {
    from: &'a str,
    to: &'a str,
    change: WindChange,
}

/// All changes from one of the winds to another.
pub fn changes<'a>(winds: &'a [LoopModel], target_c: f64) -> Vec<NamedChange<'a>> {
    let pairs = winds.iter().flat_map(|from| winds.iter().map(move |to| (from, to)));
    let step = |(from, to): (&'a LoopModel, &'a LoopModel)| {
        let change = change_between(from, to, target_c)?;
        Some(NamedChange { from: &from.label, to: &to.label, change })
    };
    pairs.filter(|(from, to)| !std::ptr::eq(*from, *to)).filter_map(step).collect()
}

/// The least and the most power in W that any change needs at any time; nothing where there is no
/// change.
pub fn needed_range_w(changes: &[NamedChange<'_>]) -> Option<(f64, f64)> {
    let extremes = || changes.iter().filter_map(|step| step.change.extremes_w());
    let least_w = extremes().map(|[least, _]| least.1).reduce(f64::min)?;
    Some((least_w, extremes().map(|[_, most]| most.1).reduce(f64::max)?))
}

/// The longest settling in s of all changes between levels in W; `None` where there is no change.
///
/// # Errors
/// If it is longer than what is required: whether the structure is in the way, or a level.
pub fn settling_s(
    changes: &[NamedChange<'_>],
    response_s: Option<f64>,
    levels_w: (f64, f64),
    reasons: &mut Vec<String>,
) -> Result<Option<f64>, ModelError> {
    let settled_s =
        |step: &NamedChange<'_>, levels_w| step.change.between(SETTLED, levels_w).settled_s.unwrap_or(f64::INFINITY);
    let slowest = changes.iter().max_by(|a, b| settled_s(a, levels_w).total_cmp(&settled_s(b, levels_w)));
    let Some(step) = slowest else {
        if let Some(response_s) = response_s {
            reasons.push(format!(
                "response: there is one wind only, and so no change that {response_s} s could be looked at for; bits are averaged over them"
            ));
        }
        return Ok(None);
    };
    let NamedChange { from, to, change } = step;
    let (between_s, at_best_s) = (settled_s(step, levels_w), change.settled_s(SETTLED).unwrap_or(f64::INFINITY));
    let limited = between_s > at_best_s * (1.0 + 1e-9);
    let (lacks, wide_w) = lacking(change, levels_w);
    if let Some(response_s) = response_s.filter(|response_s| between_s > *response_s) {
        refuse_if!(
            !limited,
            model_error!(
                "a response in {response_s} s cannot be had: from `{from}` to `{to}` the power takes {between_s:.3} s to within 2 % of the change, whatever the levels and the sample period. {TAIL}"
            )
        );
        let wide_s = settled_s(step, wide_w);
        let remedy = match wide_s <= response_s {
            true => format!("With {} it would be {wide_s:.3} s", lacks.join(" and ")),
            false => TAIL.to_owned(),
        };
        let (low_w, high_w) = levels_w;
        return Err(model_error!(
            "a response in {response_s} s cannot be had between {low_w:.5} and {high_w:.5} W: from `{from}` to `{to}` the power takes {between_s:.3} s to within 2 % of the change. {remedy}"
        ));
    }
    let within = |time_s: f64| if time_s == 0.0 { "at once".to_owned() } else { format!("in {time_s:.3} s") };
    reasons.push(if limited && lacks.is_empty() {
        format!(
            "response: the slowest change of the wind, from `{from}` to `{to}`, shows within 2 % of it {}: for a while it needs less than no heat",
            within(between_s)
        )
    } else if limited {
        format!(
            "response: the slowest change of the wind, from `{from}` to `{to}`, shows within 2 % of it {}, and {} with {}",
            within(between_s),
            within(settled_s(step, wide_w)),
            lacks.join(" and ")
        )
    } else {
        format!(
            "response: the slowest change of the wind, from `{from}` to `{to}`, shows within 2 % of it {}, by the structure alone",
            within(between_s)
        )
    });
    Ok(Some(between_s))
}

/// Levels that would be out of the way of a change, in words, and those levels in W, none below
/// zero.
fn lacking(change: &WindChange, (low_w, high_w): (f64, f64)) -> (Vec<String>, (f64, f64)) {
    let Some([(least_s, least_w), (most_s, most_w)]) = change.extremes_w() else {
        return (Vec::new(), (low_w, high_w));
    };
    let after = |time_s: f64| match time_s {
        0.0 => "at once".to_owned(),
        f64::INFINITY => "in the end".to_owned(),
        time_s => format!("{time_s:.3} s after the change"),
    };
    let (mut lacks, mut wide_w) = (Vec::new(), (low_w, high_w));
    if least_w < low_w && low_w > 0.0 {
        wide_w.0 = (BEYOND_BELOW * least_w).max(0.0);
        lacks.push(if least_w > 0.0 {
            format!("a low level below the {least_w:.5} W that it needs {}", after(least_s))
        } else {
            format!("a low level of 0 W, as it needs no heat at all {}", after(least_s))
        });
    }
    if most_w > high_w {
        wide_w.1 = BEYOND_ABOVE * most_w;
        lacks.push(format!("a high level above the {most_w:.5} W that it needs {}", after(most_s)));
    }
    (lacks, wide_w)
}
