//! The analysis of one class of one pair, with every change of the wind from it to another: `anemo
//! analyse`.

use std::collections::BTreeMap;

use dr_core::model::Reachability;
use serde::{Serialize, Serializer};

use super::analysis::{Analysis, LoopConditions, SETTLED, analyse, change_between};
use super::disturbance::WindChange;
use super::loop_model::{LoopModel, levels_descend, of_another_gas};
use crate::model::{Model, ModelError, PairClass};
use recording::text::four_digits as brief;

/// Swings beyond this share of the rise are not small.
const COARSE: f64 = 0.1;

/// Loop that is to be analysed; what is left out comes from the model.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct AnalysisRequest {
    /// The pair as `INPUT:OUTPUT`, where the model has several.
    pub pair: Option<String>,
    /// The class: the reference, or the first, if not given.
    pub class: Option<String>,
    /// The set-point, K above the temperature without heating.
    pub target_k: Option<f64>,
    /// Power of the low level, W.
    pub power_low_w: Option<f64>,
    /// Power of the high level, W.
    pub power_high_w: Option<f64>,
    /// Sample period of the loop, s.
    pub sample_period_s: Option<f64>,
    /// Temperature of the gas, °C, where the wind is a conductance.
    pub gas_c: Option<f64>,
}

/// Forecast of a closed loop. It prints as a summary, and serialises to the keys of `anemo analyse
/// --json`.
#[derive(Debug, Clone, PartialEq)]
pub struct AnalysisReport {
    /// `INPUT → OUTPUT`.
    pub pair: String,
    /// The class that was requested.
    pub analysis: Analysis,
    /// To every other class, from the analysed one.
    pub changes: Vec<(String, WindChange)>,
    /// The same loop in the other classes.
    pub others: Vec<Analysis>,
    /// Fast, or with a tail: one sentence.
    pub verdict: String,
    /// It settles in a tenth of the structure's own time.
    pub fast: bool,
    /// Notes for the reader.
    pub notes: Vec<String>,
}

impl AnalysisReport {
    /// Analyses one class of one pair, and every change of the wind from it to another.
    ///
    /// # Errors
    /// If there is no such loop, or its levels make none.
    pub fn new(model: &Model, request: &AnalysisRequest) -> Result<Self, ModelError> {
        let mut notes = Vec::new();
        let pair = request.pair.as_deref();
        let reference = model.wind.as_ref().map_or(&model.classes[0], |wind| &wind.reference);
        let label = request.class.as_ref().unwrap_or(reference);
        let part = PairClass::find(model, pair, Some(label))?;
        if request.class.is_none() && model.classes.len() > 1 {
            notes.push(format!("class `{label}` of {}: choose another with --class", model.classes.join(", ")));
        }
        part.refuse_cross_heating()?;
        if part.pair.dead_time_samples > 0 {
            let dead_s = brief(part.dead_time_s());
            notes.push(format!("the model's dead time of {dead_s} s is in the reaching time only: a real loop swings further by what a level does in that time"));
        }
        notes.extend(model.support_warning(Some(part.pair)));
        notes.extend(of_another_gas(model, request.gas_c));
        let from = LoopModel::of(&part, request.gas_c)?;
        let conditions = conditions(request, &part, &from, &mut notes)?;
        let analysis = analyse(&from, conditions);
        notes.extend(too_coarse(&analysis));
        let (mut changes, mut others) = (Vec::new(), Vec::new());
        for other in model.classes.iter().filter(|other| *other != label) {
            let Ok(part) = PairClass::find(model, pair, Some(other)) else {
                notes.push(format!("class `{other}` has no symbol of this pair"));
                continue;
            };
            match LoopModel::of(&part, request.gas_c) {
                Ok(to) => {
                    let target_c = conditions.map_or(from.unheated_c + 1.0, |conditions| conditions.target_c);
                    // From a wind in which nothing is held nothing changes.
                    let change =
                        change_between(&from, &to, target_c).filter(|_| analysis.is_reachable() != Some(false));
                    changes.extend(change.map(|change| (other.clone(), change)));
                    others.push(analyse(&to, conditions));
                }
                Err(error) => notes.push(error.to_string()),
            }
        }
        let (verdict, fast) = (analysis.verdict(&changes), analysis.is_fast(&changes));
        let pair = format!("{} → {}", part.pair.input, part.pair.output);
        Ok(Self { pair, analysis, changes, others, verdict, fast, notes })
    }
}

/// A remark on a sample period in which a level moves the temperature by a good part of the rise.
fn too_coarse(analysis: &Analysis) -> Option<String> {
    let held = analysis.held.as_ref()?;
    let swing_k = held.chatter?.peak_to_peak_k();
    (swing_k > COARSE * held.rise_k).then(|| {
        format!(
            "a sample period of {} s is too long for this analysis, which holds in the limit of fast sampling: a tick moves the temperature by up to {} K, of a rise of {} K",
            held.conditions.sample_period_s,
            brief(swing_k),
            brief(held.rise_k)
        )
    })
}

