//! Least squares with some parameters held at or above zero, on normal equations H θ = b.
//!
//! The active-set method of Lawson and Hanson (*Solving Least Squares Problems*, ch. 23) in the
//! form for normal equations of Bro and de Jong (1997, *J. Chemometrics* 11, 393), begun from all
//! parameters that are free of a sign. It works on sums, H = AᵀA and b = Aᵀy, because the rows of A
//! are gone once they are added up; the crate `nnls` needs A itself. Where A is at hand and its
//! columns are nearly dependent, `model::reduce` keeps to A, since H has the square of A's
//! condition.

use nalgebra::{Cholesky, DMatrix, DVector};

/// Minimises θᵀHθ/2 − bᵀθ with θ_i ≥ 0 wherever `positive[i]`. H is symmetric and positive
/// definite.
pub fn solve(h: &DMatrix<f64>, b: &DVector<f64>, positive: &[bool]) -> DVector<f64> {
    let n = b.len();
    let mut passive: Vec<bool> = positive.iter().map(|positive| !positive).collect();
    let mut theta = restricted(h, b, &passive);
    let tolerance = 1e-11 * b.amax();
    // Every pass strictly lowers the objective, so no set comes twice; the bound is for rounding.
    for _ in 0..10 * n + 10 {
        let gradient = b - h * &theta;
        let entering = (0..n)
            .filter(|&i| !passive[i] && gradient[i] > tolerance)
            .max_by(|&i, &j| gradient[i].total_cmp(&gradient[j]));
        let Some(entering) = entering else { break };
        passive[entering] = true;
        loop {
            let target = restricted(h, b, &passive);
            let bad = |i: usize| passive[i] && positive[i] && target[i] <= 0.0;
            let Some(step) =
                (0..n).filter(|&i| bad(i)).map(|i| theta[i] / (theta[i] - target[i])).min_by(f64::total_cmp)
            else {
                theta = target;
                break;
            };
            let blocking = (0..n).filter(|&i| bad(i) && theta[i] / (theta[i] - target[i]) <= step).collect::<Vec<_>>();
            theta += (target - &theta) * step;
            for i in blocking {
                passive[i] = false;
                theta[i] = 0.0;
            }
        }
    }
    theta
}

/// The solution with all parameters outside of `passive` at zero.
fn restricted(h: &DMatrix<f64>, b: &DVector<f64>, passive: &[bool]) -> DVector<f64> {
    let index: Vec<usize> = (0..passive.len()).filter(|&i| passive[i]).collect();
    let mut theta = DVector::zeros(passive.len());
    let sub = DMatrix::from_fn(index.len(), index.len(), |i, j| h[(index[i], index[j])]);
    let right = DVector::from_fn(index.len(), |i, _| b[index[i]]);
    if let Some(factor) = Cholesky::new(sub) {
        let solution = factor.solve(&right);
        for (&at, value) in index.iter().zip(solution.iter()) {
            theta[at] = *value;
        }
    }
    theta
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn satisfies_the_conditions_of_karush_kuhn_and_tucker_on_random_problems() {
        let mut seed = 1_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        for case in 0..200 {
            let n = 2 + case % 12;
            let a = DMatrix::from_fn(n + 3, n, |_, _| random());
            let h = a.tr_mul(&a) + DMatrix::identity(n, n) * 1e-6;
            let b = DVector::from_fn(n, |_, _| random());
            let positive: Vec<bool> = (0..n).map(|i| i % 4 != 3).collect();
            let theta = solve(&h, &b, &positive);
            let gradient = &b - &h * &theta;
            for i in 0..n {
                if !positive[i] || theta[i] > 0.0 {
                    // Cholesky with a condition number of up to 1e7
                    assert!(gradient[i].abs() < 1e-8, "case {case}: gradient {} at {i}", gradient[i]);
                } else {
                    assert!(theta[i] == 0.0 && gradient[i] < 1e-8, "case {case}: {} at {i}", theta[i]);
                }
            }
        }
    }
}
