//! Penalised least squares on gathered sums, and how sure its answer is.
//!
//! ```text
//! minimise ‖Aθ − y‖² + θᵀPθ,     θ = (G + P)⁻¹ b,     G = AᵀA,  b = Aᵀy
//! cov θ = (G + P)⁻¹ (σ² G + β² P) (G + P)⁻¹
//! σ² = rss / (n − tr G(G + P)⁻¹),   β² = max(σ², θᵀPθ / p)
//! ```
//!
//! σ² G is the noise, which is taken for white; β² P is what the prior may have pulled θ by. If
//! P/σ² were the precision that θ was drawn with, β would be σ, and the covariance σ² (G + P)⁻¹,
//! the posterior's (Wahba 1983, *J. R. Stat. Soc. B* 45, 133); without a prior it is the ordinary
//! one. A prior that is stronger than the θ found warrant shows by θᵀPθ, which has the expectation
//! β² p for p penalised parameters: then its pull counts as large as they are. Everything is solved
//! by Cholesky in columns scaled to unit norm.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::design::Role;
use super::gram::Gram;

/// Added to the unit diagonal: what f64 sums do not resolve anyway.
const FLOOR: f64 = 1e-14;

/// A parameter: the sum of design columns that it weighs.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelTerm {
    pub of: Vec<(usize, f64)>,
    pub role: Role,
}

/// Parameters as weights of the design's columns, `width` of them.
pub fn in_columns(terms: &[ModelTerm], theta: &DVector<f64>, width: usize) -> Vec<f64> {
    let mut weights = vec![0.0; width];
    for (term, theta) in terms.iter().zip(theta.iter()) {
        for &(column, weight) in &term.of {
            weights[column] += weight * theta;
        }
    }
    weights
}

/// Normal equations in the parameters of some terms.
#[derive(Debug, Clone, PartialEq)]
pub struct NormalEquations {
    pub g: DMatrix<f64>,
    pub b: DVector<f64>,
    /// yᵀy
    pub yy: f64,
    pub rows: f64,
}

#[derive(Debug, Clone, PartialEq)]
pub struct PenalisedSolution {
    pub theta: DVector<f64>,
    pub covariance: DMatrix<f64>,
    /// (G + P)⁻¹
    pub inverse: DMatrix<f64>,
    /// What the covariance has beyond σ² (G + P)⁻¹.
    pub pulled: DMatrix<f64>,
    /// Residual sum of squares.
    pub rss: f64,
    /// tr G(G + P)⁻¹: parameters that the data, not the prior, decide.
    pub degrees: f64,
    pub noise_variance: f64,
}

impl NormalEquations {
    /// `output` counts the outputs, which stand last in the sums.
    pub fn of(gram: &Gram, terms: &[ModelTerm], outputs: usize, output: usize) -> Self {
        Self::of_sum(gram, terms, &[(gram.sums.ncols() - outputs + output, 1.0)])
    }

    /// The same for an output that is a sum of columns.
    pub fn of_sum(gram: &Gram, terms: &[ModelTerm], output: &[(usize, f64)]) -> Self {
        let product = |a: &[(usize, f64)], b: &[(usize, f64)]| {
            let of_column = |column| a.iter().map(|&(row, weight)| weight * gram.sums[(row, column)]).sum::<f64>();
            b.iter().map(|&(column, weight)| weight * of_column(column)).sum()
        };
        let n = terms.len();
        Self {
            g: DMatrix::from_fn(n, n, |i, j| product(&terms[i].of, &terms[j].of)),
            b: DVector::from_fn(n, |i, _| product(&terms[i].of, output)),
            yy: product(output, output),
            rows: gram.rows as f64,
        }
    }

    /// The sum of all folds.
    pub fn total(folds: &[Self]) -> Self {
        folds[1..].iter().fold(folds[0].clone(), |sum, fold| sum.plus(fold))
    }

    pub fn minus(&self, other: &Self) -> Self {
        Self { g: &self.g - &other.g, b: &self.b - &other.b, yy: self.yy - other.yy, rows: self.rows - other.rows }
    }

    pub fn plus(&self, other: &Self) -> Self {
        Self { g: &self.g + &other.g, b: &self.b + &other.b, yy: self.yy + other.yy, rows: self.rows + other.rows }
    }

