//! Structure `symbol`: a symbol for every pair of input and output and every event class (thesis
//! 2.13–2.21).
//!
//! One class: columns are the states of the inputs. Several: the states of the inputs *gated* to a
//! class, which go on decaying while another class holds; all classes share what the record began
//! with.

pub(super) mod plan;
mod report;
#[cfg(test)]
mod tests;

use super::candidates::MeshPart;
use super::choose::{CandidateSet, Choice};
use super::delay::{self, PathDecision};
use super::design::GasSource;
use super::evidence::{Weighable, Weighed};
use super::fitted::FittedOutput;
use super::folds::change;
use super::options::{FitObserver, IdentifyOptions, InitialState, Progress};
use super::pass::labels;
use super::record::{RecordError, RecordSource, Survey};
use super::residual_pass::{ResidualPass, observed};
use super::residuals::Residuals;
use super::tied::{Tied, tie};
use super::whiteness::{is_white, prefer_white};
use crate::model::Model;
use plan::{SymbolPlan, SymbolReading};
use report::SymbolResult;

/// An average that leaves more than so many times the residual of the ordinary choice explains too
/// little to be better: measured records are predicted best with 2 to 4.
const COARSER: f64 = 3.0;

/// Ratio of cross-validated errors up to which a model without dead time and answer at once is as
/// good.
const AS_GOOD: f64 = 1.01;

/// Identifies a record with a symbol a pair and class: what is tried, one reading, choices on its
/// sums, residuals in another.
///
/// # Errors
/// If the record cannot be read, or cannot carry any of the models.
pub fn identify(
    source: &mut dyn RecordSource,
    options: &IdentifyOptions,
    progress: &mut Progress<'_>,
    observer: &mut FitObserver<'_>,
) -> Result<Model, RecordError> {
    identify_weighed(source, options, None, progress, observer)
}

/// Identifies a record; its hypotheses are weighed where it is `weighable`.
pub(super) fn identify_weighed(
    source: &mut dyn RecordSource,
    options: &IdentifyOptions,
    weighable: Option<&Weighable>,
    progress: &mut Progress<'_>,
    observer: &mut FitObserver<'_>,
) -> Result<Model, RecordError> {
    let (survey, classes) = (asked_of(source.survey(), options), labels(source, progress)?);
    let path = delay::decide(source, &options.constraints)?;
    let plain = path.plain(&options.constraints);
    let mut on = |path: PathDecision| {
        let plan = SymbolPlan::of(survey.clone(), classes.clone(), path, options)?;
        let reading = plan.read(source, options, progress)?;
        progress("choosing", 0, 1);
        let choices = decided(source, &reading, options, progress)?;
        Ok::<_, RecordError>((reading, choices))
    };
    let (mut reading, mut choices) = on(path)?;
    if let Some(plain) = plain {
        let (other, others) = on(plain)?;
        let (after, before) = (left_by(source, &other, &others)?, left_by(source, &reading, &choices)?);
        // White residuals are proof that nothing is missing, but for the signs of a body. Those that
        // any initial state allows for are no sign of it.
        let is_free = |choice: &Choice| choice.trial.initial_state == InitialState::Free;
        let is_as_good = |at: usize| {
            let is_alike = !is_free(&choices[at]) || is_free(&others[at]);
            let costs_signs = is_alike && choices[at].positive.is_some() && others[at].positive.is_none();
            let is_proven = is_white(&after[at]) && after[at].rms() <= AS_GOOD * before[at].rms();
            !costs_signs && (is_proven || others[at].score.is_plausible_beside(&choices[at].score, AS_GOOD))
        };
        if (0..others.len()).all(is_as_good) {
            (reading, choices) = (other, others);
        }
    }
    if options.asks_for_an_initial_state() {
        let open = options.with_any_initial_state();
        let others = decided(source, &reading, &open, progress)?;
        let against = contradictions(&reading.plan.survey, options, &choices, &others);
        if !against.is_empty() {
            let mut model = identify_weighed(source, &open, weighable, progress, observer)?;
            model.warnings.extend(against);
            model.supported = false;
            return Ok(model);
        }
    }
    let tied =
        if options.tie { tie(&reading, options, &choices) } else { Tied { choices, reason: None, warning: None } };
    let Tied { choices, reason: tie_reason, warning: tie_warning } = tied;
    progress("weighing hypotheses", 0, 1);
    let weighed: Vec<Option<Weighed>> = match weighable {
        None => choices.iter().map(|_| None).collect(),
        Some(weighable) => {
            let left = left_by(source, &reading, &choices)?;
            let weighed = weighable.weigh(&reading.plan.survey, options).into_iter().zip(&left);
            weighed.map(|(of, left)| Some(of).filter(|of| !(of.is_settled && is_white(left)))).collect()
        }
    };
    let fitted = fitted(&reading, &choices, &weighed);
    let mut row = observed(progress, "residuals", reading.plan.survey.rows, observer);
    let residuals = ResidualPass::of(source, GasSource::Constant(0.0), &fitted, &mut row)?;
    let result = SymbolResult { reading: &reading, choices: &choices, weighed: &weighed, fitted: &fitted, residuals };
    Ok(result.model(&options.constraints, tie_reason, tie_warning))
}