/// Requested conditions, and the rest from the model's record; `None`, with a note, where there is
/// nothing to take it from.
fn conditions(
    request: &AnalysisRequest,
    part: &PairClass<'_>,
    loop_model: &LoopModel,
    notes: &mut Vec<String>,
) -> Result<Option<LoopConditions>, ModelError> {
    let sample_period_s = request.sample_period_s.unwrap_or(part.model.sample_period_s);
    refuse_if!(
        sample_period_s <= 0.0,
        model_error!("--sample-period is {sample_period_s} s: it must be greater than zero")
    );
    let input = part.model.inputs.iter().position(|input| *input == part.pair.input);
    let seen = input.and_then(|input| part.model.provenance.input_range.get(input));
    let low = request.power_low_w.or(seen.map(|range| range[0]));
    let high = request.power_high_w.or(seen.map(|range| range[1]));
    let (Some(power_low_w), Some(power_high_w)) = (low, high) else {
        notes.push(
            "the loop is not analysed at a set-point: the model does not hold its levels; give --low and --high"
                .to_owned(),
        );
        return Ok(None);
    };
    if request.power_low_w.is_none() || request.power_high_w.is_none() {
        notes.push("levels are those of the model's record; --low and --high give others".to_owned());
    }
    refuse_if!(power_low_w >= power_high_w, levels_descend(power_low_w, power_high_w));
    refuse_if!(power_low_w < 0.0, model_error!("--low is {power_low_w} W: a heater cannot cool"));
    let half_way_k = || {
        notes.push("the set-point is half-way between what the levels can hold; --target gives another".to_owned());
        loop_model.steady_rise_k(f64::midpoint(power_low_w, power_high_w))
    };
    let rise_k = request.target_k.unwrap_or_else(half_way_k);
    let target_c = loop_model.unheated_c + rise_k;
    Ok(Some(LoopConditions { target_c, power_low_w, power_high_w, sample_period_s }))
}

impl Serialize for AnalysisReport {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let analysis = &self.analysis;
        let held = analysis.held.as_ref();
        let lost_w = analysis.lost_w();
        let chatter = held.and_then(|held| held.chatter);
        let complex = analysis.zeros.iter().any(|(rate, _)| rate.im != 0.0);
        let zeros =
            |number: fn(&super::decays::DecayTerm) -> f64| analysis.zeros.iter().map(number).collect::<Vec<_>>();
        let change_keys = |(to, change): &(String, WindChange)| {
            let limited = analysis.limited(change);
            let decays = change.decays.terms().iter();
            keys! {
                to: to.clone(),
                before_w: change.before_w + lost_w,
                at_once_w: change.at_once_w + lost_w,
                finally_w: change.finally_w + lost_w,
                mismatched_share: change.mismatched_share(),
                matched_k_per_s: change.matched_k_per_s.clone(),
                mismatched_k_per_s: change.mismatched_k_per_s.clone(),
                settling_s: limited.settled_s,
                off_set_point_s: limited.off_s,
                settling_without_levels_s: change.settled_s(SETTLED),
                decays: decays.map(|(rate, weight)| keys! { rate_rad_s: rate.re, weight_w: weight.re }).collect::<Vec<_>>(),
            }
        };
        let class_keys = |of: &Analysis| {
            let keys = keys! {
                reachable: of.is_reachable(),
                steady_power_w: of.steady_power_w(),
                steady_gain_k_per_w: of.steady_gain_k_per_w,
                closed_settling_s: of.closed_settling_s,
            };
            (of.label.clone(), keys)
        };
        keys! {
            pair: &self.pair,
            class: &analysis.label,
            reachable: analysis.is_reachable(),
            steady_power_w: analysis.steady_power_w(),
            reaching_time_s: held.and_then(|held| held.reaching_time_s),
            poles_rad_s: &analysis.poles_rad_s,
            zeros_rad_s: zeros(|(rate, _)| rate.re),
            zeros_imaginary_rad_s: complex.then(|| zeros(|(rate, _)| rate.im)),
            zero_weights: zeros(|(_, weight)| weight.re),
            zero_weights_imaginary: complex.then(|| zeros(|(_, weight)| weight.im)),
            fast: self.fast,
            verdict: &self.verdict,
            open_settling_s: analysis.open_settling_s,
            closed_settling_s: analysis.closed_settling_s,
            steady_gain_k_per_w: analysis.steady_gain_k_per_w,
            high_frequency_gain_k_per_j: analysis.gamma_k_per_j,
            unheated_c: analysis.unheated_c,
            target_c: held.map(|held| held.conditions.target_c),
            rise_k: held.map(|held| held.rise_k),
            lost_w: held.map(|held| held.lost_w),
            power_low_w: held.map(|held| held.conditions.power_low_w),
            power_high_w: held.map(|held| held.conditions.power_high_w),
            sample_period_s: held.map(|held| held.conditions.sample_period_s),
            margins_w: held.map(|held| held.margins_w),
            settling_from_rest_s: held.and_then(|held| held.settled_s),
            arrival_w: held.and_then(|held| held.arrival_w),
            chatter_k: chatter.map(|chatter| chatter.peak_to_peak_k()),
            chatter_below_k: chatter.map(|chatter| chatter.below_k),
            chatter_above_k: chatter.map(|chatter| chatter.above_k),
            chatter_mean_k: chatter.map(|chatter| chatter.mean_k()),
            changes: self.changes.iter().map(change_keys).collect::<Vec<_>>(),
            classes: std::iter::once(analysis).chain(&self.others).map(class_keys).collect::<BTreeMap<_, _>>(),
            notes: &self.notes,
        }
        .serialize(serializer)
    }
}

impl Analysis {
    /// Tells whether the set-point can be held; `None` where no levels are known.
    pub fn is_reachable(&self) -> Option<bool> {
        self.held.as_ref().map(|held| matches!(held.verdict, Reachability::Reachable { .. }))
    }

    /// Power that holds the set-point, W, where it can be held.
    pub fn steady_power_w(&self) -> Option<f64> {
        match self.held.as_ref()?.verdict {
            Reachability::Reachable { steady_power_w } => Some(steady_power_w),
            Reachability::LowLevelTooWarm { .. } | Reachability::HighLevelTooCold { .. } => None,
        }
    }
}
