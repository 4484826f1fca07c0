//! A second opinion: if what a choice leaves is coloured, the candidate that predicted best of all
//! is looked at, and taken if what it leaves is white.
//!
//! The choice is cautious, for records of the real world: it keeps few rates and the thesis' lower
//! edge unless others are clearly better. Where noise is small, though, few rates leave a trace of
//! themselves in every stretch alike, which makes stated errors false. White residuals are proof
//! that nothing is missing, and models of disturbed records never get there; half the
//! cross-validated error is taken for proof as well.

use super::choose::Choice;
use super::design::GasSource;
use super::fitted::FittedOutput;
use super::options::{FitObserver, InitialState};
use super::record::{RecordError, RecordSource};
use super::residual_pass::ResidualPass;
use super::residuals::Residuals;
use super::symbol::plan::SymbolReading;

/// Correlated residuals make standard errors larger by this or more: coloured.
const COLOURED: f64 = 1.1;

/// Replaces choices by the best rivals that leave white residuals where they do not. `settle` makes
/// a choice of an output's best rival.
pub fn prefer_white(
    source: &mut dyn RecordSource,
    reading: &SymbolReading,
    choices: Vec<Choice>,
    settle: &dyn Fn(usize, &Choice) -> Option<Choice>,
    seen: &mut FitObserver<'_>,
) -> Result<Vec<Choice>, RecordError> {
    let mut residuals_of = |choices: &mut dyn Iterator<Item = &Choice>| {
        let fitted: Vec<FittedOutput> =
            choices.enumerate().map(|(output, choice)| choice.fitted(reading, output)).collect();
        ResidualPass::of(source, GasSource::Constant(0.0), &fitted, seen).map(|pass| pass.residuals)
    };
    let mut rivals: Vec<Option<Choice>> =
        choices.iter().enumerate().map(|(output, choice)| settle(output, choice)).collect();
    // A record of one output and one mesh has no rivals: no reading is spent on it.
    if rivals.iter().all(Option::is_none) {
        return Ok(choices);
    }
    for (rival, residuals) in rivals.iter_mut().zip(residuals_of(&mut choices.iter())?) {
        rival.take_if(|_| is_white(&residuals));
    }
    if rivals.iter().all(Option::is_none) {
        return Ok(choices);
    }
    let mut second = choices.iter().zip(&rivals).map(|(choice, rival)| rival.as_ref().unwrap_or(choice));
    let residuals = residuals_of(&mut second)?;
    let pick = |((choice, rival), residuals): ((Choice, Option<Choice>), Residuals)| {
        let Some(rival) = rival else { return choice };
        let reason = if is_white(&residuals) {
            "residuals: white; those of fewer rates, or of a higher lower edge, were coloured"
        } else if is_evident(&choice, &rival) {
            "residuals: coloured, but cross-validated errors are half those of fewer rates, or of a higher lower edge"
        } else {
            return choice;
        };
        Choice { reason: Some(reason.to_owned()), ..rival }
    };
    Ok(choices.into_iter().zip(rivals).zip(residuals).map(pick).collect())
}

/// Whether an output's residuals show no memory that would make standard errors larger by a tenth.
pub fn is_white(residuals: &Residuals) -> bool {
    residuals.whiteness().is_none_or(|whiteness| whiteness.inflation < COLOURED)
}

/// Half the cross-validated error or less. Not where the initial state was known: there the choice
/// has weighed slow meshes already.
fn is_evident(choice: &Choice, second: &Choice) -> bool {
    choice.trial.initial_state == InitialState::Free
        && second.trial.score.overall() <= 0.25 * choice.trial.score.overall()
}
