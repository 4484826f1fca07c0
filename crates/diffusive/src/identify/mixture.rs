//! One model of several candidates: the mean of what they say, and how far they differ.
//!
//! ```text
//! θ̄ = Σ_c w_c θ_c,     cov = Σ_c w_c (cov_c + (θ_c − θ̄)(θ_c − θ̄)ᵀ)
//! ```
//!
//! Candidates of several meshes stand on one that has the rates of all. Standard errors hold what
//! each is unsure of and the choice between them.
//!
//! How well a candidate carries on is judged as for others ([`super::folds`]): from five to eight
//! tenths of the record, and with the drift's last level.

use nalgebra::{DMatrix, DVector};

use super::choose::CandidateSet;
use super::design::{RegressionDesign, Role};
use super::drift::{DriftKind, NoiseFilter, PoleColumns};
use super::folds::borders;
use super::gram::Gram;
use super::normal_equations::{ModelTerm, NormalEquations, PenalisedSolution, in_columns};
use super::options::{InitialState, Signs};
use super::prior::Prior;

/// A candidate with or without a drift.
#[derive(Debug, Clone)]
pub struct MixtureCandidate {
    pub mesh: usize,
    pub initial_state: InitialState,
    pub feed_through: bool,
    pub prior: Prior,
    pub filter: Option<NoiseFilter>,
}

/// What it says of the record.
pub struct MixtureMember {
    pub candidate: MixtureCandidate,
    pub solution: PenalisedSolution,
    pub terms: Vec<ModelTerm>,
    /// Level behind the last row, K.
    pub level_k: f64,
    /// Mean squared errors ahead, border by border, K².
    pub ahead: Vec<f64>,
    pub held: Option<Vec<bool>>,
}

/// The mean of members, in the terms of a design that has the columns of all.
pub struct Mixture {
    pub terms: Vec<ModelTerm>,
    pub solution: PenalisedSolution,
    pub level_k: f64,
    /// Mean squared errors ahead, border by border, K².
    pub ahead: Vec<f64>,
}

