//! What keeps an element from being operated at an overheat, and which overheats it bears.

use anemometry::head::{Head, HeadElement};
use dr_core::sensor::Level;
use recording::text::{brief, short};

use super::conditions::HeadConditions;
use super::rest::AtRest;
use crate::sensor::BodySurvey;

/// Overheats among which possible ones are sought, K, and their number.
const LEAST_K: f64 = 0.1;
const MOST_K: f64 = 1000.0;
const LADDER: usize = 94;
/// Halvings between one that is possible and one that is not.
const HALVINGS: usize = 30;
/// What a third digit may lack of a whole one.
const ROUND: f64 = 1e-4;

/// What is wrong with one element.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ElementFault {
    /// The gas alone makes it too cold for its limits.
    #[error(
        "has {} Ω at {} °C, below its `resistance_min_ohm` of {least_ohm} Ω: it trips as shorted; a limit below the coldest gas does not",
        brief(*resistance_ohm), brief(*gas_c)
    )]
    Shorted {
        /// Ω
        resistance_ohm: f64,
        /// °C
        gas_c: f64,
        /// Ω
        least_ohm: f32,
    },
    /// The set-point is beyond its limits.
    #[error("would have {} °C, and by its limits it trips above {} °C", brief(*set_point_c), brief(*hottest_c))]
    Hot {
        /// °C
        set_point_c: f64,
        /// °C
        hottest_c: f64,
    },
    /// Its high level is too weak.
    #[error("needs {} mW in quiescent gas, more than its high level gives, {} mW", milli(*needed_w), milli(*high_w))]
    Weak {
        /// W
        needed_w: f64,
        /// W
        high_w: f64,
    },
    /// Its low level is too strong.
    #[error(
        "needs {} mW in quiescent gas, less than its low level gives, {} mW: it stays above the set-point there",
        milli(*needed_w), milli(*low_w)
    )]
    Warm {
        /// W
        needed_w: f64,
        /// W
        low_w: f64,
    },
    /// It does not bear for long what quiescent gas takes.
    #[error(
        "needs {} mW in quiescent gas, more than its `sustained_power_w` of {sustained_w} W: it trips once `energy_j` is used up",
        milli(*needed_w)
    )]
    Unsustained {
        /// W
        needed_w: f64,
        /// W
        sustained_w: f32,
    },
    /// No element of the head is to be driven.
    #[error("only senses, as all others do")]
    Senses,
}

/// A head that cannot be operated at its overheat.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("`{element}` {fault}{}", words(*possible_k))]
pub struct OverheatError {
    /// Name of the element.
    pub element: String,
    /// What is wrong with it.
    pub fault: ElementFault,
    /// The overheats that are possible, K, from the least to the greatest.
    pub possible_k: Option<[f64; 2]>,
}

impl ElementFault {
    /// Whether an element trips in the gas as it is.
    pub fn shorted(element: &HeadElement, gas_c: f64) -> Option<Self> {
        let resistance_ohm = f64::from(element.config.channel.platinum().resistance_ohm(gas_c as f32));
        let least_ohm = element.config.limits.resistance_min_ohm;
        (resistance_ohm < f64::from(least_ohm)).then_some(Self::Shorted { resistance_ohm, gas_c, least_ohm })
    }

    /// Whether the low level alone keeps an element above its set-point.
    pub fn warm(element: &HeadElement, needed_w: f64, set_point_c: f64) -> Option<Self> {
        let low_w = element.power_w(set_point_c, Level::Low);
        (needed_w < low_w).then_some(Self::Warm { needed_w, low_w })
    }

    /// Whether a set-point is beyond an element's limits.
    fn hot(element: &HeadElement, set_point_c: f64) -> Option<Self> {
        let hottest_c = f64::from(element.config.hottest_set_point().0);
        (set_point_c > hottest_c).then_some(Self::Hot { set_point_c, hottest_c })
    }

