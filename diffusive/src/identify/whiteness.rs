//! A second opinion: if what a choice leaves is coloured, the candidate that predicted best of all
//! is looked at, and taken if what it leaves is white.
//!
//! The choice is cautious, for records of the real world: it keeps few rates and the thesis' lower
//! edge unless others are clearly better. Where noise is small, though, few rates leave a trace of
//! themselves in every stretch alike, which makes stated errors false. White residuals are proof
//! that nothing is missing, and models of disturbed records never get there; half the
//! cross-validated error is taken for proof as well.

use super::choose::Choice;
use super::design::RegressionDesign;
use super::options::InitialState;
use super::record::{RecordError, RecordSource};
use super::residual_pass::{OutputResiduals, residuals_of_all};

/// Correlated residuals make standard errors larger by this or more: coloured.
const COLOURED: f64 = 1.1;

/// Replaces choices by the best rivals that leave white residuals where they do not. `settle` makes
/// a choice of an output's best rival.
pub fn prefer_white(
    source: &mut dyn RecordSource,
    designs: &[RegressionDesign],
    output_shift: &[f64],
    choices: Vec<Choice>,
    settle: &dyn Fn(usize, &Choice) -> Option<Choice>,
    tell: &mut dyn FnMut(u64),
) -> Result<Vec<Choice>, RecordError> {
    // A record of one output and one mesh has no rivals: no reading is spent on it.
    let rivals: Vec<Option<Choice>> =
        choices.iter().enumerate().map(|(output, choice)| settle(output, choice)).collect();
    if rivals.iter().all(Option::is_none) {
        return Ok(choices);
    }
    let residuals = residuals_of_all(source, designs, output_shift, &choices, &mut |seen| tell(seen.row))?;
    let coloured: Vec<bool> =
        residuals.iter().enumerate().map(|(output, residuals)| !is_white(residuals, output)).collect();
    let second: Vec<Choice> = choices
        .iter()
        .zip(&rivals)
        .zip(&coloured)
        .map(|((choice, rival), coloured)| rival.clone().filter(|_| *coloured).unwrap_or_else(|| choice.clone()))
        .collect();
    if !rivals.iter().zip(&coloured).any(|(rival, coloured)| rival.is_some() && *coloured) {
        return Ok(choices);
    }
    let residuals = residuals_of_all(source, designs, output_shift, &second, &mut |seen| tell(seen.row))?;
    let pick = |(output, (choice, mut second)): (usize, (Choice, Choice))| {
        let wins = coloured[output] && rivals[output].is_some();
        if wins && is_white(&residuals[output], output) {
            let reason = "residuals: white; those of fewer rates, or of a higher lower edge, were coloured";
            second.reason = Some(reason.to_owned());
            second
        } else if wins && is_evident(&choice, &second) {
            let reason = "residuals: coloured, but cross-validated errors are half those of fewer rates, or of a higher lower edge";
            second.reason = Some(reason.to_owned());
            second
        } else {
            choice
        }
    };
    Ok(choices.into_iter().zip(second).enumerate().map(pick).collect())
}

/// Whether an output's residuals show no memory that would make standard errors larger by a tenth.
pub fn is_white(residuals: &OutputResiduals, output: usize) -> bool {
    residuals.pass.residuals[output].whiteness().is_none_or(|whiteness| whiteness.inflation < COLOURED)
}

/// Half the cross-validated error or less. Not where the initial state was known: there the choice
/// has weighed slow meshes already.
fn is_evident(choice: &Choice, second: &Choice) -> bool {
    choice.trial.initial_state == InitialState::Free
        && second.trial.score.overall() <= 0.25 * choice.trial.score.overall()
}
