//! A few free poles by variable projection (G. H. Golub and V. Pereyra, SIAM J. Numer. Anal. 10
//! (1973) 413).
//!
//! For given rates the best resistances are linear least squares (non-negative ones, if the pair is
//! such), so that only the logarithms of the rates are sought, by [damped
//! descent](crate::optimise). It finds a minimum near its start, so it is started twice: from the
//! whole model's poles, merged neighbour by neighbour until so many are left, and from a geometric
//! mesh. The better end is taken.

use dr_core::model::mesh;
use nalgebra::{DMatrix, DVector};

use super::least_squares;
use super::target::ReductionTarget;
use crate::optimise::{DampingRule, damped_step};

/// Neighbours closer than this are one pole to every record, and their resistances would grow
/// against each other without bound.
const LEAST_RATIO: f64 = 1.05;

pub struct ReductionProblem<'a> {
    pub target: &'a ReductionTarget,
    pub non_negative: bool,
    /// Between which rates are sought.
    pub bounds_rad_s: (f64, f64),
}

/// Rates, resistances by class, and what they leave of the target.
#[derive(Debug, Clone)]
pub struct Fit {
    pub rates_rad_s: Vec<f64>,
    pub r_k_per_w: Vec<Vec<f64>>,
    pub cost: f64,
}

impl ReductionProblem<'_> {
    /// The best resistances at given rates.
    pub fn project(&self, rates_rad_s: &[f64]) -> Option<Fit> {
        let (r_k_per_w, residual) = self.solve(rates_rad_s)?;
        Some(Fit { rates_rad_s: rates_rad_s.to_vec(), r_k_per_w, cost: residual.norm_squared() })
    }

    fn solve(&self, rates_rad_s: &[f64]) -> Option<(Vec<Vec<f64>>, DVector<f64>)> {
        let (mut all, mut residual) = (Vec::new(), Vec::new());
        for class in 0..self.target.classes() {
            let wanted = self.target.wanted(class);
            if wanted.norm() == 0.0 {
                all.push(vec![0.0; rates_rad_s.len()]);
                continue;
            }
            let columns = self.target.columns(class, rates_rad_s);
            let solve = if self.non_negative { least_squares::non_negative } else { least_squares::plain };
            let r = solve(&columns, wanted)?;
            residual.extend((columns * &r - wanted).iter());
            all.push(r.iter().copied().collect());
        }
        Some((all, DVector::from_vec(residual)))
    }

    /// Moves all rates freely.
    pub fn refine_free(&self, start_rad_s: &[f64]) -> Option<Fit> {
        let start = start_rad_s.iter().map(|rate| libm::log(*rate)).collect();
        self.refine(start, |logs| logs.iter().map(|log| libm::exp(*log)).collect())
    }

    /// Moves the edges of a geometric mesh.
    pub fn refine_mesh(&self, first_rad_s: f64, last_rad_s: f64, order: usize) -> Option<Fit> {
        if order == 1 {
            return self.refine_free(&[(first_rad_s * last_rad_s).sqrt()]);
        }
        self.refine(vec![libm::log(first_rad_s), libm::log(last_rad_s)], |edges| {
            (0..order).map(|k| mesh::rate_rad_s(libm::exp(edges[0]), libm::exp(edges[1]), k, order)).collect()
        })
    }

    fn residual(&self, rates_rad_s: &[f64]) -> Option<DVector<f64>> {
        let mut sorted = rates_rad_s.to_vec();
        sorted.sort_by(f64::total_cmp);
        let apart = sorted.windows(2).all(|two| two[1] >= LEAST_RATIO * two[0]);
        let inside = sorted.iter().all(|rate| (self.bounds_rad_s.0..=self.bounds_rad_s.1).contains(rate));
        if apart && inside { self.solve(rates_rad_s).map(|(_, residual)| residual) } else { None }
    }

    /// Damped descent on logarithms, from which `rates` makes rates.
    fn refine(&self, start: Vec<f64>, rates: impl Fn(&[f64]) -> Vec<f64>) -> Option<Fit> {
        let residual_at = |at: &[f64]| self.residual(&rates(at));
        let mut residual = residual_at(&start)?;
        let (mut at, mut damping) = (start, RULE.start);
        // Steps in a row that hardly paid.
        let mut slow = 0;
        for _ in 0..MOST_STEPS {
            let Some((normal, slope)) = linearised(&at, &residual, &residual_at) else { break };
            let moved = |damping| {
                let step = damped_step(&normal, &slope, damping)?;
                // No further than a factor of e at once: beyond it the linear picture says nothing.
                let shrink = 1.0 / step.amax().max(1.0);
                let moved: Vec<f64> = at.iter().zip(step.iter()).map(|(at, step)| at - shrink * step).collect();
                let left = residual_at(&moved)?;
                (left.norm_squared() < residual.norm_squared()).then_some((moved, left))
            };
            let Some((moved, left)) = RULE.first_that_pays(&mut damping, moved) else { break };
            let is_slow = left.norm_squared() > residual.norm_squared() * (1.0 - 1e-4);
            slow = if is_slow { slow + 1 } else { 0 };
            (at, residual) = (moved, left);
            if slow > 3 {
                break;
            }
        }
        let mut found = rates(&at);
        found.sort_by(f64::total_cmp);
        self.project(&found)
    }
}

