//! Choosing for the user: every candidate scored by block cross-validation, the best one taken, and the reasons kept.
//!
//! Candidates are ordered from the most to the least cautious (higher edge, known beginning, stronger prior), and the most cautious
//! one is taken that is as good as the best but for chance. Then the signs: if holding all resistances at or
//! above zero costs no more than 5 % of the error, physics is kept; else those of an element's own heat alone; else none.

use nalgebra::DMatrix;

use super::candidates::{Beginning, Given, Mesh, priors, terms};
use super::design::{Design, Role};
use super::folds::{Score, score};
use super::gram::Gram;
use super::prior::{Prior, Scales};
use super::problem::{Problem, Solution, Term};

/// Candidates whose held-out error is at most that many times the choice's may be the truth as well.
const PLAUSIBLE: f64 = 1.05;

/// A candidate of one mesh, taken or not.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    pub mesh: usize,
    pub beginning: Beginning,
    pub feed_through: bool,
    pub prior: Prior,
    pub score: Score,
}

/// What one output's model was decided to be.
#[derive(Debug, Clone)]
pub struct Choice {
    pub trial: Trial,
    pub terms: Vec<Term>,
    pub penalty: DMatrix<f64>,
    /// For every term, whether it is held at or above zero.
    pub positive: Option<Vec<bool>>,
    pub solution: Solution,
    pub rivals: Vec<Trial>,
    pub sign_reason: String,
    /// By bank: how far candidates that predict about as well differ from it in the steady gain.
    pub gain_spread: Vec<Spread>,
    /// Why it is not the first choice, if it is not.
    pub reason: Option<String>,
}

/// Which resistances may not be negative.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Signs {
    /// Whatever cross-validation does not speak against.
    #[default]
    Choose,
    Any,
    /// Those of the banks of these inputs (by pair: input and output).
    Positive(Vec<(usize, usize)>),
    AllPositive,
}

impl Signs {
    /// Whether a pair was asked to have no negative resistances.
    pub fn asks(&self, input: usize, output: usize) -> bool {
        match self {
            Self::Choose | Self::Any => false,
            Self::Positive(pairs) => pairs.contains(&(input, output)),
            Self::AllPositive => true,
        }
    }
}

/// Absolute differences of others' steady gains from a choice's own, K/W.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Spread {
    pub gain: f64,
    pub median: f64,
    pub upper_decile: f64,
}

/// Everything that a choice is made from.
pub struct Field<'a> {
    pub meshes: &'a [Mesh],
    pub designs: &'a [Design],
    /// By design: the folds of one reading.
    pub folds: &'a [Vec<Gram>],
    pub scales: &'a Scales,
    /// What drove each bank in the first row, and which input it belongs to.
    pub first_drives: &'a [f64],
    pub bank_input: &'a [usize],
    pub outputs: usize,
    /// What was subtracted from the outputs.
    pub output_shift: &'a [f64],
    /// Banks that this output sees.
    pub sees: &'a dyn Fn(usize) -> bool,
    /// Whether feed-through columns are in the designs, and may be left out.
    pub feed_through: &'a [bool],
}

