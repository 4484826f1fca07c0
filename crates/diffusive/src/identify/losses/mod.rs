//! Losses that grow with temperature, found with the model that they are a part of.
//!
//! ```text
//! y_o = offset_o + H · w,    w_i = u_i − g_i (T_i − T_0)²,    g ≥ 0
//! b_i = g_i Σ R,    steady state ΔT + b ΔT² = Z · u
//! ```
//!
//! The extra loss is heat that the *measured* temperature takes out of the input, as wind does in
//! theory 12: exact where it leaves the heated body itself, b = β for a body with the conductance
//! G = G_0 (1 + β ΔT). T_0 is the offset, the temperature of the element without heat, iterated
//! until both agree: with another T_0 the model would be as good, but b another.
//!
//! The residual is in y whatever g is. A regression of z = ΔT + b ΔT² on u would need the Jacobian
//! ∂z/∂y = 1 + 2 b ΔT in its likelihood, or the g that shrinks z would win; this one needs none.
//!
//! | file | holds |
//! |---|---|
//! | `source` | a record with its losses taken out of the inputs, or beside them |
//! | `profile` | one output's regression for any g, on the sums of one reading |
//! | `search` | g, T_0 and standard errors on one candidate |
//! | `report` | the model's part, warnings and reasons |
//!
//! Limits: white noise of y of variance σ² enters w as g σ² on average, a constant power that the
//! offset absorbs, and as 2 g ΔT ν, which relaxations pass with Γ g ΔT Ts of its size: little for a
//! sensor that is sampled fast enough. Disturbances that move the temperature make g smaller rather
//! than greater, as they do not follow from w. The loss is taken at the start of each sample.

mod profile;
mod report;
mod search;
mod source;
#[cfg(test)]
mod tests;

use super::drift::DriftGiven;
use super::options::{FitObserver, IdentifyOptions, InitialState, Losses, Progress};
use super::record::{RecordError, RecordSource, Survey};
use crate::model::{Model, PlacedLoss, Structure};
use search::{FoundLoss, search};
use source::{LossColumns, LossSource, SearchedLoss};

/// Identifications with losses, at most, until g and T_0 agree with the model.
const ROUNDS: usize = 4;

/// What auto asks for: at most this part of the cross-validated error, g so many standard errors
/// above zero, and b ΔT at least. Before it identifies with losses, it is content with less: the
/// candidate was chosen to make the best of none.
const LESS: f64 = 0.7;
const WORTH_A_TRIAL: f64 = 0.85;
const SURE: f64 = 5.0;
const FELT: f64 = 0.05;

/// Inputs times classes beyond which auto does not try, as it would take longer than all else.
const MOST_BANKS: usize = 3;

/// Identification of a linear model.
pub type LinearIdentification = dyn Fn(
    &mut dyn RecordSource,
    &IdentifyOptions,
    &mut Progress<'_>,
    &mut FitObserver<'_>,
) -> Result<Model, RecordError>;

/// Refuses what losses do not go with.
pub fn refuse(survey: &Survey, options: &IdentifyOptions) -> Result<(), RecordError> {
    if options.losses != Losses::Growing {
        return Ok(());
    }
    survey.refuse_if(
        options.structure == Some(Structure::Conductance),
        "losses that grow with temperature are for structure `symbol`: leave out --losses, or --structure",
    )?;
    survey.refuse_if(
        options.constraints.feed_through == Some(true),
        "losses that grow with temperature and an output that follows its input at once do not go together: leave out --losses, or --feed-through",
    )
}

