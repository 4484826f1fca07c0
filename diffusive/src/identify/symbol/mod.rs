//! Structure `symbol`: a symbol for every pair of input and output and every event class (thesis
//! 2.13–2.21).
//!
//! One class: columns are the states of the inputs. Several: the states of the inputs *gated* to a
//! class, which go on decaying while another class holds; all classes share what the record began
//! with.

mod plan;
mod reasons;
mod report;

use super::choose::{CandidateSet, Choice};
use super::labels::labels;
use super::options::{FitObserver, IdentifyOptions, Progress};
use super::pass::Passed;
use super::record::{RecordError, RecordSource};
use super::residual_pass::{observed, progress_now_and_then, residuals_of_all};
use super::tied::Ties;
use super::whiteness::prefer_white;
use crate::model::Model;
use plan::{BankFacts, SymbolPlan};
use report::SymbolResult;

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
    let survey = source.survey().clone();
    let classes = labels(source, progress)?;
    let plan = SymbolPlan::of(source, survey, classes, options)?;
    let passed = plan.read(source, options, progress)?;
    let banks = plan.bank_facts(&passed.facts);
    progress("choosing", 0, 1);
    let choices = choose(source, &plan, &passed, &banks, options, progress)?;
    let tied = options.tie.then(|| ties(&plan, &passed, &banks).tie(&choices));
    let (choices, tie_reason, tie_warning) = match tied {
        Some(tied) => (tied.choices, Some(tied.reason), tied.warning),
        None => (choices, None, None),
    };
    let mut row = observed(progress, plan.survey.rows, observer);
    let residuals = residuals_of_all(source, &plan.designs, &passed.output_shift, &choices, &mut row)?;
    let result = SymbolResult { plan: &plan, passed: &passed, choices: &choices, residuals: &residuals };
    Ok(result.model(&options.constraints, tie_reason, tie_warning))
}

/// The choice for every output, on the sums of one reading; and a second opinion where its
/// residuals are coloured.
fn choose(
    source: &mut dyn RecordSource,
    plan: &SymbolPlan,
    passed: &Passed,
    banks: &BankFacts,
    options: &IdentifyOptions,
    progress: &mut Progress<'_>,
) -> Result<Vec<Choice>, RecordError> {
    let bank_input: Vec<usize> = plan.parts.iter().map(|part| part.input).collect();
    let feed_through: &[bool] = match (plan.path.feed_through, options.constraints.feed_through) {
        (false, _) => &[false],
        (true, None) => &[false, true],
        (true, Some(_)) => &[true],
    };
    let candidates = |output: usize| CandidateSet {
        meshes: &plan.meshes,
        designs: &plan.designs,
        folds: &passed.folds,
        scales: &banks.scales,
        first_drives: &banks.first_drives,
        bank_input: &bank_input,
        outputs: plan.survey.outputs.len(),
        output,
        output_shift: passed.output_shift[output],
        sees: &plan.sees[output],
        feed_through,
        constraints: &options.constraints,
        signs: &options.signs,
    };
    let choices = (0..plan.survey.outputs.len()).map(|output| candidates(output).choose()).collect();
    prefer_white(
        source,
        &plan.designs,
        &passed.output_shift,
        choices,
        &|output, choice| candidates(output).best_rival(choice),
        &mut |row| progress_now_and_then(progress, "looking at residuals", row, plan.survey.rows),
    )
}

fn ties<'a>(plan: &'a SymbolPlan, passed: &'a Passed, banks: &'a BankFacts) -> Ties<'a> {
    Ties {
        designs: &plan.designs,
        folds: &passed.folds,
        scales: &banks.scales,
        first_drives: &banks.first_drives,
        parts: plan.parts.iter().map(|part| (part.input, part.class)).collect(),
        sees: &plan.sees,
    }
}