impl Field<'_> {
    fn terms(&self, mesh: usize, beginning: Beginning, feed_through: bool) -> Vec<Term> {
        let all = terms(&self.designs[mesh].roles(), beginning, feed_through, self.first_drives);
        let seen = |term: &Term| match term.role {
            Role::Relaxation { bank, .. } | Role::FeedThrough { bank } => (self.sees)(bank),
            Role::Initial { .. } | Role::Offset => true,
        };
        all.into_iter().filter(seen).collect()
    }

    fn beginnings(&self, given: &Given) -> Vec<Beginning> {
        if let Some(beginning) = given.beginning {
            return vec![beginning];
        }
        let mut beginnings = vec![Beginning::Rest];
        if self.first_drives.iter().any(|&drive| drive != 0.0) {
            beginnings.push(Beginning::Settled);
        }
        beginnings.push(Beginning::Free);
        beginnings
    }

    /// The choice for one output.
    pub fn choose(&self, given: &Given, signs: &Signs, output: usize) -> Choice {
        let mut trials = Vec::new();
        let tried = |trials: &mut Vec<Trial>, index: usize, beginning| {
            for &feed_through in self.feed_through {
                self.try_priors(trials, index, beginning, feed_through, given, output);
            }
        };
        for index in (0..self.meshes.len()).filter(|&index| self.meshes[index].free) {
            for beginning in self.beginnings(given) {
                tried(&mut trials, index, beginning);
            }
        }
        let mut taken = best(&trials, self.meshes).clone();
        let ordinary = taken.score.clone();
        // Poles far slower than the record are told from drift only if the beginning is known: if, on such a mesh, rest (or settled)
        // predicts as well as a beginning that may be anything.
        for index in (0..self.meshes.len()).filter(|&index| !self.meshes[index].free) {
            let first = trials.len();
            for beginning in self.beginnings(given) {
                tried(&mut trials, index, beginning);
            }
            let free = trials[first..].iter().filter(|trial| trial.beginning == Beginning::Free);
            let free = free.min_by(|a, b| a.score.overall().total_cmp(&b.score.overall())).cloned();
            for slow in trials[first..].iter().filter(|trial| trial.beginning != Beginning::Free) {
                let is_known = free.as_ref().is_none_or(|free| slow.score.is_as_good_as(&free.score, 1.1));
                // Or it is evident: half the error of all ordinary meshes or less, and the free beginning not half of that again.
                let halves = |own: &Score, other: &Score| own.overall() <= 0.25 * other.overall();
                let is_evident = halves(&slow.score, &ordinary)
                    && !free.as_ref().is_some_and(|free| halves(&free.score, &slow.score));
                let is_better =
                    slow.score.overall() < taken.score.overall() && !taken.score.is_as_good_as(&slow.score, 1.1);
                if (is_evident || is_known && !self.meshes[index].fine) && is_better {
                    taken = slow.clone();
                }
            }
        }
        self.settle(taken, trials, given, signs, output)
    }

    /// Slow rates and a beginning that may be anything explain the same drift: such candidates are for comparison only.
    fn is_fit(&self, trial: &Trial) -> bool {
        self.meshes[trial.mesh].free || trial.beginning != Beginning::Free
    }

    /// The candidate that predicted held-out stretches best of all, but for chance, if it is not the choice.
    pub fn best_rival(&self, choice: &Choice, given: &Given, signs: &Signs, output: usize) -> Option<Choice> {
        let fit = || choice.rivals.iter().filter(|trial| self.is_fit(trial));
        let best = fit().min_by(|a, b| a.score.overall().total_cmp(&b.score.overall()))?;
        let best = fit().find(|trial| trial.score.is_as_good_as(&best.score, 1.01)).unwrap_or(best);
        let is_other = best.score.overall() < choice.trial.score.overall();
        is_other.then(|| self.settle(best.clone(), choice.rivals.clone(), given, signs, output))
    }

    fn try_priors(
        &self,
        trials: &mut Vec<Trial>,
        index: usize,
        beginning: Beginning,
        feed_through: bool,
        given: &Given,
        output: usize,
    ) {
        let mesh = &self.meshes[index];
        let terms = self.terms(index, beginning, feed_through);
        let folds = self.problems(index, &terms, output);
        let total = folds[1..].iter().fold(folds[0].clone(), |sum, fold| sum.plus(fold));
        let of = |prior| self.scales.penalty(prior, &terms, &total);
        let mut candidates = priors(mesh, given);
        if mesh.smooth {
            // Strength by generalised cross-validation: where the beginning is known and the mesh is guarded, the noise is what is left.
            let gcv = |prior: &Prior| {
                let solution = total.solve(&of(*prior), None);
                solution.rss.ln() - 2.0 * (1.0 - solution.degrees / total.rows).max(1e-12).ln()
            };
            let strength = candidates.iter().copied().min_by(|a, b| gcv(a).total_cmp(&gcv(b)));
            candidates = strength.into_iter().collect();
        }
        for prior in candidates {
            let score = score(&folds, &total, &of(prior), None);
            trials.push(Trial { mesh: index, beginning, feed_through, prior, score });
        }
    }

    /// Steady gains by bank, and their variances.
    fn gains(&self, terms: &[Term], solution: &Solution) -> Vec<(f64, f64)> {
        let of = |bank: usize| {
            let is_its = |&index: &usize| match terms[index].role {
                Role::Relaxation { bank: own, .. } | Role::FeedThrough { bank: own } => own == bank,
                Role::Initial { .. } | Role::Offset => false,
            };
            let its: Vec<usize> = (0..terms.len()).filter(is_its).collect();
            let pairs = its.iter().flat_map(|&i| its.iter().map(move |&j| (i, j)));
            let variance: f64 = pairs.map(|at| solution.covariance[at]).sum();
            (its.iter().map(|&i| solution.theta[i]).sum(), variance.max(0.0))
        };
        (0..self.bank_input.len()).map(of).collect()
    }

    /// Those that are for comparison only count as well: what a record leaves open is open. But what a rival is itself unsure of
    /// is not held against the choice.
    fn gain_spread(&self, taken: &Trial, own: &[(f64, f64)], rivals: &[Trial], output: usize) -> Vec<Spread> {
        let plausible = |rival: &&Trial| *rival != taken && rival.score.is_plausible_beside(&taken.score, PLAUSIBLE);
        let mut squares = vec![Vec::new(); own.len()];
        for rival in rivals.iter().filter(plausible) {
            let terms = self.terms(rival.mesh, rival.beginning, rival.feed_through);
            let total = Problem::of(&Gram::total(&self.folds[rival.mesh]), &terms, self.outputs, output);
            let solution = total.solve(&self.scales.penalty(rival.prior, &terms, &total), None);
            for ((squares, (gain, variance)), own) in squares.iter_mut().zip(self.gains(&terms, &solution)).zip(own) {
                squares.push(((gain - own.0).powi(2) - variance).max(0.0));
            }
        }
        own.iter().zip(squares).map(|(own, squares)| Spread::of(own.0, squares)).collect()
    }

    fn problems(&self, mesh: usize, terms: &[Term], output: usize) -> Vec<Problem> {
        self.folds[mesh].iter().map(|fold| Problem::of(fold, terms, self.outputs, output)).collect()
    }

    fn settle(&self, trial: Trial, rivals: Vec<Trial>, given: &Given, signs: &Signs, output: usize) -> Choice {
        let terms = self.terms(trial.mesh, trial.beginning, trial.feed_through);
        let folds = self.problems(trial.mesh, &terms, output);
        let total = folds[1..].iter().fold(folds[0].clone(), |sum, fold| sum.plus(fold));
        let penalty = self.scales.penalty(trial.prior, &terms, &total);
        let mask = |held: &dyn Fn(usize) -> bool| -> Vec<bool> {
            let of = |term: &Term| match term.role {
                Role::Relaxation { bank, .. } | Role::FeedThrough { bank } => held(self.bank_input[bank]),
                Role::Initial { .. } | Role::Offset => false,
            };
            terms.iter().map(of).collect()
        };
        let (positive, sign_reason) = match signs {
            Signs::Any => (None, "signs: any, as asked for".to_owned()),
            Signs::AllPositive => (Some(mask(&|_| true)), "signs: none negative, as asked for".to_owned()),
            Signs::Positive(pairs) => {
                let held = |input| pairs.contains(&(input, output));
                (Some(mask(&held)), "signs: none negative in the pairs asked for".to_owned())
            }
            Signs::Choose => {
                let free = score(&folds, &total, &penalty, None);
                // The dearer of all questions together and of interpolation, which knows best what noise there is.
                let price = |held: &Vec<bool>| {
                    let own = score(&folds, &total, &penalty, Some(held));
                    let all = own.overall() / free.overall().max(1e-300);
                    all.max(own.mean_single() / free.mean_single().max(1e-300))
                };
                let all = mask(&|_| true);
                let own = mask(&|input| input == output);
                let price_of_all = price(&all);
                if price_of_all <= 1.05 {
                    (Some(all), format!("signs: none negative (held-out error {})", change(price_of_all)))
                } else if own.contains(&true) && own != all && price(&own) <= 1.05 {
                    (Some(own), "signs: own heat none negative, cross-heating any".to_owned())
                } else {
                    (None, format!("signs: any (none negative: held-out error {})", change(price_of_all)))
                }
            }
        };
        let solution = total.solve(&penalty, positive.as_deref());
        let gain_spread = self.gain_spread(&trial, &self.gains(&terms, &solution), &rivals, output);
        // From rest, an output that may as well have begun at zero did: one parameter less, and the steady gain is surer.
        let offset = terms.iter().position(|term| term.role == Role::Offset);
        if let (Some(offset), Beginning::Rest, false) = (offset, trial.beginning, given.mesh_is_fixed()) {
            let value = solution.theta[offset] + self.output_shift[output];
            if value.abs() < 2.0 * solution.covariance[(offset, offset)].sqrt() {
                let less = total.with_known(offset, -self.output_shift[output]);
                let penalty = penalty.clone().remove_row(offset).remove_column(offset);
                let held = positive.clone().map(|mut held| {
                    held.remove(offset);
                    held
                });
                let known = less.solve(&penalty, held.as_deref());
                let with_known = |of: DMatrix<f64>| of.insert_row(offset, 0.0).insert_column(offset, 0.0);
                let solution = Solution {
                    theta: known.theta.insert_row(offset, -self.output_shift[output]),
                    covariance: with_known(known.covariance),
                    inverse: with_known(known.inverse),
                    pulled: with_known(known.pulled),
                    ..known
                };
                return Choice {
                    trial,
                    terms,
                    penalty,
                    positive,
                    solution,
                    rivals,
                    sign_reason,
                    gain_spread,
                    reason: None,
                };
            }
        }
        Choice { trial, terms, penalty, positive, solution, rivals, sign_reason, gain_spread, reason: None }
    }
}

