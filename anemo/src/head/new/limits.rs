//! Heads and overheats whose experiments would come to nothing, and what to know of the others.

use anemometry::calibrate::drawn::drawn;
use anemometry::calibrate::{DrawnOptions, LossLaw};
use anemometry::head::Head;
use host_sim::head_check::{ElementFault, HeadCheckReport};
use recording::text::short;

use crate::output::Failure;

/// Longest experiment, s and days.
const MOST_S: f64 = MOST_DAYS * DAY_S;
const MOST_DAYS: f64 = 7.0;
const DAY_S: f64 = 86_400.0;
/// Winds that are faster by less than this than what is known are extrapolated well enough.
const FAR: f64 = 1.5;

/// Refuses what would trip, hold nothing, or take too long.
pub fn refuse(head: &Head, report: &HeadCheckReport, longest_s: f64) -> Result<(), Failure> {
    if let Some(fault) = &report.fault {
        return Err(match fault.fault {
            ElementFault::Shorted { .. } | ElementFault::Senses => Failure::in_file(&head.source.path, fault),
            _ => Failure::usage(format!("--overheat is {}: {fault}", report.conditions.overheat_k)),
        });
    }
    if longest_s > MOST_S {
        let slowest_s = report.time_constants_s.first().copied().unwrap_or_default();
        let sentence = format!(
            "`body` has a slowest time constant of {} s, so that identifying it would take {} days: {MOST_DAYS} are the most, by less `capacity_j_k` or more `conductance_w_k`",
            short(slowest_s, 3),
            short(longest_s / DAY_S, 3)
        );
        return Err(Failure::in_file(&head.source.path, sentence));
    }
    Ok(())
}

/// Why `anemo calibrate` would refuse the head as it is operated.
pub fn uncalibrated(head: &Head, report: &HeadCheckReport) -> Option<String> {
    let surfaces = match drawn(head, &DrawnOptions::default(), LossLaw::Spline) {
        Ok((surfaces, _)) => surfaces,
        Err(error) => return Some(format!("no `anemo calibrate` follows: {error}")),
    };
    let missing = surfaces.into_iter().find(|&place| !report.elements[place].held)?;
    let (name, overheat_k) = (&head.elements[missing].name, report.conditions.overheat_k);
    Some(format!("no `anemo calibrate` follows: it takes all surfaces, and `{name}` cannot be held at {overheat_k} K"))
}

/// What becomes of winds up to a speed that the head cannot follow, a sentence each.
pub fn notes(head: &Head, report: &HeadCheckReport, most_m_s: f64) -> Vec<String> {
    let range = &report.range;
    let winds = format!("winds of the experiments reach {most_m_s} m/s");
    let mut notes = Vec::new();
    if let (Some(greatest_m_s), Some(element)) = (range.greatest_m_s, range.limited_by)
        && greatest_m_s < most_m_s
    {
        notes.push(format!(
            "{winds}, but `{}` can be held up to {} m/s: stronger ones are flagged `saturated`; less overheat, or less `most_m_s`",
            head.elements[element].name,
            short(greatest_m_s, 3)
        ));
    }
    if FAR * range.known_to_m_s < most_m_s && range.limited_by.is_none() {
        notes.push(format!("{winds}, but convection is known up to {} m/s", short(range.known_to_m_s, 3)));
    }
    let trips = head.elements.iter().enumerate().filter(|(i, _)| range.held[*i]).find_map(|(i, element)| {
        let sustained_w = f64::from(element.config.limits.energy?.sustained_power_w);
        let needs = range.first_above(i, sustained_w).filter(|needs| needs.speed_m_s < most_m_s)?;
        Some((element, needs.speed_m_s))
    });
    if let Some((element, speed_m_s)) = trips {
        notes.push(format!(
            "{winds}, but from {} m/s on `{}` takes more than its `sustained_power_w`: it trips there once `energy_j` is used up",
            short(speed_m_s, 2),
            element.name
        ));
    }
    notes
}
