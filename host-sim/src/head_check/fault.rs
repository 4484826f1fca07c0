//! Faults that keep an element from being operated at an overheat, and which overheats it bears.

use anemometry::head::{Head, HeadElement};
use dr_core::sensor::Level;
use recording::text::{brief, short};

use super::conditions::{AtRest, HeadConditions};
use crate::sensor::BodySurvey;

/// Ends of the decades of overheats among which possible ones are sought, K.
const DECADES_K: [f64; 4] = [1.0, 10.0, 100.0, 1000.0];

/// Fault of one element.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ElementFault {
    /// The gas alone, in °C, makes it so many Ω, too few for its limits.
    #[error(
        "has {ohm} Ω at {celsius} °C, below its `resistance_min_ohm` of {2} Ω: it trips as shorted; a limit below the coldest gas does not",
        ohm = brief(*.0), celsius = brief(*.1)
    )]
    Shorted(f64, f64, f32),
    /// The set-point is beyond its limits, °C.
    #[error("would have {} °C, and by its limits it trips above {} °C", brief(*.0), brief(*.1))]
    Hot(f64, f64),
    /// Its high level is too weak, W.
    #[error("needs {} mW in quiescent gas, more than its high level gives, {} mW", milli(*.0), milli(*.1))]
    Weak(f64, f64),
    /// Its low level is too strong, W.
    #[error(
        "needs {} mW in quiescent gas, less than its low level gives, {} mW: it stays above the set-point there",
        milli(*.0), milli(*.1)
    )]
    Warm(f64, f64),
    /// It does not bear for long what quiescent gas takes, W.
    #[error(
        "needs {needed} mW in quiescent gas, more than its `sustained_power_w` of {1} W: it trips once `energy_j` is used up",
        needed = milli(*.0)
    )]
    Unsustained(f64, f32),
    /// No element of the head is to be driven.
    #[error("only senses, as all others do")]
    Senses,
}

/// A head that cannot be operated at its overheat.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("`{element}` {fault}{}", words(possible_k))]
pub struct OverheatError {
    /// Name of the element.
    pub element: String,
    /// Fault.
    pub fault: ElementFault,
    /// The overheats that are possible, K: ranges from the least to the greatest.
    pub possible_k: Vec<[f64; 2]>,
}

impl ElementFault {
    /// Tells whether an element trips in the gas as it is.
    pub fn shorted(element: &HeadElement, gas_c: f64) -> Option<Self> {
        let resistance_ohm = f64::from(element.config.channel.platinum().resistance_ohm(gas_c as f32));
        let least_ohm = element.config.limits.resistance_min_ohm;
        (resistance_ohm < f64::from(least_ohm)).then_some(Self::Shorted(resistance_ohm, gas_c, least_ohm))
    }

    /// Tells whether the low level alone keeps an element above its set-point.
    pub fn warm(element: &HeadElement, needed_w: f64, set_point_c: f64) -> Option<Self> {
        let low_w = element.power_w(set_point_c, Level::Low);
        (needed_w < low_w).then_some(Self::Warm(needed_w, low_w))
    }

    fn hot(element: &HeadElement, set_point_c: f64) -> Option<Self> {
        let hottest_c = f64::from(element.config.hottest_set_point().0);
        (set_point_c > hottest_c).then_some(Self::Hot(set_point_c, hottest_c))
    }

    fn unsustained(element: &HeadElement, needed_w: f64) -> Option<Self> {
        let sustained_w = element.config.limits.energy?.sustained_power_w;
        (needed_w > f64::from(sustained_w)).then_some(Self::Unsustained(needed_w, sustained_w))
    }
}

/// The first element that cannot be operated at a set-point, and why.
fn fault(survey: &mut BodySurvey, elements: &[HeadElement], set_point_c: f64) -> Option<(usize, ElementFault)> {
    let rest = AtRest::of(survey, elements, set_point_c);
    if !rest.held.contains(&true) {
        let Some((i, needed_w)) = rest.given_up else { return Some((0, ElementFault::Senses)) };
        let weak = || ElementFault::Weak(needed_w, elements[i].power_w(set_point_c, Level::High));
        return Some((i, ElementFault::hot(&elements[i], set_point_c).unwrap_or_else(weak)));
    }
    elements.iter().zip(rest.power_w).enumerate().filter(|(i, _)| rest.held[*i]).find_map(|(i, (of, needed_w))| {
        let fault = ElementFault::hot(of, set_point_c).or_else(|| ElementFault::warm(of, needed_w, set_point_c));
        Some((i, fault.or_else(|| ElementFault::unsustained(of, needed_w))?))
    })
}

impl OverheatError {
    /// Fault that keeps a head from being operated in quiescent gas.
    pub fn of(survey: &mut BodySurvey, head: &Head, conditions: &HeadConditions) -> Option<Self> {
        let (elements, gas_c) = (&head.elements, conditions.temperature_c);
        let shorted = elements.iter().enumerate().find_map(|(i, of)| Some((i, ElementFault::shorted(of, gas_c)?)));
        let is_cold = shorted.is_some();
        let (i, found) = shorted.or_else(|| fault(survey, elements, conditions.set_point_c()))?;
        let mut works = |overheat_k| !is_cold && fault(survey, elements, gas_c + overheat_k).is_none();
        Some(Self { element: elements[i].name.clone(), fault: found, possible_k: possible(&mut works) })
    }
}

/// Ranges of overheats of two digits that work, from 0.1 K.
fn possible(works: &mut dyn FnMut(f64) -> bool) -> Vec<[f64; 2]> {
    let digits = |decade: f64| (10..100).map(move |digits| f64::from(digits) * decade / 100.0);
    let tried: Vec<(f64, bool)> =
        DECADES_K.into_iter().flat_map(digits).map(|overheat_k| (overheat_k, works(overheat_k))).collect();
    let runs = tried.chunk_by(|a, b| a.1 == b.1).filter(|run| run[0].1);
    runs.map(|run| [run[0].0, run[run.len() - 1].0]).collect()
}

fn words(possible_k: &[[f64; 2]]) -> String {
    let ranges: Vec<String> = possible_k.iter().map(|[least, most]| format!("{least} to {most}")).collect();
    if ranges.is_empty() { String::new() } else { format!("; {} K are possible", ranges.join(" and ")) }
}

fn milli(power_w: f64) -> String {
    short(1e3 * power_w, 3)
}
