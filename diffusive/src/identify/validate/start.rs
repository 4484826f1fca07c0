//! What a record began with, as far as its outputs tell: one offset, and one decay a rate with a
//! prior as wide as the inputs ever moved the model, c_k ~ N(0, (R_k · range of u)²).

use nalgebra::{DMatrix, DVector};

use super::super::normal_equations::NormalEquations;
use super::super::record::{RecordError, RecordSource};
use super::run::{LossesBy, run};
use crate::model::{Forward, Model};

/// What an output's record began with.
pub(super) struct EstimatedStart {
    /// To be added to the model's offset.
    pub(super) offset_k: f64,
    /// (rate in rad/s, amplitude in K at the first row)
    pub(super) decays: Vec<(f64, f64)>,
}

/// What a model at rest leaves of the record, as offsets and decays.
///
/// The wind takes heat by the measured temperatures here, as in identification: then what is left
/// is linear in offsets and decays, and one problem of least squares has the answer. By the
/// predicted ones, the loss would follow the decays that are sought.
pub(super) fn estimate(
    model: &Model,
    source: &mut dyn RecordSource,
    forward: &mut Forward,
) -> Result<Vec<EstimatedStart>, RecordError> {
    let period_s = source.survey().sample_period_s;
    let widths: Vec<Vec<(f64, f64)>> = (0..model.outputs.len()).map(|output| prior_widths(model, output)).collect();
    let mut columns: Vec<Vec<f64>> = widths.iter().map(|rates| vec![1.0; rates.len() + 1]).collect();
    let factors: Vec<Vec<f64>> = widths
        .iter()
        .map(|rates| rates.iter().map(|(rate, _)| 1.0 - dr_core::model::mesh::gain(*rate, period_s)).collect())
        .collect();
    let empty = |count: usize| NormalEquations {
        g: DMatrix::zeros(count, count),
        b: DVector::zeros(count),
        yy: 0.0,
        rows: 0.0,
    };
    let mut problems: Vec<NormalEquations> = columns.iter().map(|columns| empty(columns.len())).collect();
    run(model, source, forward, LossesBy::Measured, &mut |seen| {
        for (output, problem) in problems.iter_mut().enumerate() {
            let rest = seen.measured[output] - seen.predicted[output];
            let column = &mut columns[output];
            for (i, &left) in column.iter().enumerate() {
                problem.b[i] += left * rest;
                for (j, right) in column.iter().enumerate().take(i + 1) {
                    problem.g[(i, j)] += left * right;
                }
            }
            problem.yy += rest * rest;
            problem.rows += 1.0;
            for (value, factor) in column.iter_mut().zip(&factors[output]) {
                *value *= factor;
            }
        }
    })?;
    let mut initial_states = Vec::new();
    for (output, problem) in problems.iter_mut().enumerate() {
        problem.g.fill_upper_triangle_with_lower_triangle();
        let variance = model.outputs[output].residual_rms.powi(2);
        let mut penalty = DMatrix::zeros(problem.b.len(), problem.b.len());
        for (i, (_, width)) in widths[output].iter().enumerate() {
            penalty[(i, i)] = variance / (width * width).max(f64::MIN_POSITIVE);
        }
        let theta = problem.estimate(&penalty, None);
        initial_states.push(EstimatedStart {
            offset_k: theta[widths[output].len()],
            decays: widths[output].iter().zip(theta.iter()).map(|(&(rate, _), &amplitude)| (rate, amplitude)).collect(),
        });
    }
    Ok(initial_states)
}

/// For every rate of an output, how much its stored heat may amount to, K.
pub(super) fn prior_widths(model: &Model, output: usize) -> Vec<(f64, f64)> {
    let mut widths: Vec<(f64, f64)> = Vec::new();
    let mut widen = |rate: f64, greatest: f64| {
        if greatest > 0.0 {
            match widths.iter_mut().find(|(known, _)| *known == rate) {
                Some((_, width)) => *width = width.hypot(greatest),
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
