//! Choosing for the user: every candidate scored by block cross-validation, the best one taken, and
//! the reasons kept.
//!
//! Candidates are ordered from the most to the least cautious (higher edge, known initial state,
//! stronger prior), and the most cautious one is taken that is as good as the best but for chance.
//! Then the signs: if holding all resistances at or above zero costs no more than 5 % of the error,
//! physics is kept; else those of an element's own heat alone; else none.

use nalgebra::DMatrix;

use super::candidates::{CandidateMesh, MeshPart, initial_states, priors, terms};
use super::design::Role;
use super::drift::ChosenDrift;
use super::fitted::{FittedOutput, steady_gain};
use super::folds::{FoldedEquations, Score, change};
use super::gram::Gram;
use super::normal_equations::{ModelTerm, NormalEquations, PenalisedSolution};
use super::options::{IdentifyOptions, InitialState, Signs};
use super::prior::Prior;
use super::symbol::plan::SymbolReading;

/// Candidates whose cross-validated error is at most that many times the choice's may be the truth
/// as well.
const PLAUSIBLE: f64 = 1.05;

/// Ratio of mean squared errors from which on it costs too much to hold resistances at or above
/// zero.
const DEAR: f64 = 1.05;

/// A candidate of one mesh, taken or not.
#[derive(Debug, Clone, PartialEq)]
pub struct ScoredCandidate {
    pub mesh: usize,
    pub initial_state: InitialState,
    pub feed_through: bool,
    pub prior: Prior,
    pub score: Score,
}

/// What one output's model was decided to be.
#[derive(Debug, Clone)]
pub struct Choice {
    pub trial: ScoredCandidate,
    /// The trial's once more, with the signs that are held: what is stated of it. Trials are
    /// compared without.
    pub score: Score,
    pub terms: Vec<ModelTerm>,
    /// For every term, whether it is held at or above zero.
    pub positive: Option<Vec<bool>>,
    pub solution: PenalisedSolution,
    pub rivals: Vec<ScoredCandidate>,
    pub sign_reason: String,
    /// By bank: how far candidates that predict about as well differ from it in the steady gain.
    pub gain_spread: Vec<GainSpread>,
    /// Why it is not the first choice, if it is not.
    pub reason: Option<String>,
    pub drift: Option<ChosenDrift>,
}

/// Error ahead of measured records of few steps, as a part of their output's spread: the median of
/// 62 parts of three rigs, `studies benchmark measured`.
const USUAL: f64 = 0.14;

/// For every term whether it is held at or above zero, why, and what that costs.
struct SignChoice {
    positive: Option<Vec<bool>>,
    reason: String,
    score: Score,
}

/// Absolute differences of others' steady gains from a choice's own, K/W.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct GainSpread {
    pub gain: f64,
    pub median: f64,
    pub upper_decile: f64,
}

/// Everything that a choice is made from, for one output.
#[derive(Clone, Copy)]
pub struct CandidateSet<'a> {
    pub reading: &'a SymbolReading,
    pub options: &'a IdentifyOptions,
    pub output: usize,
}

impl Choice {
    /// Whether it is the mean of candidates, whose standard errors hold how far they differ.
    pub fn is_average(&self) -> bool {
        self.drift.as_ref().is_some_and(|drift| drift.filter.is_none())
    }

    /// Root mean square error to be expected of what comes after the record, K: what came behind
    /// five to eight tenths of it. A few steps tell little of that either, so an average's stands
    /// halfway to what measured records show, for an output that spreads by `spread_k`.
    pub fn forecast_rms(&self, spread_k: f64) -> f64 {
        let ahead = self.score.mean_ahead().sqrt();
        if self.is_average() { (ahead * USUAL * spread_k).sqrt() } else { ahead }
    }

    /// The model of an output.
    pub fn fitted<'a>(&'a self, reading: &'a SymbolReading, output: usize) -> FittedOutput<'a> {
        FittedOutput {
            design: &reading.plan.designs[self.trial.mesh],
            terms: &self.terms,
            theta: &self.solution.theta,
            covariance: &self.solution.covariance,
            shift: reading.passed.output_shift[output],
            drift: self.drift.as_ref(),
            sample_period_s: reading.plan.survey.sample_period_s,
        }
    }
}

