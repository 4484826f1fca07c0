//! Hypotheses of a record, and what each was worth before it.

use super::columns::Delay;
use super::grid::Grid;
use crate::identify::drift::{DriftKind, NoiseFilter, Section};
use crate::identify::options::InitialState;

/// Probability that a record begins with anything, where rest or a settled body are possible.
const BEGINS_FREE: f64 = 0.02;
/// Probability that an output answers in the row of its input.
const ANSWERS_AT_ONCE: f64 = 0.01;
/// Probability that the offset moves.
const MOVES: f64 = 0.5;

/// ln of the prior of a dead time.
pub fn delay_prior(delay: Delay) -> f64 {
    if delay < 0 { libm::log(ANSWERS_AT_ONCE) } else { -0.7 * libm::log1p(f64::from(delay)) }
}

/// Initial states with the ln of their priors. `is_driven`: power in the first row.
pub fn initial_states(given: Option<InitialState>, is_driven: bool) -> Vec<(InitialState, f64)> {
    if let Some(state) = given {
        return vec![(state, 0.0)];
    }
    let known = 1.0 - BEGINS_FREE;
    let states = match is_driven {
        true => vec![(InitialState::Rest, known / 2.0), (InitialState::Settled, known / 2.0)],
        // Where nothing drives the first row, settled is at rest.
        false => vec![(InitialState::Rest, known)],
    };
    states.into_iter().chain([(InitialState::Free, BEGINS_FREE)]).map(|(state, p)| (state, libm::log(p))).collect()
}

/// An offset that stands, or moves as a filter says.
#[derive(Debug, Clone, PartialEq)]
pub struct Drift {
    pub filter: Option<NoiseFilter>,
    pub ln_prior: f64,
    /// It is among the few by which paths are compared.
    pub is_screened: bool,
}

/// The offset stands, or it moves in any of the ways that the grid's poles allow for.
pub fn drifts(grid: &Grid, may_move: bool) -> Vec<Drift> {
    let poles = &grid.poles_rad_s;
    let stands = if may_move { 1.0 - MOVES } else { 1.0 };
    let mut all = vec![Drift { filter: None, ln_prior: libm::log(stands), is_screened: true }];
    if !may_move {
        return all;
    }
    let section = |pole_rad_s, zero_rad_s| Section { pole_rad_s, zero_rad_s };
    // Two sections with a zero between their poles are one whose pole lies between.
    let single: Vec<Vec<Section>> = poles.iter().map(|&pole| vec![section(pole, 0.0)]).collect();
    let between = poles.windows(2).map(|two| vec![section(two[0], 0.0), section(two[1], (two[0] * two[1]).sqrt())]);
    let walks: Vec<Vec<Section>> = single.iter().cloned().chain(between).collect();
    let is_slow = |two: &&[f64]| two[1] < 0.1 * std::f64::consts::PI / grid.period_s;
    let smooth = poles.windows(2).filter(is_slow).map(|two| two.iter().map(|&pole| section(pole, 0.0)).collect());
    let smooth: Vec<Vec<Section>> = smooth.collect();
    let zeros = (0..12).map(|step| 0.5 / grid.duration_s * libm::pow(10.0, 0.5 * f64::from(step)));
    let zeros: Vec<f64> = zeros.collect();
    let mut returning = Vec::new();
    for walk in &walks {
        for &zero_rad_s in zeros.iter().filter(|zero| **zero < 0.6 * walk[0].pole_rad_s) {
            let mut sections = walk.clone();
            sections[0].zero_rad_s = zero_rad_s;
            returning.push(sections);
        }
    }
    let kinds = [DriftKind::RandomWalk, DriftKind::IntegratedWalk, DriftKind::Correlated];
    for (kind, filters) in kinds.into_iter().zip([walks, smooth, returning]) {
        let ln_prior = libm::log(MOVES / 3.0 / filters.len().max(1) as f64);
        let plain = if kind == DriftKind::RandomWalk { single.len() } else { filters.len() };
        all.extend(filters.into_iter().enumerate().map(|(place, sections)| Drift {
            filter: Some(NoiseFilter { kind, sections }),
            ln_prior,
            is_screened: kind != DriftKind::Correlated && place < plain && place % 2 == 0,
        }));
    }
    all
}