/// Identifies a record, with losses where they are asked for or evident. `linear` identifies it for
/// given losses; `observer` hears of every row of every identification, of which the last counts.
pub fn identify(
    source: &mut dyn RecordSource,
    options: &IdentifyOptions,
    linear: &LinearIdentification,
    progress: &mut Progress<'_>,
    observer: &mut FitObserver<'_>,
) -> Result<Model, RecordError> {
    let mut given = options.clone();
    if options.losses == Losses::Growing {
        given.constraints.feed_through = Some(false);
    }
    let is_auto = options.losses == Losses::Auto;
    if !is_auto && options.losses != Losses::None {
        given.drift = DriftGiven::None;
    }
    let plain = linear(source, &given, progress, observer)?;
    let is_too_much = is_auto && plain.inputs.len() * plain.classes.len() > MOST_BANKS;
    let is_made_for_it = plain.structure == Structure::Symbol && !elements(&plain).is_empty();
    if options.losses == Losses::None || !is_made_for_it || is_too_much {
        return Ok(plain);
    }
    // What a growing loss leaves looks like a drift, or an answer at once: losses are sought with
    // neither. Nobody hears of that model's rows, so that the plain one's stay the last.
    let imitates = plain.outputs.iter().any(|output| output.drift.is_some()) || feeds_through(&plain);
    let standing = if is_auto && imitates {
        given.drift = DriftGiven::None;
        given.constraints.feed_through = Some(false);
        linear(source, &given, progress, &mut |_| {})?
    } else {
        plain.clone()
    };
    let mut first = search(source, &standing, &elements(&standing), progress)?;
    let is_free = standing.chosen.initial_state == InitialState::Free.name();
    if is_auto && is_free && options.constraints.initial_state.is_none() {
        // Decays from any initial state take up what the first of two levels shows.
        let mut rested = standing.clone();
        rested.chosen.initial_state = InitialState::Rest.name().to_owned();
        let mut from_rest = search(source, &rested, &elements(&rested), progress)?;
        for (own, free) in from_rest.iter_mut().zip(&first) {
            own.scores[0] = free.scores[0].clone();
        }
        if is_evident(&from_rest, &from_rest, WORTH_A_TRIAL, 1.0) {
            first = from_rest;
        }
    }
    first.retain(FoundLoss::is_told);
    if is_auto && !is_evident(&first, &first, WORTH_A_TRIAL, 1.0) {
        return Ok(plain);
    }
    given.constraints.feed_through = Some(false);
    let (mut found, mut rounds) = (first.clone(), 0);
    let (mut model, losses) = loop {
        rounds += 1;
        let losses: Vec<SearchedLoss> = found.iter().map(|found| found.loss).collect();
        let mut less = LossSource::new(source, &losses, LossColumns::Taken, given.follow_ambient);
        let model = linear(&mut less, &given, progress, observer)?;
        if losses.is_empty() {
            break (model, losses);
        }
        found = search(source, &model, &losses, progress)?;
        if found.iter().all(FoundLoss::is_told) {
            if rounds >= ROUNDS || agrees(&model, &losses, &found) {
                break (model, losses);
            }
        } else {
            // Without those of which the record says nothing.
            let told: Vec<bool> = found.iter().map(FoundLoss::is_told).collect();
            for list in [&mut first, &mut found] {
                let mut told = told.iter();
                list.retain(|_| told.next() == Some(&true));
            }
        }
    };
    if losses.is_empty() && !is_auto {
        model.warnings.push(report::UNTOLD.to_owned());
        model.supported = false;
        return Ok(model);
    }
    report::complete(&mut model, &standing, &losses, &first, &found);
    if is_auto && !is_evident(&first, &found, LESS, report::inflation(&model)) {
        // What was seen last must be what is taken.
        return linear(source, options, progress, observer);
    }
    Ok(model)
}

/// The elements, by the order of their columns where there is an output an input; else each output
/// with the input that heats it most, the strongest first.
fn elements(model: &Model) -> Vec<SearchedLoss> {
    let place = |(input, output): (usize, usize)| SearchedLoss {
        placed: PlacedLoss { input, output, g_w_per_k2: 0.0 },
        origin_c: model.outputs[output].offset_c,
    };
    let (inputs, outputs) = (model.inputs.len(), model.outputs.len());
    if inputs == outputs {
        return (0..inputs).map(|at| place((at, at))).collect();
    }
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    for (input, name) in model.inputs.iter().enumerate() {
        let [least, most] = model.provenance.input_range.get(input).copied().unwrap_or([0.0, 1.0]);
        for (output, of) in model.outputs.iter().enumerate() {
            let class = model.pair(name, &of.name).and_then(|pair| pair.classes.values().next());
            pairs.extend(class.map(|class| (class.steady_gain_k_per_w * (most - least), input, output)));
        }
    }
    pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut taken: Vec<(usize, usize)> = Vec::new();
    for (effect, input, output) in pairs {
        if effect > 0.0 && !taken.iter().any(|of| of.0 == input || of.1 == output) {
            taken.push((input, output));
        }
    }
    taken.into_iter().map(place).collect()
}

fn feeds_through(model: &Model) -> bool {
    model.pairs.iter().flat_map(|pair| pair.classes.values()).any(|class| class.feed_through_k_per_w != 0.0)
}

/// Whether one of the losses cannot be chance, and none predicts worse than the model without, of
/// which `first` says how well it does: all questions together, and how it carries on.
fn is_evident(first: &[FoundLoss], found: &[FoundLoss], part: f64, inflation: f64) -> bool {
    let better = |(first, found): (&FoundLoss, &FoundLoss), part: f64| {
        let (without, with) = (&first.scores[0], &found.scores[1]);
        [(with.overall(), without.overall()), (with.mean_ahead(), without.mean_ahead())]
            .iter()
            .all(|(with, without)| *with <= part * part * without)
    };
    let is_sure = |found: &FoundLoss| {
        let g = found.g(inflation);
        g.value > SURE * g.se && found.b_per_k() * found.greatest_rise_k >= FELT
    };
    let mut both = first.iter().zip(found);
    both.clone().any(|(first, found)| is_sure(found) && better((first, found), part))
        && both.all(|(first, found)| found.loss.placed.g_w_per_k2 == 0.0 || better((first, found), 1.0))
}

/// Whether the losses with which a model was identified are those that it asks for: what is left
/// between them moves temperatures by a fifth of the residuals at most, or b by a thousandth.
fn agrees(model: &Model, used: &[SearchedLoss], found: &[FoundLoss]) -> bool {
    used.iter().zip(found).all(|(used, found)| {
        let output = &model.outputs[used.placed.output];
        let (rise_k, g) = (found.greatest_rise_k, found.loss.placed.g_w_per_k2);
        let of_g = (g - used.placed.g_w_per_k2).abs() / g.max(f64::MIN_POSITIVE);
        let of_offset_k = 2.0 * found.b_per_k() * rise_k * (output.offset_c - used.origin_c).abs();
        (of_g <= 1e-3 || of_g * found.b_per_k() * rise_k * rise_k <= 0.2 * output.residual_rms)
            && of_offset_k <= 0.2 * output.residual_rms
    })
}