impl CandidateSet<'_> {
    pub(super) fn meshes(&self) -> &[CandidateMesh] {
        &self.reading.plan.meshes
    }

    pub(super) fn terms(&self, mesh: usize, initial_state: InitialState, feed_through: bool) -> Vec<ModelTerm> {
        let plan = &self.reading.plan;
        let all = terms(&plan.designs[mesh].roles(), initial_state, feed_through, &self.reading.first_drives);
        let poles = &plan.meshes[mesh].poles_rad_s;
        let is_its = |term: &ModelTerm| match term.role {
            Role::Relaxation { bank, rate_rad_s, .. } => plan.is_seen(bank) && !poles.contains(&rate_rad_s),
            Role::FeedThrough { bank } => plan.is_seen(bank),
            Role::Initial { rate_rad_s } => !poles.contains(&rate_rad_s),
            Role::Offset | Role::DriftStart { .. } => true,
        };
        all.into_iter().filter(is_its).collect()
    }

    fn equations(&self, mesh: usize, initial_state: InitialState, feed_through: bool) -> FoldedEquations {
        let outputs = self.outputs();
        let terms = self.terms(mesh, initial_state, feed_through);
        FoldedEquations::of(&self.reading.passed.folds[mesh], terms, outputs, self.output)
    }

    pub(super) fn outputs(&self) -> usize {
        self.reading.plan.survey.outputs.len()
    }

    /// The choice for one output.
    pub fn choose(&self) -> Choice {
        let is_free = |&index: &usize| self.meshes()[index].free;
        let ordinary = || (0..self.meshes().len()).filter(|&index| self.meshes()[index].part == MeshPart::Ordinary);
        let mut trials: Vec<ScoredCandidate> = ordinary().filter(is_free).flat_map(|index| self.tried(index)).collect();
        let mut taken = best(&trials, self.meshes()).clone();
        let best = taken.score.clone();
        for index in ordinary().filter(|index| !is_free(index)) {
            let tried = self.tried(index);
            self.prefer_slow(&tried, &best, &mut taken);
            trials.extend(tried);
        }
        self.settle(taken, trials)
    }

    /// All candidates of one mesh.
    fn tried(&self, index: usize) -> Vec<ScoredCandidate> {
        let mut trials = Vec::new();
        for initial_state in initial_states(self.options.constraints.initial_state, &self.reading.first_drives) {
            for &feed_through in self.reading.plan.feed_throughs(&self.options.constraints) {
                self.try_priors(&mut trials, index, initial_state, feed_through);
            }
        }
        trials
    }

    /// Takes a candidate of a slow mesh in place of what is `taken`, if it is clearly better.
    /// `ordinary` is the score of the best other mesh.
    ///
    /// Poles far slower than the record are told from drift only if the initial state is known: if,
    /// on such a mesh, rest (or settled) predicts as well as an initial state that may be anything.
    fn prefer_slow(&self, tried: &[ScoredCandidate], ordinary: &Score, taken: &mut ScoredCandidate) {
        let free = tried.iter().filter(|trial| trial.initial_state == InitialState::Free);
        let free = free.min_by(|a, b| a.score.overall().total_cmp(&b.score.overall()));
        let halves = |own: &Score, other: &Score| own.overall() <= 0.25 * other.overall();
        for slow in tried.iter().filter(|trial| trial.initial_state != InitialState::Free) {
            let is_known = free.is_none_or(|free| slow.score.is_as_good_as(&free.score, 1.1));
            // Or it is evident: half the error of all ordinary meshes or less, and the free initial
            // state not half of that again.
            let is_evident =
                halves(&slow.score, ordinary) && !free.is_some_and(|free| halves(&free.score, &slow.score));
            let is_better =
                slow.score.overall() < taken.score.overall() && !taken.score.is_as_good_as(&slow.score, 1.1);
            if (is_evident || is_known && !self.meshes()[slow.mesh].fine) && is_better {
                *taken = slow.clone();
            }
        }
    }

    /// Slow rates and a initial state that may be anything explain the same drift: such candidates
    /// are for comparison only.
    fn is_fit(&self, trial: &ScoredCandidate) -> bool {
        self.meshes()[trial.mesh].free || trial.initial_state != InitialState::Free
    }

    /// The candidate that predicted held-out stretches best of all, but for chance, if it is not
    /// the choice.
    pub fn best_rival(&self, choice: &Choice) -> Option<Choice> {
        let fit = || choice.rivals.iter().filter(|trial| self.is_fit(trial));
        let best = fit().min_by(|a, b| a.score.overall().total_cmp(&b.score.overall()))?;
        let best = fit().find(|trial| trial.score.is_as_good_as(&best.score, 1.01)).unwrap_or(best);
        let is_other = best.score.overall() < choice.trial.score.overall();
        is_other.then(|| self.settle(best.clone(), choice.rivals.clone()))
    }

    fn try_priors(
        &self,
        trials: &mut Vec<ScoredCandidate>,
        index: usize,
        initial_state: InitialState,
        feed_through: bool,
    ) {
        let mesh = &self.meshes()[index];
        let equations = self.equations(index, initial_state, feed_through);
        let total = &equations.total;
        let of = |prior| equations.penalty(&self.reading.scales, prior);
        let mut candidates = priors(mesh, &self.options.constraints);
        if mesh.smooth {
            // Strength by generalised cross-validation: where the initial state is known and the
            // mesh is guarded, the noise is what is left.
            let gcv = |prior: &Prior| {
                let solution = total.solve(&of(*prior), None);
                libm::log(solution.rss) - 2.0 * libm::log((1.0 - solution.degrees / total.rows).max(1e-12))
            };
            let strength = candidates.iter().copied().min_by(|a, b| gcv(a).total_cmp(&gcv(b)));
            candidates = strength.into_iter().collect();
        }
        for prior in candidates {
            let score = equations.score(&of(prior), None);
            trials.push(ScoredCandidate { mesh: index, initial_state, feed_through, prior, score });
        }
    }

    /// Steady gains by bank, and their variances.
    pub(super) fn gains(&self, terms: &[ModelTerm], solution: &PenalisedSolution) -> Vec<(f64, f64)> {
        let of = |bank| steady_gain(terms, &solution.theta, &solution.covariance, bank);
        (0..self.reading.plan.parts.len()).map(of).collect()
    }

    /// Those that are for comparison only count as well: what a record leaves open is open. But
    /// what a rival is itself unsure of is not held against the choice.
    fn gain_spread(&self, taken: &ScoredCandidate, own: &[(f64, f64)], rivals: &[ScoredCandidate]) -> Vec<GainSpread> {
        let plausible =
            |rival: &&ScoredCandidate| *rival != taken && rival.score.is_plausible_beside(&taken.score, PLAUSIBLE);
        let mut squares = vec![Vec::new(); own.len()];
        for rival in rivals.iter().filter(plausible) {
            let terms = self.terms(rival.mesh, rival.initial_state, rival.feed_through);
            let gram = Gram::total(&self.reading.passed.folds[rival.mesh]);
            let total = NormalEquations::of(&gram, &terms, self.outputs(), self.output);
            let solution = total.solve(&self.reading.scales.penalty(rival.prior, &terms, &total), None);
            for ((squares, (gain, variance)), own) in squares.iter_mut().zip(self.gains(&terms, &solution)).zip(own) {
                squares.push(((gain - own.0).powi(2) - variance).max(0.0));
            }
        }
        own.iter().zip(squares).map(|(own, squares)| GainSpread::of(own.0, squares)).collect()
    }

    /// Makes a choice of a candidate: signs, solution, and how far others that may be the truth are
    /// from it.
    fn settle(&self, trial: ScoredCandidate, rivals: Vec<ScoredCandidate>) -> Choice {
        let equations = self.equations(trial.mesh, trial.initial_state, trial.feed_through);
        let penalty = equations.penalty(&self.reading.scales, trial.prior);
        let SignChoice { positive, reason: sign_reason, score } = self.held_signs(&equations, &penalty);
        let solution = equations.total.solve(&penalty, positive.as_deref());
        let gain_spread = self.gain_spread(&trial, &self.gains(&equations.terms, &solution), &rivals);
        let begun_at_zero = self.begun_at_zero(&trial, &equations, &penalty, positive.as_deref(), &solution);
        let solution = begun_at_zero.unwrap_or(solution);
        let terms = equations.terms;
        Choice { trial, score, terms, positive, solution, rivals, sign_reason, gain_spread, reason: None, drift: None }
    }

    /// For every term whether the input that drives it is held; `None`: it is driven by the
    /// surroundings.
    pub(super) fn mask(&self, terms: &[ModelTerm], is_held: &dyn Fn(Option<usize>) -> bool) -> Vec<bool> {
        let parts = &self.reading.plan.parts;
        let of_bank = |bank: usize| is_held(parts.get(bank).map(|part| part.input));
        terms.iter().map(|term| term.role.bank().is_some_and(of_bank)).collect()
    }

    /// Which parameters are held at or above zero, and why.
    fn held_signs(&self, equations: &FoldedEquations, penalty: &DMatrix<f64>) -> SignChoice {
        let mask = |is_held: &dyn Fn(Option<usize>) -> bool| self.mask(&equations.terms, is_held);
        let of = |positive: Option<Vec<bool>>, reason: String| {
            let score = equations.score(penalty, positive.as_deref());
            SignChoice { positive, reason, score }
        };
        match &self.options.signs {
            Signs::Any => return of(None, "signs: any, as asked for".to_owned()),
            Signs::AllPositive => return of(Some(mask(&|_| true)), "signs: none negative, as asked for".to_owned()),
            Signs::Positive(pairs) => {
                let held = |input: Option<usize>| input.is_some_and(|input| pairs.contains(&(input, self.output)));
                return of(Some(mask(&held)), "signs: none negative in the pairs asked for".to_owned());
            }
            Signs::Choose => {}
        }
        let free = of(None, String::new());
        // The dearer of all questions together and of interpolation, which knows best what noise
        // there is.
        let price = |held: &SignChoice| {
            let all = held.score.overall() / free.score.overall().max(1e-300);
            all.max(held.score.mean_single() / free.score.mean_single().max(1e-300))
        };
        let all = of(Some(mask(&|_| true)), String::new());
        let price_of_all = price(&all);
        if price_of_all <= DEAR {
            let reason = format!("signs: none negative (cross-validated error {})", change(price_of_all));
            return SignChoice { reason, ..all };
        }
        let own = mask(&|input| input == Some(self.output));
        if own.contains(&true) && all.positive.as_ref() != Some(&own) {
            let own = of(Some(own), "signs: own heat none negative, cross-heating any".to_owned());
            if price(&own) <= DEAR {
                return own;
            }
        }
        let reason = format!("signs: any (none negative: cross-validated error {})", change(price_of_all));
        SignChoice { reason, ..free }
    }

    /// From rest, an output that may as well have begun at zero did: one parameter less, and the
    /// steady gain is surer.
    fn begun_at_zero(
        &self,
        trial: &ScoredCandidate,
        equations: &FoldedEquations,
        penalty: &DMatrix<f64>,
        positive: Option<&[bool]>,
        solution: &PenalisedSolution,
    ) -> Option<PenalisedSolution> {
        if trial.initial_state != InitialState::Rest || self.options.constraints.mesh_is_fixed() {
            return None;
        }
        let offset = equations.terms.iter().position(|term| term.role == Role::Offset)?;
        let shift = self.reading.passed.output_shift[self.output];
        let value = solution.theta[offset] + shift;
        let is_zero = value.abs() < 2.0 * solution.covariance[(offset, offset)].sqrt();
        if !is_zero {
            return None;
        }
        let less = equations.total.with_known(offset, -shift);
        let penalty = penalty.clone().remove_row(offset).remove_column(offset);
        let held = positive.map(|positive| {
            let mut held = positive.to_vec();
            held.remove(offset);
            held
        });
        let known = less.solve(&penalty, held.as_deref());
        let with_known = |of: DMatrix<f64>| of.insert_row(offset, 0.0).insert_column(offset, 0.0);
        Some(PenalisedSolution {
            theta: known.theta.insert_row(offset, -shift),
            covariance: with_known(known.covariance),
            inverse: with_known(known.inverse),
            pulled: with_known(known.pulled),
            ..known
        })
    }
}