/// The most cautious trial on a mesh for any beginning that is as good as the best. Fine meshes are left to a second opinion.
///
/// The lower edge first: the thesis' is kept unless its held-out error is more than a tenth greater. Then, among those of that edge,
/// the first within one percent, if the folds do not agree that it is worse.
fn best<'t>(trials: &'t [Trial], meshes: &[Mesh]) -> &'t Trial {
    let is_of = |trial: &&Trial, edge: f64| meshes[trial.mesh].factor >= edge && !meshes[trial.mesh].fine;
    let least = |edge: f64| {
        let of_edge = trials.iter().filter(|trial| is_of(trial, edge));
        of_edge.min_by(|a, b| a.score.overall().total_cmp(&b.score.overall())).unwrap_or(&trials[0])
    };
    let bar = 1.1 * 1.1 * least(0.0).score.overall();
    let good = trials.iter().filter(|trial| is_of(trial, 0.0) && trial.score.overall() <= bar);
    let edge = good.map(|trial| meshes[trial.mesh].factor).fold(0.0, f64::max);
    let best = least(edge);
    let cautious = |trial: &&Trial| is_of(trial, edge) && trial.score.is_as_good_as(&best.score, 1.01);
    trials.iter().find(cautious).unwrap_or(best)
}

impl Spread {
    /// 0 for none.
    fn of(gain: f64, mut squares: Vec<f64>) -> Self {
        squares.sort_by(f64::total_cmp);
        let at = |part: f64| squares.get((part * squares.len() as f64) as usize).copied().unwrap_or(0.0).sqrt();
        Self { gain, median: at(0.5), upper_decile: at(0.9) }
    }
}

/// A ratio of mean squared errors as a change of the root in percent.
pub fn change(ratio: f64) -> String {
    format!("{:+.1} %", 100.0 * (ratio.sqrt() - 1.0))
}
