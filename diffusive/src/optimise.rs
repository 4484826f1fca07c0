//! Damped descent on least squares: the one driver behind every search for rates, winds and edges.
//!
//! ```text
//! (H + λ D) δ = b,    place ← moved(place, δ)
//! ```
//!
//! λ falls after a step that pays, and rises after one that does not.
//!
//! H and b are the normal equations at the best point so far. Levenberg and Marquardt damp by the
//! diagonal, D = diag H (D. W. Marquardt, *J. SIAM* 11 (1963) 431); a Gauss–Newton step that is
//! halved until it pays is the same descent, with δ/λ and λ = 1, 2, 4, …
//!
//! The driver decides which points are kept, how λ moves and when the search is over. The problem
//! says how a step is made. It may hold parameters at bounds, live on a manifold, or have its
//! points evaluated elsewhere: [`DampedDescent`] hands out places and takes back points, so that
//! one reading of a long record can serve several searches at once. Where a point is a function
//! call away, [`descend`] does the asking.
//!
//! The crate `levenberg-marquardt` wants all residuals and their Jacobian (here a sum over millions
//! of rows, kept as a Gram matrix), knows no bounds or held signs, and evaluates every point
//! itself.
//!
//! Limits: it finds the minimum next to its start; whoever needs more starts it several times.

use nalgebra::{DMatrix, DVector};

/// What is minimised: a sum of squares whose steps come from the normal equations at a point.
pub trait DescentProblem {
    /// Parameters. They need not be a vector.
    type Parameters;
    /// What an evaluation at a place gives: its cost and all that a linearisation there needs.
    type Evaluation;
    /// The normal equations at a point, worked out once it is the best.
    type Linearisation;

    /// Whether a point is to be kept instead of the best so far.
    fn is_better(&self, new: &Self::Evaluation, best: &Self::Evaluation) -> bool;

    /// The normal equations at the best point; `None` ends the search there.
    fn linearise(&mut self, best: &Self::Evaluation) -> Option<Self::Linearisation>;

    /// The place to which a damped step leads; `None` if more damping is needed.
    fn step(&mut self, best: &Self::Evaluation, linear: &Self::Linearisation, damping: f64)
    -> Option<Self::Parameters>;

    /// Whether a point that is about to replace the best one is the last.
    fn is_last(&mut self, _new: &Self::Evaluation, _best: &Self::Evaluation) -> bool {
        false
    }
}

/// How the damping moves.
#[derive(Debug, Clone, Copy)]
pub struct DampingRule {
    /// Damping of the first step.
    pub start: f64,
    /// Damping after a step that paid.
    pub eased: fn(f64) -> f64,
    /// Damping after a step that did not.
    pub raised: fn(f64) -> f64,
    /// Beyond this no step is tried any more.
    pub most: f64,
}

/// A search that is told points and asked for places.
pub struct DampedDescent<P: DescentProblem> {
    /// The problem with whatever it remembers.
    pub problem: P,
    best: P::Evaluation,
    linear: Option<P::Linearisation>,
    damping: f64,
    rule: DampingRule,
}

impl<P: DescentProblem> DampedDescent<P> {
    /// A search that begins at a point.
    pub fn new(mut problem: P, start: P::Evaluation, rule: DampingRule) -> Self {
        let linear = problem.linearise(&start);
        Self { problem, best: start, linear, damping: rule.start, rule }
    }

    /// The best point so far.
    pub fn best(&self) -> &P::Evaluation {
        &self.best
    }

    /// The best point, where the search is given up.
    pub fn into_best(self) -> P::Evaluation {
        self.best
    }

    /// The normal equations at the best point; `None` where no step from there is worth a trial.
    pub fn linear(&self) -> Option<&P::Linearisation> {
        self.linear.as_ref().filter(|_| self.damping <= self.rule.most)
    }

    /// Takes the point at a place that was handed out, `None` where there is none. Returns whether
    /// it is kept.
    pub fn tell(&mut self, point: Option<P::Evaluation>) -> bool {
        let Some(new) = point.filter(|new| self.problem.is_better(new, &self.best)) else {
            self.damping = (self.rule.raised)(self.damping);
            return false;
        };
        self.damping = (self.rule.eased)(self.damping);
        let is_last = self.problem.is_last(&new, &self.best);
        self.best = new;
        self.linear = if is_last { None } else { self.problem.linearise(&self.best) };
        true
    }