/// The model of every output: of all hypotheses where the evidence decides, else the choice's.
fn fitted<'a>(
    reading: &'a SymbolReading,
    choices: &'a [Choice],
    weighed: &'a [Option<Weighed>],
) -> Vec<FittedOutput<'a>> {
    let period_s = reading.plan.survey.sample_period_s;
    let of = |(output, weighed): (usize, &'a Option<Weighed>)| {
        let own = weighed.as_ref().and_then(|weighed| weighed.model.as_ref());
        own.map_or_else(|| choices[output].fitted(reading, output), |model| model.fitted(period_s))
    };
    weighed.iter().enumerate().map(of).collect()
}

/// What is known of a record, without a gas of which nothing is made.
fn asked_of(survey: &Survey, options: &IdentifyOptions) -> Survey {
    Survey { gas_column: survey.gas_column.clone().filter(|_| options.follow_ambient), ..survey.clone() }
}

/// The choice for every output, in the order in which choices give way to others.
fn decided(
    source: &mut dyn RecordSource,
    reading: &SymbolReading,
    options: &IdentifyOptions,
    progress: &mut Progress<'_>,
) -> Result<Vec<Choice>, RecordError> {
    let mut choices = choose(source, reading, options, progress)?;
    if reading.plan.meshes.iter().any(|mesh| mesh.part != MeshPart::Ordinary) {
        reconsider(source, reading, options, &mut choices)?;
    }
    Ok(choices)
}

/// The choice for every output, on the sums of one reading; and a second opinion where its
/// residuals are coloured.
fn choose(
    source: &mut dyn RecordSource,
    reading: &SymbolReading,
    options: &IdentifyOptions,
    progress: &mut Progress<'_>,
) -> Result<Vec<Choice>, RecordError> {
    let rows = reading.plan.survey.rows;
    let candidates = |output| CandidateSet { reading, options, output };
    let choices = (0..reading.plan.survey.outputs.len()).map(|output| candidates(output).choose()).collect();
    let rival = |output, choice: &Choice| candidates(output).best_rival(choice);
    prefer_white(source, reading, choices, &rival, &mut observed(progress, "looking at residuals", rows, &mut |_| {}))
}

/// Residuals that choices leave, output by output.
fn left_by(
    source: &mut dyn RecordSource,
    reading: &SymbolReading,
    choices: &[Choice],
) -> Result<Vec<Residuals>, RecordError> {
    let fitted: Vec<FittedOutput> =
        choices.iter().enumerate().map(|(output, choice)| choice.fitted(reading, output)).collect();
    ResidualPass::of(source, GasSource::Constant(0.0), &fitted, &mut |_| {}).map(|pass| pass.residuals)
}

/// Other choices where the record calls for them: of a drift, or an average.
fn reconsider(
    source: &mut dyn RecordSource,
    reading: &SymbolReading,
    options: &IdentifyOptions,
    choices: &mut [Choice],
) -> Result<(), RecordError> {
    let left = left_by(source, reading, choices)?;
    let mut others = choices.to_vec();
    for (output, left) in left.iter().enumerate() {
        let candidates = CandidateSet { reading, options, output };
        if let Some(other) = candidates.otherwise(&choices[output], left) {
            others[output] = other;
        }
    }
    if others.iter().any(Choice::is_average) {
        let after = left_by(source, reading, &others)?;
        for ((other, choice), (after, before)) in others.iter_mut().zip(&*choices).zip(after.iter().zip(&left)) {
            if other.is_average() && after.rms() > COARSER * before.rms() {
                *other = choice.clone();
            }
        }
    }
    choices.clone_from_slice(&others);
    Ok(())
}

/// Ratio of errors, all questions together, from which a record contradicts a requested initial state.
const CONTRADICTED: f64 = 1.1;

/// Reasons why the record contradicts a requested initial state, output by output.
///
/// A wrong request makes gains wrong: what was stored before passes for the answer to power. So the
/// choice is made once more on the same sums, with any initial state. `others` are those choices.
fn contradictions(survey: &Survey, options: &IdentifyOptions, choices: &[Choice], others: &[Choice]) -> Vec<String> {
    let asked = options.constraints.initial_state.map_or("", InitialState::name);
    let of = |((choice, other), name): ((&Choice, &Choice), &String)| {
        let ratio = other.score.overall() / choice.score.overall().max(1e-300);
        (ratio < CONTRADICTED.powi(-2)).then(|| {
            format!(
                "`{name}`: the initial state is not {asked}, as requested: with any other the cross-validated error is {}, and that is taken; the record does not begin so, or something else moves it at first (a drift, another input)",
                change(ratio)
            )
        })
    };
    choices.iter().zip(others).zip(&survey.outputs).filter_map(of).collect()
}
