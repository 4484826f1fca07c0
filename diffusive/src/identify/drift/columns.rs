//! Filtered columns as sums of columns.
//!
//! ```text
//! E_n = (1 − ϑ) Σ_{j ≥ 0} ϑ^j c_{n−1−j}
//! c a relaxation x of u at ξ_k:   E = ((1 − ϑ) x − (1 − a) s)/(a − ϑ),     s that of u at ξ
//! c = a^n:                        E = (1 − ϑ)(a^n − ϑ^n)/(a − ϑ)
//! c = u:                          E = s
//! ```

use dr_core::model::mesh;

use super::DriftKind;
use super::filter::NoiseFilter;
use crate::identify::design::{BankDrive, RegressionDesign, Role};
use crate::identify::gram::Gram;
use crate::identify::normal_equations::{ModelTerm, NormalEquations};

/// Columns of a design that has filters' poles among its rates.
pub struct PoleColumns {
    roles: Vec<Role>,
    /// Bank of every output.
    output_banks: Vec<usize>,
    sample_period_s: f64,
}

impl PoleColumns {
    pub fn of(design: &RegressionDesign, sample_period_s: f64) -> Self {
        let bank = |output: usize| design.banks.iter().position(|bank| bank.drive == BankDrive::Output(output));
        Self { roles: design.roles(), output_banks: (0..design.outputs).filter_map(bank).collect(), sample_period_s }
    }

    /// The place of an output's column.
    pub fn output(&self, output: usize) -> usize {
        self.roles.len() + output
    }

    /// Terms whose columns are filtered; what they weigh stays.
    pub fn filtered(&self, terms: &[ModelTerm], filter: &NoiseFilter) -> Vec<ModelTerm> {
        let of = |term: &ModelTerm| ModelTerm { of: self.innovations(&term.of, filter), role: term.role };
        terms.iter().map(of).collect()
    }

    /// An output's problem under a filter, and its terms: those of the candidate, and behind them
    /// what the drift itself may have begun with, which has no column in the model.
    ///
    /// A walk begins at the offset. A level that returns may begin anywhere about it, φ^n d_0 with
    /// d_0 as uncertain as the level ever is; a slope anywhere.
    pub fn problem(
        &self,
        gram: &Gram,
        terms: &[ModelTerm],
        output: usize,
        filter: Option<&NoiseFilter>,
    ) -> (Vec<ModelTerm>, NormalEquations) {
        let output = [(self.output(output), 1.0)];
        let Some(filter) = filter else {
            return (terms.to_vec(), NormalEquations::of_sum(gram, terms, &output));
        };
        let (mut terms, mut filtered) = (terms.to_vec(), self.filtered(terms, filter));
        if let Some((of, precision)) = self.start(filter) {
            let role = Role::DriftStart { precision };
            terms.push(ModelTerm { of: Vec::new(), role });
            filtered.push(ModelTerm { of, role });
        }
        let problem = NormalEquations::of_sum(gram, &filtered, &self.innovations(&output, filter));
        (terms, problem)
    }

    /// The filter over what the drift begins with, and its precision in units of the innovations'.
    fn start(&self, filter: &NoiseFilter) -> Option<(Vec<(usize, f64)>, f64)> {
        let (first, others) = filter.sections.split_first()?;
        let others = NoiseFilter { kind: filter.kind, sections: others.to_vec() };
        let decay = self.decay(first.pole_rad_s);
        match filter.kind {
            DriftKind::RandomWalk => None,
            // (1 − φL) φ^n is an impulse.
            DriftKind::Correlated => {
                let size = filter.size(1.0, self.sample_period_s);
                Some((self.innovations(&[(decay, 1.0)], &others), size.powi(-2)))
            }
            // (1 − L) n is a step.
            DriftKind::IntegratedWalk => {
                let offset = self.roles.iter().position(|role| *role == Role::Offset)?;
                let steps = 1.0 / mesh::gain(first.pole_rad_s, self.sample_period_s);
                Some((self.innovations(&[(offset, steps), (decay, -steps)], &others), 0.0))
            }
        }
    }

    /// The filter over a sum of columns.
    pub fn innovations(&self, of: &[(usize, f64)], filter: &NoiseFilter) -> Vec<(usize, f64)> {
        let mut sum = of.to_vec();
        for section in &filter.sections {
            let weight = -section.weight(self.sample_period_s);
            let mut means = Vec::new();
            for &(column, of) in &sum {
                self.mean(column, section.pole_rad_s, weight * of, &mut means);
            }
            sum.extend(means);
            sum = gathered(sum);
        }
        sum
    }

    /// `weight` times the mean E of a column.
    fn mean(&self, column: usize, pole_rad_s: f64, weight: f64, into: &mut Vec<(usize, f64)>) {
        let gain = |rate_rad_s: f64| mesh::gain(rate_rad_s, self.sample_period_s);
        let pole = gain(pole_rad_s);
        let Some(&role) = self.roles.get(column) else {
            let bank = self.output_banks[column - self.roles.len()];
            into.push((self.relaxation(bank, pole_rad_s), weight));
            return;
        };
        match role {
            Role::Relaxation { bank, rate_rad_s, .. } => {
                let own = gain(rate_rad_s);
                let factor = weight / (pole - own);
                into.push((column, factor * pole));
                into.push((self.relaxation(bank, pole_rad_s), -factor * own));
            }
            Role::FeedThrough { bank } => into.push((self.relaxation(bank, pole_rad_s), weight)),
            Role::Initial { rate_rad_s } => {
                let factor = weight * pole / (pole - gain(rate_rad_s));
                into.extend([(column, factor), (self.decay(pole_rad_s), -factor)]);
            }
            Role::DriftStart { .. } => {}
            Role::Offset => into.extend([(column, weight), (self.decay(pole_rad_s), -weight)]),
        }
    }

    fn relaxation(&self, bank: usize, rate: f64) -> usize {
        let is_it = |role: &Role| matches!(role, Role::Relaxation { bank: own, rate_rad_s, .. } if *own == bank && *rate_rad_s == rate);
        self.roles.iter().position(is_it).unwrap_or_default()
    }

    fn decay(&self, rate: f64) -> usize {
        let is_it = |role: &Role| matches!(role, Role::Initial { rate_rad_s } if *rate_rad_s == rate);
        self.roles.iter().position(is_it).unwrap_or_default()
    }

    /// The level of a drift that is expected in the row behind those read: of the residual that is
    /// a sum of columns, whose states are `next`.
    pub fn level(&self, residual: &[(usize, f64)], filter: &NoiseFilter, next: &[f64]) -> f64 {
        let mut past = self.innovations(residual, filter);
        past.extend(residual.iter().map(|&(column, weight)| (column, -weight)));
        let value = |column: usize| match self.roles.get(column) {
            Some(Role::Offset) => 1.0,
            _ => next.get(column).copied().unwrap_or(0.0),
        };
        -gathered(past).into_iter().map(|(column, weight)| weight * value(column)).sum::<f64>()
    }
}

/// Weights of the same column added up.
fn gathered(mut sum: Vec<(usize, f64)>) -> Vec<(usize, f64)> {
    sum.sort_by_key(|(column, _)| *column);
    sum.dedup_by(|next, kept| {
        let is_same = next.0 == kept.0;
        if is_same {
            kept.1 += next.1;
        }
        is_same
    });
    sum
}
