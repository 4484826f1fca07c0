//! Damped descent on least squares: what every search for rates and winds has in common.
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
//! The crate `levenberg-marquardt` wants all residuals and their Jacobian (here a sum over millions
//! of rows, kept as a Gram matrix), knows no bounds or held signs, and evaluates every point
//! itself.
//!
//! Limits: it finds the minimum next to its start; whoever needs more starts it several times.

use nalgebra::{DMatrix, DVector};

/// Rule by which the damping moves.
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

impl DampingRule {
    /// The first of ever more damped steps that pays: `step` gives the point to which a damping
    /// leads, or `None` where there is none, or none better.
    pub fn first_that_pays<P>(&self, damping: &mut f64, step: impl Fn(f64) -> Option<P>) -> Option<P> {
        while *damping <= self.most {
            let point = step(*damping);
            *damping = if point.is_some() { (self.eased)(*damping) } else { (self.raised)(*damping) };
            if point.is_some() {
                return point;
            }
        }
        None
    }
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

/// The place of the least value of a function of one number from 0 on, `step` being its scale:
/// steps that double until the function rises, then golden sections to a thousandth of a step.
/// 0 where it never falls, and for a step of 0. `most` ends the search.
pub fn least_from_zero(step: f64, most: f64, mut cost: impl FnMut(f64) -> f64) -> f64 {
    let (mut before, mut at, mut next) = (0.0, 0.0, step);
    let mut least = cost(0.0);
    while step > 0.0 && next <= most {
        let value = cost(next);
        if value.is_nan() || value >= least {
            break;
        }
        (before, at, next, least) = (at, next, 2.0 * next, value);
    }
    let (mut from, mut to) = (before, next.min(most.max(at)));
    let golden = 0.5 * (5_f64.sqrt() - 1.0);
    let (mut left, mut right) = (to - golden * (to - from), from + golden * (to - from));
    let (mut of_left, mut of_right) = (cost(left), cost(right));
    while to - from > 1e-3 * step && step > 0.0 {
        if of_left < of_right {
            (to, right, of_right) = (right, left, of_left);
            left = to - golden * (to - from);
            of_left = cost(left);
        } else {
            (from, left, of_left) = (left, right, of_right);
            right = from + golden * (to - from);
            of_right = cost(right);
        }
    }
    let middle = 0.5 * (from + to);
    if cost(middle) < cost(0.0) { middle } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rosenbrock's valley as a sum of squares: (1 − x)² + 100 (y − x²)².
    fn residuals(at: &DVector<f64>) -> DVector<f64> {
        DVector::from_vec(vec![1.0 - at[0], 10.0 * (at[1] - at[0] * at[0])])
    }

    const RULE: DampingRule = DampingRule { start: 1e-3, eased: |l| 0.1 * l, raised: |l| 10.0 * l, most: 1e6 };

    #[test]
    fn a_bent_valley_is_followed_to_its_end() {
        let (mut at, mut damping) = (DVector::from_vec(vec![-1.2, 1.0]), RULE.start);
        for _ in 0..100 {
            let jacobian = DMatrix::from_row_slice(2, 2, &[-1.0, 0.0, -20.0 * at[0], 10.0]);
            let (h, b) = (jacobian.tr_mul(&jacobian), -jacobian.tr_mul(&residuals(&at)));
            let moved = |damping| {
                let moved = &at + damped_step(&h, &b, damping)?;
                (residuals(&moved).norm() < residuals(&at).norm()).then_some(moved)
            };
            let Some(moved) = RULE.first_that_pays(&mut damping, moved) else { break };
            at = moved;
        }
        // The minimum is 0 at (1, 1), so only rounding of the residuals is left.
        assert!((at[0] - 1.0).abs() < 1e-12 && (at[1] - 1.0).abs() < 1e-12, "{at}");
    }

    #[test]
    fn the_least_value_is_found_far_from_zero_near_it_and_at_it() {
        for truth in [0.0, 1e-3, 0.3, 1.0, 700.0] {
            let found = least_from_zero(1.0, 1e4, |x| (x - truth) * (x - truth) + 5.0);
            assert!((found - truth).abs() < 1e-3, "{found} for {truth}");
        }
        assert_eq!(least_from_zero(1.0, 1e4, |x| 1.0 + x), 0.0);
        assert!((least_from_zero(1.0, 10.0, |x| -x) - 10.0).abs() < 1e-2);
    }

    #[test]
    fn the_damping_rises_until_a_step_pays_and_then_falls_and_ends_where_none_does() {
        let mut damping = RULE.start;
        let found = RULE.first_that_pays(&mut damping, |damping| (damping > 0.5).then_some(damping));
        assert!(found.is_some_and(|found| (found - 1.0).abs() < 1e-12) && (damping - 0.1).abs() < 1e-12);
        assert_eq!(RULE.first_that_pays(&mut damping, |_| None::<f64>), None);
        assert!(damping > RULE.most);
    }
}
