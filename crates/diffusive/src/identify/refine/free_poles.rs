//! What a search for free poles ended with: the choice, and what is to be said of poles at the edge
//! of what the record shows.

use super::super::design::{RegressionDesign, Role};
use super::super::fitted::FittedOutput;
use super::super::folds::{Score, score};
use super::super::normal_equations::{ModelTerm, PenalisedSolution};
use super::super::options::InitialState;
use super::super::pass::Facts;
use super::super::record::{RecordError, Survey};
use super::columns::Point;
use super::search::{LEAST_RATIO, MOST_READINGS, RateSearch, SearchState};
use crate::model::ModelOutput;

/// One output's poles.
pub struct FreePoles {
    pub search: RateSearch,
    /// Other paths were tried.
    pub is_reopened: bool,
    pub point: Point,
    pub score: Score,
    pub initial_state: InitialState,
    pub design: RegressionDesign,
    pub terms: Vec<ModelTerm>,
    pub solution: PenalisedSolution,
    /// What the record does not resolve of single poles: the sum of all predicts no worse for it.
    pub unresolved: Vec<String>,
}

impl FreePoles {
    /// The model of the output; `shift` was subtracted from it.
    pub fn fitted(&self, shift: f64, sample_period_s: f64) -> FittedOutput<'_> {
        let PenalisedSolution { theta, covariance, .. } = &self.solution;
        FittedOutput {
            design: &self.design,
            terms: &self.terms,
            theta,
            covariance,
            shift,
            drift: None,
            sample_period_s,
        }
    }
}

/// Whether what another start led to leaves less of the record, or leads anywhere at all.
pub fn is_better(new: &Result<FreePoles, RecordError>, old: &Result<FreePoles, RecordError>) -> bool {
    match (new, old) {
        (Ok(new), Ok(old)) => new.point.cost < old.point.cost,
        (Ok(_), Err(_)) => true,
        (Err(_), _) => false,
    }
}

/// Refuses poles that came together; else the choice that the search ended with, and what is to be
/// said of it.
pub fn settled(
    survey: &Survey,
    mut search: RateSearch,
    outputs: &[ModelOutput],
    poles: usize,
    facts: &Facts,
    nyquist_rad_s: f64,
) -> Result<FreePoles, RecordError> {
    let name = &outputs[search.setup.output].name;
    let pinned = search.pinned();
    let Some(point) = search.best.take() else { return Err(survey.refuse("has no rows")) };
    let rates = &point.rates_rad_s;
    let close = match search.state {
        SearchState::Merged(close) => Some(close),
        _ => rates.windows(2).position(|two| two[1] < 1.01 * LEAST_RATIO * two[0]),
    };
    if let Some(close) = close {
        let (slow, fast) = (rates[close], rates[close + 1]);
        return Err(survey.refuse(format!(
            "{poles} poles are more than this record can tell apart: for `{name}` those at {slow:.4e} and {fast:.4e} rad/s come together; ask for fewer with --free-poles"
        )));
    }
    let mut unresolved = Vec::new();
    for (k, _) in pinned.iter().enumerate().filter(|(_, pinned)| **pinned) {
        let what = if search.is_at_slow_edge(rates[k]) {
            "slower than a record of this length shows"
        } else {
            "faster than samples of this period show"
        };
        unresolved.push(format!("`{name}`: the pole at {:.4e} rad/s stands at the edge of its range, {what}: ask for fewer with --free-poles", rates[k]));
    }
    for rate in rates.iter().filter(|rate| **rate > nyquist_rad_s) {
        unresolved.push(format!(
            "`{name}`: the pole at {rate:.4e} rad/s is faster than samples of this period resolve, {nyquist_rad_s:.4e} rad/s: its R is resolved, its rate and capacitance are not; sample faster, or ask for --feed-through yes and one pole less"
        ));
    }
    for k in 0..poles - 1 {
        let variance = point.covariance(k, k) + point.covariance(k + 1, k + 1) - 2.0 * point.covariance(k, k + 1);
        if libm::log(rates[k + 1] / rates[k]) < 2.0 * variance.max(0.0).sqrt() {
            unresolved.push(format!(
                "`{name}`: the poles at {:.4e} and {:.4e} rad/s are no further apart than twice their standard error: {poles} poles are more than this record can tell apart; ask for fewer with --free-poles",
                rates[k],
                rates[k + 1]
            ));
        }
    }
    if let SearchState::Unsettled(step) = search.state {
        unresolved.push(format!(
            "`{name}`: after {MOST_READINGS} readings the rates still move by {:.1e} of themselves: ask for fewer with --free-poles",
            step
        ));
    }
    let score = score(&point.folds, &point.total, &point.penalty, point.positive.as_deref());
    let initial_state = search.setup.initial_state.unwrap_or(InitialState::Free);
    // Terms of the plain design stand in the order of θ; the rates' own behind them weigh no
    // column.
    let design = search.setup.design(rates);
    let mut terms = search.setup.terms(&design, initial_state, &facts.first_drives(&design));
    terms.resize(point.joint.theta.len(), ModelTerm { of: Vec::new(), role: Role::Offset });
    let solution = point.solution();
    Ok(FreePoles { search, is_reopened: false, point, score, initial_state, design, terms, solution, unresolved })
}
