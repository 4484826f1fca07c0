//! Block cross-validation: how well a candidate predicts stretches of the record that it has not
//! seen.
//!
//! The record is cut into folds of like length. Four questions are asked of a candidate, each a
//! mean squared error per row:
//!
//! | scheme | held out | question |
//! |---|---|---|
//! | single | every fold but the first | does it interpolate? |
//! | double | every pair of neighbours but the first | does it bridge a longer gap? |
//! | ahead | all that comes behind 5, 6, 7 and 8 tenths | does it carry on? |
//! | begin | nothing | does it explain the first fold? |
//!
//! A candidate is worth the geometric mean of its answers: drift that a slow pole explains passes
//! the first question and fails the third. The first fold is never held out, because nothing else
//! tells what state the record began with; but who assumes a state there must fit it. The inputs of
//! held-out stretches are known, only their outputs are not.

use nalgebra::DMatrix;

use super::gram::Gram;
use super::normal_equations::{ModelTerm, NormalEquations};
use super::prior::{Prior, Scales};

pub const FOLDS: usize = 10;

/// One output's problem in some terms.
pub struct FoldedEquations {
    pub terms: Vec<ModelTerm>,
    pub folds: Vec<NormalEquations>,
    /// Their sum.
    pub total: NormalEquations,
}

impl FoldedEquations {
    /// `output` counts the outputs, which stand last in the sums.
    pub fn of(folds: &[Gram], terms: Vec<ModelTerm>, outputs: usize, output: usize) -> Self {
        let y = folds[0].sums.ncols() - outputs + output;
        Self::of_sum(folds, terms, &[(y, 1.0)])
    }

    /// The same for an output that is a sum of columns.
    pub fn of_sum(folds: &[Gram], terms: Vec<ModelTerm>, output: &[(usize, f64)]) -> Self {
        let of = |fold| NormalEquations::of_sum(fold, &terms, output);
        let folds: Vec<NormalEquations> = folds.iter().map(of).collect();
        let total = NormalEquations::total(&folds);
        Self { terms, folds, total }
    }

    /// What a prior adds to the sum.
    pub fn penalty(&self, scales: &Scales, prior: Prior) -> DMatrix<f64> {
        scales.penalty(prior, &self.terms, &self.total)
    }

    /// Cross-validates a penalty.
    pub fn score(&self, penalty: &DMatrix<f64>, positive: Option<&[bool]>) -> Score {
        score(&self.folds, &self.total, penalty, positive)
    }
}

/// Mean squared errors, K², of one candidate.
#[derive(Debug, Clone, PartialEq)]
pub struct Score {
    /// Fold by fold, without the first.
    pub single: Vec<f64>,
    pub double: f64,
    /// Border by border.
    pub ahead: Vec<f64>,
    pub begin: f64,
}

impl Score {
    /// The geometric mean of the answers, K²: each counts by its ratios, so that a question that
    /// nobody can answer does not drown the others. The first fold stands among the single ones.
    pub fn overall(&self) -> f64 {
        let logs = [self.mean_all(), self.double, self.mean_ahead()].map(|error| libm::log(error.max(1e-300)));
        libm::exp(logs.iter().sum::<f64>() / 3.0)
    }

    /// Whether the root mean square is at most `ratio` times the other's, and the folds do not
    /// agree that it is greater: their paired differences, in which the noise of a fold cancels,
    /// are within one standard error of zero.
    pub fn is_as_good_as(&self, other: &Self, ratio: f64) -> bool {
        let (mean, sd) = mean_and_sd(self.single.iter().zip(&other.single).map(|(own, other)| own - other));
        self.overall() <= ratio * ratio * other.overall() && mean <= sd / (self.single.len() as f64).sqrt()
    }

    /// Whether it may be the truth where the other is taken for it: at most `ratio` times the root
    /// mean square, the folds within two standard errors, and the first fold, which shows a wrong
    /// initial state, within three standard deviations of how folds differ.
    pub fn is_plausible_beside(&self, other: &Self, ratio: f64) -> bool {
        let log = |own: f64, other: f64| libm::log(own.max(1e-300) / other.max(1e-300));
        let (mean, sd) = mean_and_sd(self.single.iter().zip(&other.single).map(|(own, other)| log(*own, *other)));
        self.overall() <= ratio * ratio * other.overall()
            && mean <= 2.0 * sd / (self.single.len() as f64).sqrt()
            && log(self.begin, other.begin) <= mean + 3.0 * sd
    }

    /// The geometric mean: the borders' errors are those of unlike lengths ahead.
    pub fn mean_ahead(&self) -> f64 {
        geometric_mean(&self.ahead)
    }

    /// Errors of all folds, the first one included.
    pub fn all(&self) -> impl Iterator<Item = f64> {
        self.single.iter().copied().chain([self.begin])
    }

    pub fn mean_all(&self) -> f64 {
        let count = self.single.len() as f64;
        (self.mean_single() * count + self.begin) / (count + 1.0)
    }

    pub fn mean_single(&self) -> f64 {
        self.single.iter().sum::<f64>() / self.single.len().max(1) as f64
    }

    /// Root mean square of the single scheme, and its standard error over the folds, K.
    pub fn rms_and_se(&self) -> (f64, f64) {
        let (mean, count) = (self.mean_single(), self.single.len() as f64);
        let variance = self.single.iter().map(|error| (error - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
        let rms = mean.sqrt();
        // d√m = dm / 2√m
        (rms, (variance / count).sqrt() / (2.0 * rms).max(f64::MIN_POSITIVE))
    }
}

pub fn mean_and_sd(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let n = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / n;
    (mean, (values.map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0)).sqrt())
}

/// Scores a penalty on the normal equations of all folds. `total` is their sum.
pub fn score(
    folds: &[NormalEquations],
    total: &NormalEquations,
    penalty: &DMatrix<f64>,
    positive: Option<&[bool]>,
) -> Score {
    let held_out = |training: &NormalEquations, tests: &[NormalEquations]| {
        let theta = training.estimate(penalty, positive);
        let rows: f64 = tests.iter().map(|test| test.rows).sum();
        tests.iter().map(|test| test.squared_error(&theta)).sum::<f64>() / rows.max(1.0)
    };
    let single =
        folds.iter().skip(1).map(|fold| held_out(&total.minus(fold), std::slice::from_ref(fold))).collect::<Vec<_>>();
    let pairs: Vec<f64> =
        folds[1..].chunks_exact(2).map(|pair| held_out(&total.minus(&pair[0]).minus(&pair[1]), pair)).collect();
    let ahead: Vec<f64> =
        borders(folds.len()).map(|seen| held_out(&NormalEquations::total(&folds[..seen]), &folds[seen..])).collect();
    let mean = |errors: &[f64]| errors.iter().sum::<f64>() / errors.len().max(1) as f64;
    let begin = folds[0].squared_error(&total.estimate(penalty, positive)) / folds[0].rows.max(1.0);
    Score { double: mean(&pairs), ahead, begin, single }
}

/// How many folds train where the rest lies ahead.
pub fn borders(folds: usize) -> impl Iterator<Item = usize> {
    (FOLDS / 2..FOLDS - 1).filter(move |&seen| seen < folds)
}

pub fn geometric_mean(values: &[f64]) -> f64 {
    let logs = values.iter().map(|value| libm::log(value.max(1e-300)));
    libm::exp(logs.sum::<f64>() / values.len().max(1) as f64)
}

/// A ratio of mean squared errors as a change of the root in percent.
pub fn change(ratio: f64) -> String {
    format!("{:+.1} %", 100.0 * (ratio.sqrt() - 1.0))
}
