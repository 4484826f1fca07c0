//! `anemo analyse`: what a closed loop will do, from a model.

use std::path::PathBuf;

use dr_core::model::Reachability;
use serde_json::{Value, json};

use super::Failure;
use super::analysis_summary::{brief, summary};
use crate::model::export::part::Part;
use crate::model::{Model, Pair};
use crate::plot::Canvas;
use crate::plot::model::closed_loop;
use crate::predict::analysis::{Analysis, Conditions, SETTLED, analyse, change_between};
use crate::predict::decays::Term;
use crate::predict::disturbance::Change;
use crate::predict::windy::{Windy, of_another_gas};

/// Swings beyond this share of the rise are not small.
const COARSE: f64 = 0.1;

/// Say from a model what the closed loop will do: whether it can hold a set-point, and how fast its power answers.
///
/// In the limit of fast sampling a loop held at its set-point has the transmission zeros of the model as its time constants. What is
/// said here therefore needs no closed loop. One class of one pair is analysed, and every change of the wind from it to another.
#[derive(clap::Args)]
#[command(after_help = "\
Levels and set-point may be left out: levels are then the least and the greatest input of the record that the model was identified from,
and the set-point lies half-way between what they can hold.

A zero's weight is what the power has beyond its steady value on that zero, in units of the steady value, right after the
temperature was lifted to the set-point at once. Weights of a change of the wind depend on the change, and are in `changes`.

Settling after a change of the wind is counted from the change until the power stays within 2 % of the whole change, with the
temperature back at its set-point where a level was in the way. Of a step of the set-point it is counted from rest, under the high level
first and between the levels then.

Examples:
  anemo analyse model.json
  anemo analyse model.json --class still --target 30 --low 0.0015 --high 0.042 --sample-period 0.01
  anemo analyse model.json --pair sector1:sector1 --json --plot loop.svg")]