    /// What is wrong with an element that is held.
    fn of_held(element: &HeadElement, needed_w: f64, set_point_c: f64) -> Option<Self> {
        let unsustained = || {
            let sustained_w = element.config.limits.energy?.sustained_power_w;
            (needed_w > f64::from(sustained_w)).then_some(Self::Unsustained { needed_w, sustained_w })
        };
        Self::hot(element, set_point_c).or_else(|| Self::warm(element, needed_w, set_point_c)).or_else(unsustained)
    }
}

/// The first element that cannot be operated at a set-point, and why.
fn fault(survey: &mut BodySurvey, elements: &[HeadElement], set_point_c: f64) -> Option<(usize, ElementFault)> {
    let rest = AtRest::of(survey, elements, set_point_c);
    if !rest.held.contains(&true) {
        let Some((i, needed_w)) = rest.given_up else { return Some((0, ElementFault::Senses)) };
        let weak = || ElementFault::Weak { needed_w, high_w: elements[i].power_w(set_point_c, Level::High) };
        return Some((i, ElementFault::hot(&elements[i], set_point_c).unwrap_or_else(weak)));
    }
    let held = (0..elements.len()).filter(|i| rest.held[*i]);
    held.filter_map(|i| Some((i, ElementFault::of_held(&elements[i], rest.power_w[i], set_point_c)?))).next()
}

impl OverheatError {
    /// What keeps a head from being operated in quiescent gas.
    pub fn of(survey: &mut BodySurvey, head: &Head, conditions: &HeadConditions) -> Option<Self> {
        let elements = &head.elements;
        let gas_c = conditions.temperature_c;
        let named = |i: usize, fault, possible_k| Self { element: elements[i].name.clone(), fault, possible_k };
        if let Some((i, shorted)) =
            (0..elements.len()).find_map(|i| Some((i, ElementFault::shorted(&elements[i], gas_c)?)))
        {
            return Some(named(i, shorted, None));
        }
        let (i, fault_found) = fault(survey, elements, conditions.set_point_c())?;
        let possible_k = possible(|overheat_k| fault(survey, elements, gas_c + overheat_k).is_none());
        Some(named(i, fault_found, possible_k))
    }
}

/// The widest range of overheats that work, to three digits.
fn possible(mut works: impl FnMut(f64) -> bool) -> Option<[f64; 2]> {
    let step = (MOST_K / LEAST_K).ln() / (LADDER - 1) as f64;
    let rungs: Vec<f64> = (0..LADDER).map(|k| LEAST_K * (step * k as f64).exp()).collect();
    let good: Vec<bool> = rungs.iter().map(|&overheat_k| works(overheat_k)).collect();
    let widest = good.chunk_by(|a, b| a == b).scan(0, |end, run| {
        *end += run.len();
        Some((*end - run.len()..*end, run[0]))
    });
    let (widest, _) = widest.filter(|(_, good)| *good).max_by_key(|(run, _)| run.len())?;
    let mut edge = |inside: usize, outside: Option<&f64>| {
        let mut good_k = rungs[inside];
        let mut bad_k = *outside.unwrap_or(&good_k);
        for _ in 0..HALVINGS {
            let middle_k = (good_k * bad_k).sqrt();
            *if works(middle_k) { &mut good_k } else { &mut bad_k } = middle_k;
        }
        good_k
    };
    let least_k = edge(widest.start, widest.start.checked_sub(1).map(|below| &rungs[below]));
    let most_k = edge(widest.end - 1, rungs.get(widest.end));
    // Halving never quite comes to a limit that is a round number.
    let digits = |overheat_k: f64| 10_f64.powf(2.0 - overheat_k.log10().floor());
    let (of_least, of_most) = (digits(least_k), digits(most_k));
    Some([(least_k * of_least - ROUND).ceil() / of_least, (most_k * of_most + ROUND).floor() / of_most])
}

fn words(possible_k: Option<[f64; 2]>) -> String {
    possible_k
        .map_or(String::new(), |[least, most]| format!("; {} to {} K are possible", short(least, 3), short(most, 3)))
}

fn milli(power_w: f64) -> String {
    short(1e3 * power_w, 3)
}
