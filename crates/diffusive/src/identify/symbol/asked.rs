//! A requested initial state, and a record that contradicts it.
//!
//! Whoever says that a record begins at rest says more than the record may bear: what was stored
//! before then passes for the answer to power, and gains are wrong by as much. So the choice is
//! made once more on the same sums, with any initial state; where that explains the record clearly
//! better, the record is identified as if nothing had been requested, and a warning reports it.

use super::super::choose::Choice;
use super::super::folds::change;
use super::super::options::{IdentifyOptions, InitialState};
use super::super::record::Survey;

/// Ratio of errors, all questions together, from which a record contradicts.
const CONTRADICTED: f64 = 1.1;

/// Why the record contradicts, output by output; nothing where it does not. `others` are the
/// choices with any initial state.
pub fn contradictions(
    survey: &Survey,
    options: &IdentifyOptions,
    choices: &[Choice],
    others: &[Choice],
) -> Vec<String> {
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