    /// The problem that is left when one parameter is known.
    pub fn with_known(&self, index: usize, value: f64) -> Self {
        let column = self.g.column(index).into_owned();
        Self {
            yy: self.yy - 2.0 * value * self.b[index] + value * value * self.g[(index, index)],
            b: (&self.b - &column * value).remove_row(index),
            g: self.g.clone().remove_row(index).remove_column(index),
            rows: self.rows,
        }
    }

    /// Sum of squared errors of parameters.
    pub fn squared_error(&self, theta: &DVector<f64>) -> f64 {
        (self.yy - 2.0 * theta.dot(&self.b) + theta.dot(&(&self.g * theta))).max(0.0)
    }

    /// Parameters only. `positive` says which may not be negative.
    pub fn estimate(&self, penalty: &DMatrix<f64>, positive: Option<&[bool]>) -> DVector<f64> {
        let scaled = ScaledEquations::of(self, penalty);
        let theta = match positive {
            None => scaled.solve_all(),
            Some(positive) => super::nonnegative::solve(&scaled.h, &scaled.b, positive),
        };
        theta.component_mul(&scaled.scale)
    }

    /// The logarithm of the marginal likelihood but for a constant of the record: θ ~ N(0, σ² P⁻¹),
    /// parameters without a penalty are anywhere, and σ² is the one that makes most of it.
    pub fn evidence(&self, penalty: &DMatrix<f64>) -> f64 {
        let scaled = ScaledEquations::of(self, penalty);
        let theta = scaled.solve_all().component_mul(&scaled.scale);
        let free = penalty.diagonal().iter().filter(|weight| **weight <= 0.0).count();
        let freedom = self.rows - free as f64;
        let rest = (self.yy - theta.dot(&self.b)).max(1e-14 * self.yy).max(f64::MIN_POSITIVE);
        let used: f64 = scaled.scale.iter().filter(|scale| **scale > 0.0).map(|scale| -2.0 * libm::log(*scale)).sum();
        let log_of_posterior = log_determinant(&scaled.factor) + used;
        // A column without content tells nothing, and its prior is what it was.
        let is_held = |&i: &usize| penalty[(i, i)] > 0.0 && scaled.scale[i] > 0.0;
        let held: Vec<usize> = (0..penalty.nrows()).filter(is_held).collect();
        let prior = DMatrix::from_fn(held.len(), held.len(), |i, j| penalty[(held[i], held[j])]);
        let log_of_prior = Cholesky::new(prior).map_or(f64::INFINITY, |factor| log_determinant(&factor));
        -0.5 * (freedom * libm::log(rest / freedom) + log_of_posterior - log_of_prior)
    }

    pub fn solve(&self, penalty: &DMatrix<f64>, positive: Option<&[bool]>) -> PenalisedSolution {
        let scaled = ScaledEquations::of(self, penalty);
        let theta = self.estimate(penalty, positive);
        let inverse = scaled.factor.inverse();
        let inverse = DMatrix::from_fn(inverse.nrows(), inverse.ncols(), |i, j| {
            inverse[(i, j)] * scaled.scale[i] * scaled.scale[j]
        });
        // Both are symmetric, so the trace of the product is the sum of the products of their
        // entries.
        let degrees = self.g.component_mul(&inverse).sum();
        let rss = self.squared_error(&theta);
        let noise_variance = rss / (self.rows - degrees).max(1.0);
        let penalised = penalty.diagonal().iter().filter(|weight| **weight > 0.0).count();
        let drawn = theta.dot(&(penalty * &theta)) / penalised.max(1) as f64;
        let excess = (drawn - noise_variance).max(0.0);
        // (G + P)⁻¹ (σ² G + β² P) (G + P)⁻¹ = σ² (G + P)⁻¹ + (β² − σ²) (G + P)⁻¹ P (G + P)⁻¹
        let pulled = &inverse * penalty * &inverse * excess;
        let covariance = &inverse * noise_variance + &pulled;
        PenalisedSolution { covariance, inverse, pulled, theta, rss, degrees, noise_variance }
    }
}

fn log_determinant(factor: &Cholesky<f64, Dyn>) -> f64 {
    2.0 * factor.l_dirty().diagonal().iter().map(|entry| libm::log(*entry)).sum::<f64>()
}

/// (G + P) with a unit diagonal of G.
struct ScaledEquations {
    h: DMatrix<f64>,
    b: DVector<f64>,
    /// 1 over the columns' norms; 0 for a column without any content, whose parameter is then 0.
    scale: DVector<f64>,
    factor: Cholesky<f64, Dyn>,
}