/// The most cautious trial on a mesh for any initial state that is as good as the best. Fine meshes
/// are left to a second opinion.
///
/// The lower edge first: the thesis' is kept unless its cross-validated error is more than a tenth
/// greater. Then, among those of that edge, the first within one percent, if the folds do not agree
/// that it is worse.
fn best<'t>(trials: &'t [ScoredCandidate], meshes: &[CandidateMesh]) -> &'t ScoredCandidate {
    let is_of = |trial: &&ScoredCandidate, edge: f64| meshes[trial.mesh].factor >= edge && !meshes[trial.mesh].fine;
    let least = |edge: f64| {
        let of_edge = trials.iter().filter(|trial| is_of(trial, edge));
        of_edge.min_by(|a, b| a.score.overall().total_cmp(&b.score.overall())).unwrap_or(&trials[0])
    };
    let bar = 1.1 * 1.1 * least(0.0).score.overall();
    let good = trials.iter().filter(|trial| is_of(trial, 0.0) && trial.score.overall() <= bar);
    let edge = good.map(|trial| meshes[trial.mesh].factor).fold(0.0, f64::max);
    let best = least(edge);
    let cautious = |trial: &&ScoredCandidate| is_of(trial, edge) && trial.score.is_as_good_as(&best.score, 1.01);
    trials.iter().find(cautious).unwrap_or(best)
}

impl GainSpread {
    /// 0 for none.
    fn of(gain: f64, mut squares: Vec<f64>) -> Self {
        squares.sort_by(f64::total_cmp);
        let at = |part: f64| squares.get((part * squares.len() as f64) as usize).copied().unwrap_or(0.0).sqrt();
        Self { gain, median: at(0.5), upper_decile: at(0.9) }
    }
}