impl CandidateSet<'_> {
    pub fn columns(&self, mesh: usize) -> PoleColumns {
        PoleColumns::of(&self.reading.plan.designs[mesh], self.reading.plan.survey.sample_period_s)
    }

    /// The candidate's problem on some of the sums, and what it weighs.
    pub fn problem(&self, of: &MixtureCandidate, gram: &Gram) -> (Vec<ModelTerm>, NormalEquations) {
        let terms = self.terms(of.mesh, of.initial_state, of.feed_through);
        let columns = self.columns(of.mesh);
        columns.problem(gram, &terms, self.output, of.filter.as_ref())
    }

    /// Solves a candidate, and lets it predict what lies ahead.
    pub fn member(&self, candidate: MixtureCandidate, total: &Gram) -> MixtureMember {
        let folds = &self.reading.passed.folds[candidate.mesh];
        let ends = &self.reading.passed.ends[candidate.mesh];
        let (terms, problem) = self.problem(&candidate, total);
        let penalty = self.reading.scales.penalty(candidate.prior, &terms, &problem);
        let held = self.signs(&candidate, &terms, &problem, &penalty);
        let mut solution = solved(&problem, &penalty, held.as_deref());
        if candidate.filter.is_some() {
            self.widen(&candidate, &terms, &mut solution);
        }
        let level_k = self.level(&candidate, &terms, &solution.theta, &ends[ends.len() - 1]);
        let period_s = self.reading.plan.survey.sample_period_s;
        let ahead = |seen: usize| {
            let (_, training) = self.problem(&candidate, &Gram::total(&folds[..seen]));
            let mut theta = training.estimate(&penalty, held.as_deref());
            let rest = Gram::total(&folds[seen..]);
            let left = candidate.filter.as_ref().map_or(1.0, |filter| filter.left_within(rest.rows as f64 * period_s));
            let level_k = left * self.level(&candidate, &terms, &theta, &ends[seen - 1]);
            if let Some(offset) = terms.iter().position(|term| term.role == Role::Offset) {
                theta[offset] += level_k;
            }
            let test = NormalEquations::of(&rest, &terms, self.outputs(), self.output);
            test.squared_error(&theta) / test.rows.max(1.0)
        };
        let ahead = borders(folds.len()).map(ahead).collect();
        MixtureMember { candidate, solution, terms, level_k, ahead, held }
    }

    /// Adds what the folds' scores show beyond what white innovations would: a drift that is none
    /// of the filter's kind pulls whole folds the same way.
    ///
    /// g_f = b_f − G_f θ of fold f has covariance σ² G_f; H⁻¹ Σ g gᵀ H⁻¹ is what θ is then unsure
    /// by (P. J. Huber, *Proc. 5th Berkeley Symp.* 1 (1967) 221).
    fn widen(&self, of: &MixtureCandidate, terms: &[ModelTerm], solution: &mut PenalisedSolution) {
        let folds = &self.reading.passed.folds[of.mesh];
        let mut seen = DMatrix::zeros(terms.len(), terms.len());
        for fold in folds {
            let (_, problem) = self.problem(of, fold);
            let moved = &solution.inverse * (&problem.b - &problem.g * &solution.theta);
            seen += &moved * moved.transpose();
        }
        let parts = self.reading.plan.parts.len();
        let gain = |bank: usize, of: &DMatrix<f64>| super::fitted::steady_gain(terms, &solution.theta, of, bank).1;
        let ratio = |bank: usize| gain(bank, &seen) / gain(bank, &solution.covariance).max(f64::MIN_POSITIVE);
        let most = (0..parts).map(ratio).fold(0.0, f64::max);
        if most > WIDER {
            solution.covariance *= most;
        }
        // A smooth drift and a relaxation that is hardly faster than the record look alike: either
        // may be the other.
        if of.filter.as_ref().is_some_and(|filter| filter.kind == DriftKind::IntegratedWalk) {
            let slow_rad_s = SLOW * self.reading.scales.thesis_rad_s;
            for bank in 0..parts {
                let is_slow = |term: &ModelTerm| matches!(term.role, Role::Relaxation { bank: own, rate_rad_s, .. } if own == bank && rate_rad_s <= slow_rad_s);
                let slow =
                    DVector::from_fn(terms.len(), |at, _| if is_slow(&terms[at]) { solution.theta[at] } else { 0.0 });
                solution.covariance.ger(1.0, &slow, &slow, 1.0);
            }
        }
    }

    fn level(&self, of: &MixtureCandidate, terms: &[ModelTerm], theta: &DVector<f64>, next: &[f64]) -> f64 {
        let Some(filter) = &of.filter else { return 0.0 };
        let columns = self.columns(of.mesh);
        let design = &self.reading.plan.designs[of.mesh];
        let weights = in_columns(terms, theta, design.width());
        let explained = weights.into_iter().enumerate().filter(|(_, weight)| *weight != 0.0);
        let mut residual: Vec<(usize, f64)> = explained.map(|(column, weight)| (column, -weight)).collect();
        residual.push((columns.output(self.output), 1.0));
        columns.level(&residual, filter, next)
    }

    /// Which parameters are held at or above zero: as asked for; else all of them, where the record
    /// does not contradict.
    fn signs(
        &self,
        of: &MixtureCandidate,
        terms: &[ModelTerm],
        problem: &NormalEquations,
        penalty: &DMatrix<f64>,
    ) -> Option<Vec<bool>> {
        let mask = |is_held: &dyn Fn(Option<usize>) -> bool| self.mask(terms, is_held);
        match &self.options.signs {
            Signs::Any => None,
            Signs::AllPositive => Some(mask(&|_| true)),
            Signs::Positive(pairs) => {
                Some(mask(&|input| input.is_some_and(|input| pairs.contains(&(input, self.output)))))
            }
            Signs::Choose if of.filter.is_none() => None,
            Signs::Choose => {
                let all = mask(&|_| true);
                let held = problem.estimate(penalty, Some(&all));
                let clamped = held.iter().zip(&all).filter(|(theta, held)| **held && **theta == 0.0).count();
                let cost = |theta: &DVector<f64>| problem.squared_error(theta) + theta.dot(&(penalty * theta));
                let price = problem.rows * libm::log(cost(&held) / cost(&problem.estimate(penalty, None)));
                (price <= CONTRADICTED + 2.0 * clamped as f64).then_some(all)
            }
        }
    }

    /// The members' mean, each with its weight, in the terms of design `mesh`.
    pub fn mixed(&self, members: &[MixtureMember], weights: &[f64], mesh: usize, feed_through: bool) -> Mixture {
        let plan = &self.reading.plan;
        let terms = self.terms(mesh, InitialState::Free, feed_through);
        let count = terms.len();
        let whole: f64 = weights.iter().sum();
        let mapped = |member: &MixtureMember| mapping(&plan.designs[member.candidate.mesh], &member.terms, &terms);
        let maps: Vec<DMatrix<f64>> = members.iter().map(mapped).collect();
        let thetas: Vec<DVector<f64>> =
            members.iter().zip(&maps).map(|(member, map)| map * &member.solution.theta).collect();
        let share = |at: usize| weights[at] / whole;
        let mut theta = DVector::zeros(count);
        thetas.iter().enumerate().for_each(|(at, own)| theta += own * share(at));
        let mut covariance = DMatrix::zeros(count, count);
        for (at, member) in members.iter().enumerate() {
            let apart = &thetas[at] - &theta;
            covariance += (&maps[at] * &member.solution.covariance * maps[at].transpose() + &apart * apart.transpose())
                * share(at);
        }
        let mean = |of: &dyn Fn(&MixtureMember) -> f64| {
            members.iter().enumerate().map(|(at, member)| share(at) * of(member)).sum::<f64>()
        };
        let noise_variance = mean(&|member| member.solution.noise_variance);
        let solution = PenalisedSolution {
            theta,
            inverse: &covariance / noise_variance.max(f64::MIN_POSITIVE),
            pulled: DMatrix::zeros(count, count),
            covariance,
            rss: mean(&|member| member.solution.rss),
            degrees: mean(&|member| member.solution.degrees),
            noise_variance,
        };
        let borders = members.first().map_or(0, |member| member.ahead.len());
        Mixture {
            terms,
            solution,
            level_k: mean(&|member| member.level_k),
            // An average errs less than its members do: those of opposite signs cancel.
            ahead: (0..borders)
                .map(|border| libm::exp(mean(&|member| libm::log(member.ahead[border].max(1e-300)))))
                .collect(),
        }
    }
}