    /// Hands out the next place to evaluate; `None` where the search is over.
    pub fn ask(&mut self) -> Option<P::Parameters> {
        let linear = self.linear.as_ref()?;
        while self.damping <= self.rule.most {
            let place = self.problem.step(&self.best, linear, self.damping);
            if place.is_some() {
                return place;
            }
            self.damping = (self.rule.raised)(self.damping);
        }
        None
    }
}

/// Descends from a point by at most so many steps that pay, and returns the best point.
///
/// `evaluate` gives the point at a place, or `None` where there is none.
pub fn descend<P: DescentProblem>(
    problem: P,
    start: P::Evaluation,
    rule: DampingRule,
    most_steps: usize,
    evaluate: impl Fn(&P, P::Parameters) -> Option<P::Evaluation>,
) -> P::Evaluation {
    let mut descent = DampedDescent::new(problem, start, rule);
    let mut steps = 0;
    while steps < most_steps
        && let Some(place) = descent.ask()
    {
        let point = evaluate(&descent.problem, place);
        steps += usize::from(descent.tell(point));
    }
    descent.into_best()
}

/// Solves (H + λ diag H) δ = b. A diagonal that is far below the greatest is damped by 1e-12 of
/// that one as well.
pub fn damped_step(h: &DMatrix<f64>, b: &DVector<f64>, damping: f64) -> Option<DVector<f64>> {
    let floor = 1e-12 * h.diagonal().max();
    let mut damped = h.clone();
    for i in 0..b.len() {
        damped[(i, i)] += damping * (h[(i, i)] + floor) + f64::MIN_POSITIVE;
    }
    damped.cholesky().map(|cholesky| cholesky.solve(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rosenbrock's valley as a sum of squares: (1 − x)² + 100 (y − x²)².
    struct Valley;

    struct ValleyPoint {
        at: DVector<f64>,
        residuals: DVector<f64>,
    }

    fn valley_point(at: DVector<f64>) -> ValleyPoint {
        let residuals = DVector::from_vec(vec![1.0 - at[0], 10.0 * (at[1] - at[0] * at[0])]);
        ValleyPoint { at, residuals }
    }

    impl DescentProblem for Valley {
        type Parameters = DVector<f64>;
        type Evaluation = ValleyPoint;
        type Linearisation = (DMatrix<f64>, DVector<f64>);

        fn is_better(&self, new: &ValleyPoint, best: &ValleyPoint) -> bool {
            new.residuals.norm_squared() < best.residuals.norm_squared()
        }

        fn linearise(&mut self, best: &ValleyPoint) -> Option<Self::Linearisation> {
            let jacobian = DMatrix::from_row_slice(2, 2, &[-1.0, 0.0, -20.0 * best.at[0], 10.0]);
            Some((jacobian.tr_mul(&jacobian), -jacobian.tr_mul(&best.residuals)))
        }

        fn step(&mut self, best: &ValleyPoint, (h, b): &Self::Linearisation, damping: f64) -> Option<DVector<f64>> {
            damped_step(h, b, damping).map(|step| &best.at + step)
        }
    }

    const RULE: DampingRule = DampingRule { start: 1e-3, eased: |l| 0.1 * l, raised: |l| 10.0 * l, most: 1e6 };

    #[test]
    fn a_bent_valley_is_followed_to_its_end() {
        let start = valley_point(DVector::from_vec(vec![-1.2, 1.0]));
        let end = descend(Valley, start, RULE, 100, |_, at| Some(valley_point(at)));
        // The minimum is 0 at (1, 1), so only rounding of the residuals is left.
        assert!((end.at[0] - 1.0).abs() < 1e-12 && (end.at[1] - 1.0).abs() < 1e-12, "{}", end.at);
    }

    #[test]
    fn no_more_steps_are_taken_than_allowed_and_none_where_nothing_can_be_evaluated() {
        let start = || valley_point(DVector::from_vec(vec![-1.2, 1.0]));
        let near = descend(Valley, start(), RULE, 2, |_, at| Some(valley_point(at)));
        assert!(near.residuals.norm() > 0.1);
        let still = descend(Valley, start(), RULE, 100, |_, _| None);
        assert_eq!(still.at, start().at);
    }
}
