//! What each segment of a record began with, as far as its outputs tell: one offset, and one decay
//! a rate with a prior as wide as the inputs ever moved the model, c_k ~ N(0, (R_k · range of u)²).

use nalgebra::{DMatrix, DVector};

use super::super::normal_equations::NormalEquations;
use super::super::record::{RecordError, RecordSource};
use super::run::{LossesBy, run};
use crate::model::{Forward, Model};

/// What a segment began with, output by output; as many rows told it.
#[derive(Debug, Clone, Default)]
pub(super) struct EstimatedStart {
    /// To be added to the offsets with which the model ran.
    pub(super) offset_k: Vec<f64>,
    /// (rate in rad/s, amplitude in K at the first row)
    pub(super) decays: Vec<Vec<(f64, f64)>>,
    pub(super) rows: u64,
}

/// The problem of one segment, row by row.
struct StartProblem {
    /// By output: decays in this row, and 1.
    columns: Vec<Vec<f64>>,
    equations: Vec<NormalEquations>,
}

impl StartProblem {
    fn of(widths: &[Vec<(f64, f64)>]) -> Self {
        let empty = |count: usize| NormalEquations {
            g: DMatrix::zeros(count, count),
            b: DVector::zeros(count),
            yy: 0.0,
            rows: 0.0,
        };
        Self {
            columns: widths.iter().map(|rates| vec![1.0; rates.len() + 1]).collect(),
            equations: widths.iter().map(|rates| empty(rates.len() + 1)).collect(),
        }
    }

    /// Takes a row of one output; `rest` is NaN where it is missing.
    fn add(&mut self, output: usize, rest: f64, factors: &[f64]) {
        let (column, problem) = (&mut self.columns[output], &mut self.equations[output]);
        if rest.is_finite() {
            for (i, &left) in column.iter().enumerate() {
                problem.b[i] += left * rest;
                for (j, right) in column.iter().enumerate().take(i + 1) {
                    problem.g[(i, j)] += left * right;
                }
            }
            problem.yy += rest * rest;
            problem.rows += 1.0;
        }
        column.iter_mut().zip(factors).for_each(|(value, factor)| *value *= factor);
    }

    fn solved(mut self, model: &Model, widths: &[Vec<(f64, f64)>]) -> EstimatedStart {
        let mut start = EstimatedStart::default();
        for ((problem, widths), output) in self.equations.iter_mut().zip(widths).zip(&model.outputs) {
            problem.g.fill_upper_triangle_with_lower_triangle();
            let variance = output.residual_rms.powi(2);
            let mut penalty = DMatrix::zeros(problem.b.len(), problem.b.len());
            for (i, (_, width)) in widths.iter().enumerate() {
                penalty[(i, i)] = variance / (width * width).max(f64::MIN_POSITIVE);
            }
            let theta = problem.estimate(&penalty, None);
            start.offset_k.push(theta[widths.len()]);
            start
                .decays
                .push(widths.iter().zip(theta.iter()).map(|(&(rate, _), &amplitude)| (rate, amplitude)).collect());
            start.rows = problem.rows as u64;
        }
        start
    }
}

/// What a model leaves of the record's segments, as offsets and decays.
///
/// The wind takes heat by the measured temperatures here, as in identification: then what is left
/// is linear in offsets and decays, and one problem of least squares has the answer. By the
/// predicted ones, the loss would follow the decays that are sought.
pub(super) fn estimate(
    model: &Model,
    source: &mut dyn RecordSource,
    begin: &mut dyn FnMut(usize) -> Option<Forward>,
) -> Result<Vec<EstimatedStart>, RecordError> {
    let period_s = source.survey().sample_period_s;
    let widths: Vec<Vec<(f64, f64)>> = (0..model.outputs.len()).map(|output| prior_widths(model, output)).collect();
    let factor = |(rate, _): &(f64, f64)| 1.0 - dr_core::model::mesh::gain(*rate, period_s);
    let factors: Vec<Vec<f64>> = widths.iter().map(|rates| rates.iter().map(factor).collect()).collect();
    let mut problems: Vec<StartProblem> = Vec::new();
    run(model, source, begin, LossesBy::Measured, &mut |segment, seen| {
        if problems.len() <= segment {
            problems.push(StartProblem::of(&widths));
        }
        for (output, factors) in factors.iter().enumerate() {
            problems[segment].add(output, seen.measured[output] - seen.predicted[output], factors);
        }
    })?;
    Ok(problems.into_iter().map(|problem| problem.solved(model, &widths)).collect())
}

/// For every rate of an output, how much its stored heat may amount to, K.
pub(super) fn prior_widths(model: &Model, output: usize) -> Vec<(f64, f64)> {
    let mut widths: Vec<(f64, f64)> = Vec::new();
    let mut widen = |rate: f64, greatest: f64| {
        if greatest > 0.0 {
            match widths.iter_mut().find(|(known, _)| *known == rate) {
                Some((_, width)) => *width = libm::hypot(*width, greatest),
                None => widths.push((rate, greatest)),
            }
        }
    };
    for pair in model.pairs.iter().filter(|pair| pair.output == model.outputs[output].name) {
        let input = model.inputs.iter().position(|name| *name == pair.input).unwrap_or(0);
        let range = model
            .provenance
            .input_range
            .get(input)
            .map_or(1.0, |[least, most]| most.abs().max(least.abs()).max(most - least));
        for (k, &rate) in pair.mesh_rad_s.iter().enumerate() {
            let greatest = pair.classes.values().map(|class| class.r_k_per_w[k].abs()).fold(0.0, f64::max) * range;
            widen(rate, greatest);
        }
    }
    if let Some(following) = model.following() {
        let range_k = following.range_c[1] - following.range_c[0];
        let own = following.mesh_rad_s.iter().zip(&following.outputs[output].f_k_per_k);
        own.for_each(|(&rate, f_k_per_k)| widen(rate, f_k_per_k.abs() * range_k));
    }
    widths
}
