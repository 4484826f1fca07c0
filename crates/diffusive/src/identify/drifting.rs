//! Choices beside that of cross-validation: where the offset moves, and where a record is poorly
//! excited.
//!
//! | record | choice |
//! |---|---|
//! | its input moves often, and a drift has evidence | the drift of most evidence, and candidates weighed by theirs |
//! | its input moves seldom, and what the ordinary choice leaves is coloured | an average of candidates, weighed by one over their error ahead |
//! | any other | the ordinary one |
//!
//! A body's inputs that move a thousand times distinguish a drift from the body; a few steps do
//! not, and what a model of the wrong structure leaves of them looks like a drift. There no
//! candidate is to be trusted more than others that carry on about as well, and their average errs
//! least (docs/explanation/identification.md).

use super::candidates::{MeshPart, initial_states};
use super::choose::{CandidateSet, Choice, ScoredCandidate};
use super::drift::search::{DriftCase, WORTH};
use super::drift::{ChosenDrift, DriftGiven, NoiseFilter};
use super::folds::{Score, geometric_mean};
use super::gram::Gram;
use super::mixture::{MixtureCandidate, MixtureMember};
use super::normal_equations::ModelTerm;
use super::options::InitialState;
use super::prior::Prior;
use super::residuals::Residuals;
use super::segment::start_rates;
use super::whiteness::is_white;

/// Moves of an input from which on evidence is trusted: a dryer of 89 is predicted worse with a
/// drift.
const MOVES: u64 = 100;
/// Moves up to which a record is poorly excited.
const SELDOM: u64 = 50;
/// Evidence, in nats, within which another candidate counts.
const COUNTS: f64 = 6.0;
/// Candidates of a drift that are averaged at the most.
const MOST_MEMBERS: usize = 60;
/// Ratio of mean squared errors ahead.
const WORSE: f64 = 0.5;
/// The same ratio for a drift: twelve times the error.
const FAR_WORSE: f64 = 144.0;
/// Evidence, in nats, by which a drift must lead an ordinary choice that leaves white noise: it may
/// have taken a drift for slow relaxations (120 and more, of a sine of the drift rig), or be right
/// about a structure that the mesh for drifts has not (20, of a sphere's sector).
const WORTH_OF_WHITE: f64 = 50.0;
/// Weights of the prior that are averaged.
const AVERAGED: [f64; 3] = [1e-3, 1e-4, 1e-5];