/// Rates up to so many times 2π/T are hardly told from a smooth drift.
const SLOW: f64 = 2.0;

/// Ratio of variances from which on folds are believed: ten folds show theirs to a factor of two.
const WIDER: f64 = 2.0;

/// Twice the logarithm of a likelihood ratio, beyond two for every resistance that is held at zero,
/// by which a record contradicts signs.
const CONTRADICTED: f64 = 8.0;

/// A solution in which what is held at zero is known to be zero.
fn solved(problem: &NormalEquations, penalty: &DMatrix<f64>, held: Option<&[bool]>) -> PenalisedSolution {
    let Some(held) = held else { return problem.solve(penalty, None) };
    let theta = problem.estimate(penalty, Some(held));
    let clamped: Vec<usize> = (0..theta.len()).filter(|&at| held[at] && theta[at] == 0.0).collect();
    let (mut rest, mut prior) = (problem.clone(), penalty.clone());
    for &at in clamped.iter().rev() {
        rest = rest.with_known(at, 0.0);
        prior = prior.remove_row(at).remove_column(at);
    }
    let own = rest.solve(&prior, None);
    let (mut theta, mut covariance) = (own.theta, own.covariance);
    let (mut inverse, mut pulled) = (own.inverse, own.pulled);
    for &at in &clamped {
        theta = theta.insert_row(at, 0.0);
        for matrix in [&mut covariance, &mut inverse, &mut pulled] {
            let old = std::mem::replace(matrix, DMatrix::zeros(0, 0));
            *matrix = old.insert_row(at, 0.0).insert_column(at, 0.0);
        }
    }
    PenalisedSolution { theta, covariance, inverse, pulled, ..own }
}

/// Terms of one design as sums of the terms of another that has the same rates among its own.
fn mapping(design: &RegressionDesign, from: &[ModelTerm], to: &[ModelTerm]) -> DMatrix<f64> {
    let roles = design.roles();
    let is_same = |a: &Role, b: &Role| match (a, b) {
        (Role::Relaxation { bank: a, rate_rad_s: p, .. }, Role::Relaxation { bank: b, rate_rad_s: q, .. }) => {
            a == b && p == q
        }
        (Role::Initial { rate_rad_s: p }, Role::Initial { rate_rad_s: q }) => p == q,
        (a, b) => a == b,
    };
    let mut map = DMatrix::zeros(to.len(), from.len());
    for (column, term) in from.iter().enumerate() {
        for &(of, weight) in &term.of {
            if let Some(row) = to.iter().position(|term| is_same(&term.role, &roles[of])) {
                map[(row, column)] += weight;
            }
        }
    }
    map
}
