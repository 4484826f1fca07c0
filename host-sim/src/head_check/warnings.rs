//! Warnings about a head at its set-point: a sentence each.

use anemometry::head::{Head, HeadElement};

use super::conditions::{ElementCheck, HeadConditions};
use super::fault::{ElementFault, OverheatError};
use super::winds::WindRange;
use recording::text::{brief, short};

/// A tick at the high level that heats by more is coarse, K, and as a share of the overheat.
const COARSE_K: f64 = 3.0;
const COARSE_SHARE: f64 = 0.2;

/// The same sentence about several elements, with their names.
type Sentences = Vec<(String, Vec<String>)>;

/// All of it.
pub fn warnings(
    head: &Head,
    conditions: &HeadConditions,
    checks: &[ElementCheck],
    range: &WindRange,
    fault: Option<&OverheatError>,
) -> Vec<String> {
    let mut sentences: Sentences = Vec::new();
    for (i, element) in head.elements.iter().enumerate() {
        of_element(head, element, range.held[i], conditions, &mut sentences);
        let warm = ElementFault::warm(element, range.at_rest_w[i], conditions.set_point_c());
        if let Some(warm) = warm.filter(|_| range.held[i]) {
            add(&mut sentences, element, warm.to_string());
        }
        let rise_k = checks[i].tick_rise_k(conditions.sample_period_s);
        if range.held[i] && rise_k > COARSE_K.min(COARSE_SHARE * conditions.overheat_k) {
            let (rise, tick_ms) = (short(rise_k, 2), brief(1e3 * conditions.sample_period_s));
            let what = format!(
                "a single tick of {tick_ms} ms at the high level heats it by {rise} K, too coarse for its loop: a shorter `sample_period_s` or less `current_high_a`"
            );
            add(&mut sentences, element, what);
        }
    }
    for (i, element) in head.elements.iter().enumerate().filter(|(i, _)| range.held[*i]) {
        let Some(energy) = element.config.limits.energy else { continue };
        let Some(needs) = range.first_above(i, f64::from(energy.sustained_power_w)) else { continue };
        let what = format!(
            "`sustained_power_w` is {} W, and {} m/s takes up to {} W: it trips there once `energy_j` is used up",
            energy.sustained_power_w,
            short(needs.speed_m_s, 2),
            short(needs.power_w[i][1], 2)
        );
        add(&mut sentences, element, what);
    }
    let mut all: Vec<String> =
        sentences.into_iter().map(|(what, names)| format!("{}: {what}", names.join(", "))).collect();
    if !range.held.contains(&true) {
        let overheat_k = conditions.overheat_k;
        let why = fault.map(|fault| format!(": {fault}")).unwrap_or_default();
        all.push(format!("no element can be held {overheat_k} K above this gas{why}"));
    }
    all
}

/// Adds an element to the sentence about it.
fn add(sentences: &mut Sentences, element: &HeadElement, what: String) {
    match sentences.iter_mut().find(|(known, _)| *known == what) {
        Some((_, names)) => names.push(element.name.clone()),
        None => sentences.push((what, vec![element.name.clone()])),
    }
}

fn of_element(head: &Head, element: &HeadElement, held: bool, conditions: &HeadConditions, sentences: &mut Sentences) {
    let mut say = |what: String| add(sentences, element, what);
    let hottest_c = if held { conditions.set_point_c() } else { conditions.temperature_c };
    let resistance_ohm = f64::from(element.config.channel.platinum().resistance_ohm(hottest_c as f32));
    let limits = &element.config.limits;
    let current_a = if held { element.nominal.current_high_a } else { element.nominal.current_low_a };
    let at = format!("at {} °C", brief(hottest_c));
    if resistance_ohm > f64::from(limits.resistance_max_ohm) {
        let most = limits.resistance_max_ohm;
        say(format!(
            "has {} Ω {at}, above its `resistance_max_ohm` of {most} Ω: it trips as open",
            brief(resistance_ohm)
        ));
    }
    // Before it is heated it is as cold as the gas.
    if let Some(shorted) = ElementFault::shorted(element, conditions.temperature_c) {
        say(shorted.to_string());
    }
    if hottest_c > f64::from(limits.temperature_max_c) {
        say(format!(
            "its `temperature_max_c` of {} °C is below the set-point of {} °C",
            limits.temperature_max_c,
            brief(hottest_c)
        ));
    }
    let volt = current_a * resistance_ohm;
    if volt > head.full_scale_v {
        say(format!("has {} V {at}, above the converter's `full_scale_v` of {} V", brief(volt), head.full_scale_v));
    }
    if let Some(compliance_v) = head.compliance_v.filter(|compliance_v| volt > *compliance_v) {
        say(format!("has {} V {at}, above the `compliance_v` of its current source, {compliance_v} V", brief(volt)));
    }
}