pub struct Arguments {
    /// The model: a JSON file of `anemo identify`.
    model: PathBuf,
    /// The pair of input and output, as `sector1:sector1`, where the model has several.
    #[arg(long, value_name = "INPUT:OUTPUT", conflicts_with = "element")]
    pair: Option<String>,
    /// The element whose own pair is meant: short for `--pair NAME:NAME`.
    #[arg(long, value_name = "NAME")]
    element: Option<String>,
    /// The event class to analyse: the reference, or the first, if not given.
    #[arg(long, value_name = "LABEL")]
    class: Option<String>,
    /// The set-point, in K above the temperature without heating.
    #[arg(long, value_name = "K", allow_negative_numbers = true)]
    target: Option<f64>,
    /// Power of the low level, W.
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    low: Option<f64>,
    /// Power of the high level, W.
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    high: Option<f64>,
    /// Sample period of the loop, s: that of the model if not given.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    sample_period: Option<f64>,
    /// Temperature of the gas, °C, where the wind is a conductance: the model's own if not given.
    #[arg(long, value_name = "°C", allow_negative_numbers = true)]
    gas_temperature: Option<f64>,
    /// Draw poles, zeros and what the power does after a step into this .svg file.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

/// What was found, for the summary.
pub struct Found {
    pub pair: String,
    pub analysis: Analysis,
    /// To every other class, from the analysed one.
    pub changes: Vec<(String, Change)>,
    /// The same loop in the other classes.
    pub others: Vec<Analysis>,
    pub verdict: String,
    pub fast: bool,
    pub notes: Vec<String>,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let model = Model::read(&arguments.model).map_err(Failure::usage)?;
    let found = find(arguments, &model)
        .map_err(|sentence| Failure::usage(format!("{}: {sentence}", arguments.model.display())))?;
    if let Some(path) = &arguments.plot {
        let canvas = Canvas::create(path).map_err(Failure::usage)?;
        let svg = closed_loop::analysis_page(&found.pair, &found.analysis, &found.changes, &found.verdict);
        canvas.write(&svg.map_err(Failure::work)?).map_err(Failure::work)?;
    }
    if arguments.json {
        return super::print_json(&as_json(&found));
    }
    super::print(&summary(&found))
}

fn find(arguments: &Arguments, model: &Model) -> Result<Found, String> {
    super::finite(&[
        ("--target", arguments.target),
        ("--low", arguments.low),
        ("--high", arguments.high),
        ("--sample-period", arguments.sample_period),
        ("--gas-temperature", arguments.gas_temperature),
    ])?;
    let named = arguments.element.as_ref().map(|element| format!("{element}:{element}"));
    let pair = arguments.pair.as_ref().or(named.as_ref());
    let mut notes = Vec::new();
    let reference = model.wind.as_ref().map_or(&model.classes[0], |wind| &wind.reference);
    let label = arguments.class.as_ref().unwrap_or(reference);
    let part = Part::find(model, pair.map(String::as_str), Some(label))?;
    if arguments.class.is_none() && model.classes.len() > 1 {
        notes.push(format!("class `{label}` of {}: choose another with --class", model.classes.join(", ")));
    }
    own_heat(&part)?;
    if part.pair.dead_time_samples > 0 {
        let dead_s = brief(part.dead_time_s());
        notes.push(format!("the model's dead time of {dead_s} s is in the reaching time only: a real loop swings further by what a level does in that time"));
    }
    notes.extend(model.doubt(Some(part.pair)));
    notes.extend(of_another_gas(model, arguments.gas_temperature));
    let windy = Windy::of(&part, arguments.gas_temperature)?;
    let conditions = conditions(arguments, &part, &windy, &mut notes)?;
    let analysis = analyse(&windy, conditions);
    notes.extend(too_coarse(&analysis));
    let (mut changes, mut others) = (Vec::new(), Vec::new());
    for other in model.classes.iter().filter(|other| *other != label) {
        let Ok(part) = Part::find(model, pair.map(String::as_str), Some(other)) else {
            notes.push(format!("class `{other}` has no symbol of this pair"));
            continue;
        };
        match Windy::of(&part, arguments.gas_temperature) {
            Ok(to) => {
                let target_c = conditions.map_or(windy.unheated_c + 1.0, |conditions| conditions.target_c);
                // From a wind in which nothing is held nothing changes.
                let change = change_between(&windy, &to, target_c).filter(|_| reachable(&analysis) != Some(false));
                changes.extend(change.map(|change| (other.clone(), change)));
                others.push(analyse(&to, conditions));
            }
            Err(sentence) => notes.push(sentence),
        }
    }
    let (verdict, fast) = (analysis.verdict(&changes), analysis.is_fast(&changes));
    Ok(Found {
        pair: format!("{} → {}", part.pair.input, part.pair.output),
        analysis,
        changes,
        others,
        verdict,
        fast,
        notes,
    })
}

/// Refuses a pair whose output is another element's.
pub fn own_heat(part: &Part<'_>) -> Result<(), String> {
    if part.is_self_heating() {
        return Ok(());
    }
    let Pair { input, output, .. } = part.pair;
    Err(format!("pair {input} → {output} is cross-heating: no loop measures here and heats there"))
}

/// A remark on a sample period in which a level moves the temperature by a good part of the rise.
fn too_coarse(analysis: &Analysis) -> Option<String> {
    let held = analysis.held.as_ref()?;
    let swing_k = held.chatter?.peak_to_peak_k();
    (swing_k > COARSE * held.rise_k).then(|| {
        format!(
            "a sample period of {} s is too long for what is said here, which is of the limit of fast sampling: a tick moves the temperature by up to {} K, of a rise of {} K",
            held.conditions.sample_period_s,
            brief(swing_k),
            brief(held.rise_k)
        )
    })
}

/// What was asked for, and the rest from the model's record; `None`, with a note, where there is nothing to take it from.
fn conditions(
    arguments: &Arguments,
    part: &Part<'_>,
    windy: &Windy,
    notes: &mut Vec<String>,
) -> Result<Option<Conditions>, String> {
    let sample_period_s = arguments.sample_period.unwrap_or(part.model.sample_period_s);
    if sample_period_s <= 0.0 {
        return Err(format!("--sample-period is {sample_period_s} s: it must be greater than zero"));
    }
    let input = part.model.inputs.iter().position(|input| *input == part.pair.input);
    let seen = input.and_then(|input| part.model.provenance.input_range.get(input));
    let low = arguments.low.or(seen.map(|range| range[0]));
    let high = arguments.high.or(seen.map(|range| range[1]));
    let (Some(power_low_w), Some(power_high_w)) = (low, high) else {
        notes.push(
            "nothing is said of the loop at a set-point: the model does not tell its levels; give --low and --high"
                .to_owned(),
        );
        return Ok(None);
    };
    if arguments.low.is_none() || arguments.high.is_none() {
        notes.push("levels are those of the model's record; --low and --high give others".to_owned());
    }
    if power_low_w >= power_high_w {
        return Err(format!(
            "the low level is {power_low_w} W and the high level {power_high_w} W: the high one must be above"
        ));
    }
    if power_low_w < 0.0 {
        return Err(format!("--low is {power_low_w} W: a heater cannot cool"));
    }
    let half_way_k = || {
        notes.push("the set-point is half-way between what the levels can hold; --target gives another".to_owned());
        windy.plane.steady_gain_k_per_w() * f64::midpoint(power_low_w, power_high_w)
    };
    let rise_k = arguments.target.unwrap_or_else(half_way_k);
    Ok(Some(Conditions { target_c: windy.unheated_c + rise_k, power_low_w, power_high_w, sample_period_s }))
}

fn as_json(found: &Found) -> Value {
    let analysis = &found.analysis;
    let held = analysis.held.as_ref();
    let real = |number: fn(&Term) -> f64| -> Vec<f64> { analysis.zeros.iter().map(number).collect() };
    let complex = analysis.zeros.iter().any(|(rate, _)| rate.im != 0.0);
    json!({
        "pair": found.pair,
        "class": analysis.label,
        "reachable": reachable(analysis),
        "steady_power_w": steady_power_w(analysis),
        "reaching_time_s": held.and_then(|held| held.reaching_time_s),
        "poles_rad_s": analysis.poles_rad_s,
        "zeros_rad_s": real(|(rate, _)| rate.re),
        "zeros_imaginary_rad_s": complex.then(|| real(|(rate, _)| rate.im)),
        "zero_weights": real(|(_, weight)| weight.re),
        "zero_weights_imaginary": complex.then(|| real(|(_, weight)| weight.im)),
        "fast": found.fast,
        "verdict": found.verdict,
        "open_settling_s": analysis.open_settling_s,
        "closed_settling_s": analysis.closed_settling_s,
        "steady_gain_k_per_w": analysis.steady_gain_k_per_w,
        "high_frequency_gain_k_per_j": analysis.gamma_k_per_j,
        "unheated_c": analysis.unheated_c,
        "target_c": held.map(|held| held.conditions.target_c),
        "rise_k": held.map(|held| held.rise_k),
        "power_low_w": held.map(|held| held.conditions.power_low_w),
        "power_high_w": held.map(|held| held.conditions.power_high_w),
        "sample_period_s": held.map(|held| held.conditions.sample_period_s),
        "margins_w": held.map(|held| [held.margins_w.0, held.margins_w.1]),
        "settling_from_rest_s": held.and_then(|held| held.settled_s),
        "arrival_w": held.and_then(|held| held.arrival_w),
        "chatter_k": held.and_then(|held| held.chatter).map(|chatter| chatter.peak_to_peak_k()),
        "chatter_below_k": held.and_then(|held| held.chatter).map(|chatter| chatter.below_k),
        "chatter_above_k": held.and_then(|held| held.chatter).map(|chatter| chatter.above_k),
        "chatter_mean_k": held.and_then(|held| held.chatter).map(|chatter| chatter.mean_k()),
        "changes": found.changes.iter().map(|(to, change)| change_json(to, change, analysis)).collect::<Vec<_>>(),
        "classes": std::iter::once(analysis).chain(&found.others).map(|of| (of.label.clone(), class_json(of))).collect::<serde_json::Map<_, _>>(),
        "notes": found.notes,
    })
}

fn change_json(to: &str, change: &Change, analysis: &Analysis) -> Value {
    let limited = analysis.limited(change);
    json!({
        "to": to,
        "before_w": change.before_w,
        "at_once_w": change.at_once_w,
        "finally_w": change.finally_w,
        "mismatched_share": change.mismatched_share(),
        "matched_k_per_s": change.matched_k_per_s,
        "mismatched_k_per_s": change.mismatched_k_per_s,
        "settling_s": limited.settled_s,
        "off_set_point_s": limited.off_s,
        "settling_without_levels_s": change.settled_s(SETTLED),
        "decays": change.decays.terms().iter().map(|(rate, weight)| json!({"rate_rad_s": rate.re, "weight_w": weight.re})).collect::<Vec<_>>(),
    })
}

fn class_json(analysis: &Analysis) -> Value {
    json!({
        "reachable": reachable(analysis),
        "steady_power_w": steady_power_w(analysis),
        "steady_gain_k_per_w": analysis.steady_gain_k_per_w,
        "closed_settling_s": analysis.closed_settling_s,
    })
}

fn reachable(analysis: &Analysis) -> Option<bool> {
    analysis.held.as_ref().map(|held| matches!(held.verdict, Reachability::Reachable { .. }))
}

fn steady_power_w(analysis: &Analysis) -> Option<f64> {
    match analysis.held.as_ref()?.verdict {
        Reachability::Reachable { steady_power_w } => Some(steady_power_w),
        Reachability::LowLevelTooWarm { .. } | Reachability::HighLevelTooCold { .. } => None,
    }
}
