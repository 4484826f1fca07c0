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

    pub fn sample_period_s(&self) -> f64 {
        self.sample_period_s
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
        let value = |column: usize| next.get(column).copied().unwrap_or(0.0);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::accumulator::Accumulator;
    use crate::identify::design::GasSource;
    use crate::identify::design::RelaxationBank;
    use crate::identify::drift::Section;
    use crate::identify::record::Block;

    const PERIOD_S: f64 = 0.5;
    const POLES_RAD_S: [f64; 2] = [0.05, 0.4];

    fn value(n: usize, factor: usize) -> f64 {
        ((n * factor) % 101) as f64 / 50.0 - 1.0
    }

    /// Two relaxations and a feed-through of one input, an initial decay, an output; and the poles.
    fn design() -> RegressionDesign {
        let bank = |drive, rates_rad_s: &[f64], feed_through| RelaxationBank {
            drive,
            rates_rad_s: rates_rad_s.to_vec(),
            delay: 0,
            feed_through,
        };
        RegressionDesign {
            banks: vec![
                bank(BankDrive::Input(0), &[0.02, 0.05, 0.1, 0.4], true),
                bank(BankDrive::Output(0), &POLES_RAD_S, false),
            ],
            initial_rad_s: vec![0.02, 0.05, 0.4],
            outputs: 1,
            from_rest: false,
        }
    }

    /// The columns row by row, from the sums of one row each.
    fn rows(count: usize) -> (Vec<Vec<f64>>, Gram, Vec<f64>) {
        let (design, shift) = (design(), 3.0);
        let block = |from: usize, to: usize| Block {
            inputs: vec![(from..to).map(|n| value(n, 37)).collect()],
            outputs: vec![(from..to).map(|n| shift + value(n, 53)).collect()],
            class: vec![0; to - from],
            ..Block::default()
        };
        let mut whole = Accumulator::new(&design, &[], PERIOD_S, count as u64, 1, &[shift], 0);
        whole.push(&block(0, count), GasSource::Constant(0.0));
        let (folds, ends) = whole.finish();
        // The offset's column is one: products with it are the columns themselves.
        let offset = design.roles().len() - 1;
        let mut single = Accumulator::new(&design, &[], PERIOD_S, count as u64, count, &[shift], 0);
        single.push(&block(0, count), GasSource::Constant(0.0));
        let columns = single.finish().0.iter().map(|gram| gram.sums.column(offset).as_slice().to_vec()).collect();
        (columns, folds[0].clone(), ends[0].clone())
    }

    fn filters() -> Vec<NoiseFilter> {
        let [slow, fast] = POLES_RAD_S;
        let section = |pole_rad_s, zero_rad_s| Section { pole_rad_s, zero_rad_s };
        vec![
            NoiseFilter::walk(slow),
            NoiseFilter { kind: DriftKind::Correlated, sections: vec![section(fast, 0.03)] },
            NoiseFilter { kind: DriftKind::Correlated, sections: vec![section(fast, 0.01), section(slow, 0.2)] },
            NoiseFilter { kind: DriftKind::IntegratedWalk, sections: vec![section(slow, 0.0), section(fast, 0.0)] },
        ]
    }

    /// (1 − φL)/(1 − ϑL) as it is defined, one section after the other.
    fn filtered(values: &[f64], filter: &NoiseFilter) -> Vec<f64> {
        filter.sections.iter().fold(values.to_vec(), |values, section| {
            let [pole, zero] = [section.pole_rad_s, section.zero_rad_s].map(|rate| libm::exp(-rate * PERIOD_S));
            let mut last = (0.0, 0.0);
            values
                .iter()
                .map(|&now| {
                    last = (now, now - zero * last.0 + pole * last.1);
                    last.1
                })
                .collect()
        })
    }

    #[test]
    fn sums_of_columns_are_what_a_filter_makes_of_each() {
        let (rows, _, _) = rows(150);
        let (columns, design) = (PoleColumns::of(&design(), PERIOD_S), design());
        let outputs = columns.output(0);
        for filter in filters() {
            let is_its = |column: &usize| {
                *column == outputs
                    || design.roles().get(*column).is_some_and(|role| match role {
                        Role::Relaxation { bank: 0, rate_rad_s, .. } | Role::Initial { rate_rad_s } => {
                            !POLES_RAD_S.contains(rate_rad_s)
                        }
                        Role::Relaxation { .. } => false,
                        _ => true,
                    })
            };
            for column in (0..=outputs).filter(is_its) {
                let plain: Vec<f64> = rows.iter().map(|row| row[column]).collect();
                let sum = columns.innovations(&[(column, 1.0)], &filter);
                for (row, expected) in rows.iter().zip(filtered(&plain, &filter)) {
                    let found: f64 = sum.iter().map(|&(at, weight)| weight * row[at]).sum();
                    assert!((found - expected).abs() < 1e-11, "{filter:?}, column {column}: {found} for {expected}");
                }
            }
        }
    }

    #[test]
    fn a_level_is_what_the_next_innovation_would_lack() {
        let (rows, _, ends) = rows(150);
        let columns = PoleColumns::of(&design(), PERIOD_S);
        let residual = [(0, -0.7), (2, 0.3), (columns.output(0), 1.0), (columns.output(0) - 1, 0.2)];
        let of = |row: &Vec<f64>| residual.iter().map(|&(at, weight)| weight * row[at]).sum::<f64>();
        let values: Vec<f64> = rows.iter().map(of).collect();
        for filter in filters() {
            // v = r − level, whatever the next r is.
            let next = filtered(&[&values[..], &[5.0]].concat(), &filter);
            let level = columns.level(&residual, &filter, &ends);
            assert!((5.0 - next[values.len()] - level).abs() < 1e-10, "{filter:?}");
        }
    }
}