const RULE: DampingRule = DampingRule {
    start: 1e-3,
    eased: |damping| (0.2 * damping).max(1e-12),
    raised: |damping| 4.0 * damping,
    most: 1e12,
};
const MOST_STEPS: usize = 300;

/// H and −b at a place; `None` where nothing is left to gain.
fn linearised(
    at: &[f64],
    residual: &DVector<f64>,
    residual_at: &dyn Fn(&[f64]) -> Option<DVector<f64>>,
) -> Option<(DMatrix<f64>, DVector<f64>)> {
    if residual.norm_squared() < 1e-28 {
        return None;
    }
    // By differences: a few columns of a few hundred rows.
    let column = |i: usize| {
        let moved = |by: f64| {
            let mut at = at.to_vec();
            at[i] += by;
            Some((residual_at(&at)? - residual) / by)
        };
        moved(1e-6).or_else(|| moved(-1e-6))
    };
    let columns: Vec<DVector<f64>> = (0..at.len()).map(column).collect::<Option<_>>()?;
    let jacobian = DMatrix::from_columns(&columns);
    Some((jacobian.tr_mul(&jacobian), jacobian.tr_mul(residual)))
}

/// Merges neighbouring poles until `order` are left: always the two that differ least, for what
/// they weigh (Ward's criterion on the logarithmic axis).
pub fn merged(poles: &[(f64, f64)], order: usize) -> Vec<f64> {
    let mut poles: Vec<(f64, f64)> = poles.iter().map(|&(rate, weight)| (libm::log(rate), weight)).collect();
    while poles.len() > order {
        let price = |i: usize| {
            let ((a, m), (b, n)) = (poles[i], poles[i + 1]);
            m * n / (m + n).max(f64::MIN_POSITIVE) * (b - a).powi(2)
        };
        let cheapest = (0..poles.len() - 1).min_by(|&i, &j| price(i).total_cmp(&price(j))).unwrap_or(0);
        let ((a, m), (b, n)) = (poles[cheapest], poles.remove(cheapest + 1));
        let share = if m + n > 0.0 { n / (m + n) } else { 0.5 };
        poles[cheapest] = (a + share * (b - a), m + n);
    }
    poles.into_iter().map(|(log, _)| libm::exp(log)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_poles_are_found_exactly_from_a_wrong_start() {
        let target = ReductionTarget::new(&[0.013, 0.7], &[&[30.0, 4.0], &[20.0, -3.0]], 0.1);
        let problem = ReductionProblem { target: &target, non_negative: false, bounds_rad_s: (1e-4, 30.0) };
        let fit = problem.refine_free(&[0.1, 3.0]).unwrap();
        // what is left is rounding
        assert!(fit.cost < 1e-20, "{fit:?}");
        for (value, expected) in fit.rates_rad_s.iter().zip([0.013, 0.7]) {
            assert!((value / expected - 1.0).abs() < 1e-8, "{fit:?}");
        }
        for (value, expected) in fit.r_k_per_w.concat().iter().zip([30.0, 4.0, 20.0, -3.0]) {
            assert!((value / expected - 1.0).abs() < 1e-8, "{fit:?}");
        }
    }

    #[test]
    fn edges_of_a_mesh_are_found_too() {
        let rates: Vec<f64> = (0..4).map(|k| mesh::rate_rad_s(0.01, 8.0, k, 4)).collect();
        let target = ReductionTarget::new(&rates, &[&[30.0, 4.0, 2.0, 1.0]], 0.1);
        let problem = ReductionProblem { target: &target, non_negative: true, bounds_rad_s: (1e-4, 30.0) };
        let fit = problem.refine_mesh(0.02, 4.0, 4).unwrap();
        for (value, expected) in fit.rates_rad_s.iter().zip(&rates) {
            assert!((value / expected - 1.0).abs() < 1e-7, "{fit:?}");
        }
    }

    #[test]
    fn merging_keeps_what_weighs_and_joins_what_is_near() {
        let rates = merged(&[(0.01, 5.0), (0.1, 1e-9), (1.0, 2.0), (1.1, 2.0)], 2);
        assert!((rates[0] - 0.01).abs() < 1e-9);
        assert!((rates[1] - 1.1_f64.sqrt()).abs() < 1e-6, "{rates:?}");
    }
}
