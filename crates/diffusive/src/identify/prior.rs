//! What is held for likely before the record speaks: the penalty P of penalised least squares.
//!
//! n is the number of rows, s the standard deviation of a bank's drive, ξ_T = 2πJ/T the thesis'
//! lower mesh edge.
//!
//! | prior | penalty | meant for |
//! |---|---|---|
//! | `Columns` | ε ‖a_i‖² θ_i² | a ridge on columns of unit norm, as `--ridge` gives it |
//! | `Tapered` | ε n s² (θ_i / min(1, ξ_i/ξ_T))² | resistances of like size at all rates, less below ξ_T |
//! | `Smooth` | ε n s² Σ (θ_{k−1} − 2θ_k + θ_{k+1})² | the symbol as a smooth curve over log ξ that ends beyond the mesh |
//!
//! A ridge on unit-norm columns costs a slow pole next to nothing, because its column is small: it
//! may take any resistance and explain drift by it, and then go on drifting beyond the record.
//! `Tapered` judges resistances, not columns, and trusts poles (and initial decays) slower than the
//! record by as much less as they are slower. On held-out halves of measured records it is what
//! makes a model carry on (docs/explanation/identification.md). The second difference of R_k over a
//! geometric mesh is that of η(ξ): R_k = η(ξ_k) ln r (theory of the thesis, 2.18).

use nalgebra::DMatrix;

use super::design::{RegressionDesign, Role};
use super::normal_equations::{ModelTerm, NormalEquations};
use super::pass::Facts;

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Prior {
    Columns(f64),
    Tapered(f64),
    Smooth(f64),
}

impl Prior {
    pub fn name(self) -> &'static str {
        match self {
            Self::Columns(_) => "ridge",
            Self::Tapered(_) => "tapered",
            Self::Smooth(_) => "smooth",
        }
    }

    pub fn weight(self) -> f64 {
        match self {
            Self::Columns(weight) | Self::Tapered(weight) | Self::Smooth(weight) => weight,
        }
    }
}

/// The scales that priors refer to.
#[derive(Debug, Clone, PartialEq)]
pub struct Scales {
    /// Standard deviation of what drives each bank.
    pub drive: Vec<f64>,
    /// ξ_T
    pub thesis_rad_s: f64,
}

impl Scales {
    /// Of the banks of a design in a record.
    pub fn of(design: &RegressionDesign, facts: &Facts, thesis_rad_s: f64) -> Self {
        Self { drive: design.banks.iter().map(|bank| facts.drive_scale(bank.drive)).collect(), thesis_rad_s }
    }

    /// Penalty for the terms of a problem over the whole record.
    pub fn penalty(&self, prior: Prior, terms: &[ModelTerm], problem: &NormalEquations) -> DMatrix<f64> {
        let count = terms.len();
        let mut penalty = DMatrix::zeros(count, count);
        let taper = |rate: f64| (rate / self.thesis_rad_s).min(1.0);
        for (i, term) in terms.iter().enumerate() {
            let power = |bank: usize| problem.rows * self.drive[bank].powi(2);
            penalty[(i, i)] = match (prior, term.role) {
                (_, Role::Offset) => 0.0,
                (_, Role::DriftStart { precision }) => precision,
                (Prior::Columns(weight), _) => weight * problem.g[(i, i)],
                (Prior::Tapered(weight), Role::Relaxation { bank, rate_rad_s, .. }) => {
                    weight * power(bank) / taper(rate_rad_s).powi(2)
                }
                (Prior::Tapered(weight), Role::FeedThrough { bank }) => weight * power(bank),
                (Prior::Tapered(weight), Role::Initial { rate_rad_s }) => {
                    weight * problem.rows / taper(rate_rad_s).powi(2)
                }
                // Curvature is added below; what has no neighbours is left almost free.
                (Prior::Smooth(_), Role::Relaxation { .. }) => 0.0,
                (Prior::Smooth(_), Role::FeedThrough { .. } | Role::Initial { .. }) => 1e-9 * problem.g[(i, i)],
            };
        }
        if let Prior::Smooth(weight) = prior {
            let place = |term: &ModelTerm| match term.role {
                Role::Relaxation { bank, k, .. } => Some((bank, k)),
                _ => None,
            };
            let at: std::collections::BTreeMap<(usize, usize), usize> =
                terms.iter().enumerate().filter_map(|(i, term)| Some((place(term)?, i))).collect();
            for &(bank, k) in at.keys() {
                let power = weight * problem.rows * self.drive[bank].powi(2);
                // Beyond the guards there is nothing: a neighbour that is missing counts as zero.
                let neighbours = [(k.checked_sub(1), 1.0), (Some(k), -2.0), (Some(k + 1), 1.0)];
                let found = neighbours.map(|(k, weight)| (k.and_then(|k| at.get(&(bank, k)).copied()), weight));
                for (row, first) in found {
                    for (column, second) in found {
                        if let (Some(row), Some(column)) = (row, column) {
                            penalty[(row, column)] += power * first * second;
                        }
                    }
                }
            }
        }
        penalty
    }
}