impl ScaledEquations {
    fn of(problem: &NormalEquations, penalty: &DMatrix<f64>) -> Self {
        let diagonal = problem.g.diagonal();
        let greatest = diagonal.max().max(f64::MIN_POSITIVE);
        let scale = diagonal.map(|sum| if sum > 1e-30 * greatest { 1.0 / sum.sqrt() } else { 0.0 });
        let n = scale.len();
        let mut h = DMatrix::from_fn(n, n, |i, j| (problem.g[(i, j)] + penalty[(i, j)]) * scale[i] * scale[j]);
        for i in 0..n {
            if scale[i] == 0.0 {
                h[(i, i)] = 1.0;
            }
        }
        let b = problem.b.component_mul(&scale);
        let mut floor = FLOOR;
        loop {
            let mut raised = h.clone();
            for i in 0..n {
                raised[(i, i)] += floor;
            }
            if let Some(factor) = Cholesky::new(raised.clone()) {
                return Self { h: raised, b, scale, factor };
            }
            // Directions that the sums do not resolve: a little more than rounding ends this,
            // unless they are not numbers.
            floor *= 10.0;
            if floor > 1.0 {
                h = DMatrix::identity(n, n);
            }
        }
    }

    fn solve_all(&self) -> DVector<f64> {
        let mut theta = self.factor.solve(&self.b);
        // One step of refinement gives back the digits that the factor lost.
        let rest = &self.b - &self.h * &theta;
        theta += self.factor.solve(&rest);
        theta
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every column a parameter of its own.
    fn plain_terms() -> [ModelTerm; 2] {
        [0, 1].map(|column| ModelTerm { of: vec![(column, 1.0)], role: Role::Offset })
    }

    fn two_columns() -> (NormalEquations, Gram) {
        // y = 2a − b on rows (1,0), (1,1), (0,3): residual zero.
        let rows = [[1.0, 0.0, 2.0], [1.0, 1.0, 1.0], [0.0, 3.0, -3.0]];
        let mut gram = Gram::empty(3);
        for row in rows {
            let row = DVector::from_row_slice(&row);
            gram.sums += &row * row.transpose();
            gram.rows += 1;
        }
        (NormalEquations::of(&gram, &plain_terms(), 1, 0), gram)
    }

    #[test]
    fn solves_what_has_an_exact_answer() {
        let (problem, _) = two_columns();
        let solution = problem.solve(&DMatrix::zeros(2, 2), None);
        assert!((solution.theta[0] - 2.0).abs() < 1e-12 && (solution.theta[1] + 1.0).abs() < 1e-12);
        assert!(solution.rss < 1e-12 && (solution.degrees - 2.0).abs() < 1e-9);
    }

    #[test]
    fn a_parameter_that_may_not_be_negative_is_zero_and_the_others_make_the_best_of_it() {
        let (problem, _) = two_columns();
        let theta = problem.estimate(&DMatrix::zeros(2, 2), Some(&[true, true]));
        // min (a−2)² + (a−1)² → a = 1.5
        assert!((theta[0] - 1.5).abs() < 1e-12 && theta[1] == 0.0);
    }

    #[test]
    fn a_column_without_content_gets_nothing() {
        let mut gram = Gram::empty(3);
        gram.sums[(0, 0)] = 4.0;
        gram.sums[(0, 2)] = 8.0;
        gram.sums[(2, 0)] = 8.0;
        gram.sums[(2, 2)] = 16.0;
        gram.rows = 4;
        let problem = NormalEquations::of(&gram, &plain_terms(), 1, 0);
        let theta = problem.estimate(&DMatrix::zeros(2, 2), None);
        assert!((theta[0] - 2.0).abs() < 1e-12 && theta[1] == 0.0);
    }

    #[test]
    fn one_term_may_weigh_several_columns() {
        let (_, gram) = two_columns();
        let term = ModelTerm { of: vec![(0, 1.0), (1, -0.5)], role: Role::Offset };
        let problem = NormalEquations::of(&gram, &[term], 1, 0);
        // The column is (1, 0.5, −1.5), y is twice that in the first and last row.
        let theta = problem.estimate(&DMatrix::zeros(1, 1), None);
        assert!((theta[0] - (2.0 + 0.5 + 4.5) / (1.0 + 0.25 + 2.25)).abs() < 1e-12);
    }
}