impl CandidateSet<'_> {
    /// Another choice, if the record calls for one; `left` is what the ordinary one leaves.
    pub fn otherwise(&self, ordinary: &Choice, left: &Residuals) -> Option<Choice> {
        let moves = self.reading.passed.facts.moves();
        if moves >= MOVES || matches!(self.options.drift, DriftGiven::Kind(_)) {
            // An offset that moves spoils what lies ahead for any model: one that carries on far
            // better explains what looks like a drift.
            let drifting = self.drifting(ordinary, left)?;
            let is_far_worse = drifting.score.mean_ahead() > FAR_WORSE * ordinary.score.mean_ahead();
            return (!is_far_worse).then_some(drifting);
        }
        if moves >= SELDOM {
            return None;
        }
        let average = self.averaged(ordinary, moves)?;
        // What leaves white noise is left alone, unless it is clearly worse at carrying on.
        let worse = average.score.mean_ahead() > WORSE * ordinary.score.mean_ahead();
        (!is_white(left) || !worse).then_some(average)
    }

    fn meshes_for(&self, part: MeshPart) -> Vec<usize> {
        (0..self.meshes().len()).filter(|&mesh| self.meshes()[mesh].part == part).collect()
    }

    fn initial_states(&self) -> Vec<InitialState> {
        initial_states(self.options.constraints.initial_state, &self.reading.first_drives)
    }

    fn drifting(&self, ordinary: &Choice, left: &Residuals) -> Option<Choice> {
        let mesh = *self.meshes_for(MeshPart::Drifting).first()?;
        let total = Gram::total(&self.reading.passed.folds[mesh]);
        let priors = match self.options.constraints.ridge {
            Some(ridge) => vec![Prior::Columns(ridge.max(1e-14))],
            None => (1..=8).map(|step| Prior::Tapered(10_f64.powi(-2 * step))).collect(),
        };
        let columns = self.columns(mesh);
        let feed_through = ordinary.trial.feed_through;
        let states = self.initial_states();
        let terms: Vec<Vec<ModelTerm>> = states.iter().map(|&state| self.terms(mesh, state, feed_through)).collect();
        let starts_rad_s = start_rates(&self.reading.plan.survey);
        let case = |state: usize| DriftCase {
            gram: &total,
            columns: &columns,
            terms: &terms[state],
            output: self.output,
            scales: &self.reading.scales,
            priors: &priors,
            starts_rad_s: &starts_rad_s,
            poles_rad_s: &self.meshes()[mesh].poles_rad_s,
        };
        // With the initial state that explains most under the best filter of the freest.
        let freest = states.len().checked_sub(1)?;
        let mut filters = case(freest).search(self.options.drift, COUNTS);
        let best_filter = &filters.first()?.0;
        let of_state = |state: &usize| case(*state).evidence(Some(best_filter));
        let best_state = (0..states.len()).max_by(|a, b| of_state(a).total_cmp(&of_state(b)))?;
        if best_state != freest {
            filters = case(best_state).search(self.options.drift, COUNTS);
        }
        // Kinds differ in what they were worth before, which their evidence holds.
        let mut candidates: Vec<(MixtureCandidate, f64)> = Vec::new();
        let evidence = filters.first()?.1;
        for (filter, own) in &filters {
            let by_state: Vec<Vec<f64>> = (0..states.len()).map(|state| case(state).by_prior(Some(filter))).collect();
            let most = greatest(by_state.iter().flatten());
            for (&initial_state, by_prior) in states.iter().zip(&by_state) {
                candidates.extend(priors.iter().zip(by_prior).map(|(&prior, at)| {
                    let filter = Some(filter.clone());
                    (MixtureCandidate { mesh, initial_state, feed_through, prior, filter }, at - most + own)
                }));
            }
        }
        candidates.sort_by(|a, b| b.1.total_cmp(&a.1));
        let most = candidates.first()?.1;
        candidates.retain(|(_, own)| *own > most - COUNTS);
        candidates.truncate(MOST_MEMBERS);
        let weights: Vec<f64> = candidates.iter().map(|(_, own)| libm::exp(own - most)).collect();
        let best = candidates.first()?.0.clone();
        // Another mesh may explain as well what looks like a drift on this one.
        let trial = &ordinary.trial;
        let of_ordinary = DriftCase {
            gram: &Gram::total(&self.reading.passed.folds[trial.mesh]),
            columns: &self.columns(trial.mesh),
            terms: &self.terms(trial.mesh, trial.initial_state, feed_through),
            ..case(freest)
        };
        let state = states.iter().position(|state| *state == best.initial_state)?;
        let of_best = greatest(&case(state).by_prior(best.filter.as_ref()));
        let lead = if is_white(left) { WORTH_OF_WHITE } else { WORTH };
        let is_worth = evidence > WORTH && of_best - of_ordinary.evidence(None) > lead;
        if self.options.drift == DriftGiven::Auto && !is_worth {
            return None;
        }
        let members: Vec<MixtureMember> =
            candidates.into_iter().map(|(candidate, _)| self.member(candidate, &total)).collect();
        let filter = best.filter?;
        let rate_rad_s = filter.rate_rad_s();
        let reason = format!(
            "the offset moves ({}): {} candidates of drift, initial state and prior, each weighed by its evidence",
            filter.kind.name(),
            members.len()
        );
        let drift = ChosenDrift { filter: Some(filter), evidence, level_k: 0.0, rate_rad_s };
        Some(self.mixed_choice(&members, &weights, mesh, ordinary, drift, Some(reason)))
    }

    fn averaged(&self, ordinary: &Choice, moves: u64) -> Option<Choice> {
        let meshes = self.meshes_for(MeshPart::Averaged);
        let union = *self.meshes_for(MeshPart::Union).first()?;
        let feed_through = ordinary.trial.feed_through;
        let mut members = Vec::new();
        for mesh in meshes {
            let total = Gram::total(&self.reading.passed.folds[mesh]);
            let pole = self.meshes()[mesh].poles_rad_s.first().copied();
            let walk = pole.map(NoiseFilter::walk);
            // Whatever was requested: candidates of a wrong structure err by more than a beginning.
            for initial_state in initial_states(None, &self.reading.first_drives) {
                for filter in std::iter::once(None).chain(walk.clone().map(Some)) {
                    for prior in AVERAGED.map(Prior::Tapered) {
                        let filter = filter.clone();
                        let candidate = MixtureCandidate { mesh, initial_state, feed_through, prior, filter };
                        members.push(self.member(candidate, &total));
                    }
                }
            }
        }
        let ahead = |member: &MixtureMember| geometric_mean(&member.ahead).sqrt();
        let least = members.iter().map(ahead).fold(f64::INFINITY, f64::min);
        let weights: Vec<f64> = members.iter().map(|member| least / ahead(member).max(f64::MIN_POSITIVE)).collect();
        let drift = ChosenDrift { filter: None, evidence: 0.0, level_k: 0.0, rate_rad_s: 0.0 };
        let reason = format!(
            "an average of {} candidates, each weighed by one over its error ahead: the inputs move {moves} times only, and what single candidates leave is no white noise",
            members.len()
        );
        Some(self.mixed_choice(&members, &weights, union, ordinary, drift, Some(reason)))
    }

    fn mixed_choice(
        &self,
        members: &[MixtureMember],
        weights: &[f64],
        mesh: usize,
        ordinary: &Choice,
        drift: ChosenDrift,
        reason: Option<String>,
    ) -> Choice {
        let most = (0..members.len()).max_by(|&a, &b| weights[a].total_cmp(&weights[b])).unwrap_or_default();
        let top = &members[most];
        let mixture = self.mixed(members, weights, mesh, top.candidate.feed_through);
        let positive = top
            .held
            .as_ref()
            .map(|_| mixture.terms.iter().map(|term| term.role.bank().is_some()).collect::<Vec<bool>>());
        let sign_reason = match &positive {
            Some(_) => "signs: none negative; the record does not contradict".to_owned(),
            None => "signs: any".to_owned(),
        };
        let score = Score { ahead: mixture.ahead, ..ordinary.score.clone() };
        Choice {
            trial: ScoredCandidate {
                mesh,
                initial_state: top.candidate.initial_state,
                feed_through: top.candidate.feed_through,
                prior: top.candidate.prior,
                score: score.clone(),
            },
            score,
            terms: mixture.terms,
            positive,
            solution: mixture.solution,
            rivals: Vec::new(),
            sign_reason,
            gain_spread: Vec::new(),
            reason,
            drift: Some(ChosenDrift { level_k: mixture.level_k, ..drift }),
        }
    }
}

fn greatest<'a>(values: impl IntoIterator<Item = &'a f64>) -> f64 {
    values.into_iter().copied().fold(f64::NEG_INFINITY, f64::max)
}
