//! How well a model predicts a record that it has not seen.
//!
//! The model runs forward over the record's inputs. What it cannot know is taken from the record's outputs first: the offset, which
//! belongs to the day, and what was stored before the first row, as one decay a rate with a prior as wide as the inputs ever moved
//! the model, c_k ~ N(0, (R_k · range of u)²). Or, if the record goes on where the identified one ended, the model goes on as well,
//! and nothing is taken from the outputs.

use nalgebra::{DMatrix, DVector};

use super::problem::Problem;
use super::record::{RecordError, Source};
use super::residuals::Residuals;
use crate::model::{Forward, Gas, Model, Whiteness};

/// What the model starts from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Start {
    /// Offset and stored heat are estimated from the record.
    Estimate,
    /// Where the identified record ended.
    Continue,
    /// All states zero and the model's own offset.
    Rest,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Validated {
    pub outputs: Vec<Scored>,
    pub rows: u64,
    pub start: Start,
    /// Why the figures say little, if they do: sentences for the user.
    pub warnings: Vec<String>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Scored {
    pub name: String,
    pub rmse: f64,
    /// 0 where the output is the same in all rows, as there is nothing to fit.
    pub fit_percent: f64,
    /// The output's value, if it is the same in all rows.
    pub constant: Option<f64>,
    pub offset_c: f64,
    pub whiteness: Option<Whiteness>,
}

#[derive(Debug, thiserror::Error)]
pub enum ValidateError {
    #[error(transparent)]
    Record(#[from] RecordError),
    #[error("{}: {sentence}", record.display())]
    Unfit { record: std::path::PathBuf, sentence: String },
}

/// Rows of measured and predicted outputs, for whoever draws them.
pub type Sight<'a> = dyn FnMut(&super::residuals::Seen<'_>) + 'a;

/// Predicts the record. Its inputs and outputs are the model's, in order.
pub fn validate(
    model: &Model,
    source: &mut dyn Source,
    start: Start,
    sight: &mut Sight<'_>,
) -> Result<Validated, ValidateError> {
    let unfit =
        |source: &dyn Source, sentence: String| ValidateError::Unfit { record: source.survey().path.clone(), sentence };
    let survey = source.survey().clone();
    if survey.inputs.len() != model.inputs.len() || survey.outputs.len() != model.outputs.len() {
        let sentence = format!(
            "has {} inputs and {} outputs where the model has {} and {}: name them with --input and --output, in the model's order",
            survey.inputs.len(),
            survey.outputs.len(),
            model.inputs.len(),
            model.outputs.len()
        );
        return Err(unfit(source, sentence));
    }
    if let Some(Gas::Column(name)) = model.wind.as_ref().map(|wind| &wind.gas)
        && survey.gas_column.is_none()
    {
        let sentence =
            format!("has no gas column: the model needs the temperature of the gas, which was column `{name}`");
        return Err(unfit(source, sentence));
    }
    let mut forward = Forward::at_rest(model, survey.sample_period_s);
    let mut offsets: Vec<f64> = model.outputs.iter().map(|output| output.offset_c).collect();
    match start {
        Start::Rest => {}
        Start::Continue => {
            let gap_s = model.end.as_ref().map(|end| survey.first_time_s - end.next_time_s);
            match (&model.end, gap_s) {
                (Some(end), Some(gap_s)) if gap_s.abs() < 0.5 * survey.sample_period_s => {
                    forward = Forward::going_on(model, end);
                }
                (Some(end), _) => {
                    let sentence = format!(
                        "begins at {} s, but the identified record goes on at {} s: only the row that follows it can be continued",
                        shown_s(survey.first_time_s),
                        shown_s(end.next_time_s)
                    );
                    return Err(unfit(source, sentence));
                }
                (None, _) => {
                    let sentence = "cannot be continued: the model does not hold where its record ended, as none does that was merged; say --start estimate or --start rest";
                    return Err(unfit(source, sentence.to_owned()));
                }
            }
        }
        Start::Estimate => {
            let unknowns =
                (0..model.outputs.len()).map(|output| prior_widths(model, output).len() + 1).max().unwrap_or(1);
            if survey.rows <= unknowns as u64 {
                let sentence = format!(
                    "has {} rows, from which {unknowns} numbers would be estimated before anything is left to compare: give a longer record, or say --start rest",
                    survey.rows
                );
                return Err(unfit(source, sentence));
            }
            let beginnings = estimate(model, source, &mut forward)?;
            forward = Forward::at_rest(model, survey.sample_period_s);
            for (output, beginning) in beginnings.iter().enumerate() {
                offsets[output] += beginning.offset_k;
                forward.set_offset(output, offsets[output]);
                forward.add_decays(output, &beginning.decays, survey.sample_period_s);
            }
        }
    }
    let mut residuals = vec![Residuals::default(); model.outputs.len()];
    let mut constant: Vec<Option<f64>> = vec![None; model.outputs.len()];
    run(model, source, &mut forward, Losses::Predicted, &mut |seen| {
        for ((residuals, measured), predicted) in residuals.iter_mut().zip(seen.measured).zip(seen.predicted) {
            residuals.push(*measured, *predicted);
        }
        for (constant, &measured) in constant.iter_mut().zip(seen.measured) {
            *constant = if seen.row == 0 { Some(measured) } else { constant.filter(|first| *first == measured) };
        }
        sight(seen);
    })?;
    let scored = |output: usize| Scored {
        name: model.outputs[output].name.clone(),
        rmse: residuals[output].rms(),
        fit_percent: if constant[output].is_some() { 0.0 } else { residuals[output].fit_percent() },
        constant: constant[output],
        offset_c: offsets[output],
        whiteness: residuals[output].whiteness(),
    };
    let outputs: Vec<Scored> = (0..model.outputs.len()).map(scored).collect();
    let is_none = |scored: &&Scored| !(scored.rmse.is_finite() && scored.fit_percent.is_finite());
    if let Some(scored) = outputs.iter().find(is_none) {
        let sentence = format!(
            "what the model predicts for `{}` is too large to compute with: are the inputs in the units of the model's record?",
            scored.name
        );
        return Err(unfit(source, sentence));
    }
    let warnings = warnings(&outputs, survey.rows);
    Ok(Validated { outputs, rows: survey.rows, start, warnings })
}

/// Why figures say less than they seem to.
fn warnings(outputs: &[Scored], rows: u64) -> Vec<String> {
    let mut warnings = Vec::new();
    for (scored, value) in outputs.iter().filter_map(|scored| Some((scored, scored.constant?))) {
        warnings.push(format!(
            "`{}` is {value} in all rows, so there is no fit to tell: is it the right column, and is the sensor connected?",
            scored.name
        ));
    }
    if rows < super::LEAST_ROWS {
        let least = super::LEAST_ROWS;
        warnings.push(format!("{rows} rows say next to nothing of a model: give a record of {least} at least"));
    }
    warnings
}

/// A time without the digits that come of adding periods up.
fn shown_s(time_s: f64) -> f64 {
    format!("{time_s:.9e}").parse().unwrap_or(time_s)
}

/// What an output's record began with.
struct Beginning {
    /// To be added to the model's offset.
    offset_k: f64,
    /// (rate in rad/s, amplitude in K at the first row)
    decays: Vec<(f64, f64)>,
}

/// What a model at rest leaves of the record, as offsets and decays.
///
/// The wind takes heat by the measured temperatures here, as in identification: then what is left is linear in offsets and decays,
/// and one problem of least squares has the answer. By the predicted ones, the loss would follow the decays that are sought.
fn estimate(model: &Model, source: &mut dyn Source, forward: &mut Forward) -> Result<Vec<Beginning>, ValidateError> {
    let period_s = source.survey().sample_period_s;
    let widths: Vec<Vec<(f64, f64)>> = (0..model.outputs.len()).map(|output| prior_widths(model, output)).collect();
    let mut columns: Vec<Vec<f64>> = widths.iter().map(|rates| vec![1.0; rates.len() + 1]).collect();
    let factors: Vec<Vec<f64>> = widths
        .iter()
        .map(|rates| rates.iter().map(|(rate, _)| 1.0 - dr_core::model::mesh::gain(*rate, period_s)).collect())
        .collect();
    let empty =
        |count: usize| Problem { g: DMatrix::zeros(count, count), b: DVector::zeros(count), yy: 0.0, rows: 0.0 };
    let mut problems: Vec<Problem> = columns.iter().map(|columns| empty(columns.len())).collect();
    run(model, source, forward, Losses::Measured, &mut |seen| {
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
    let mut beginnings = Vec::new();
    for (output, problem) in problems.iter_mut().enumerate() {
        problem.g.fill_upper_triangle_with_lower_triangle();
        let variance = model.outputs[output].residual_rms.powi(2);
        let mut penalty = DMatrix::zeros(problem.b.len(), problem.b.len());
        for (i, (_, width)) in widths[output].iter().enumerate() {
            penalty[(i, i)] = variance / (width * width).max(f64::MIN_POSITIVE);
        }
        let theta = problem.estimate(&penalty, None);
        beginnings.push(Beginning {
            offset_k: theta[widths[output].len()],
            decays: widths[output].iter().zip(theta.iter()).map(|(&(rate, _), &amplitude)| (rate, amplitude)).collect(),
        });
    }
    Ok(beginnings)
}

/// For every rate of an output, how much its stored heat may amount to, K.
fn prior_widths(model: &Model, output: usize) -> Vec<(f64, f64)> {
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
    if let Some(following) = model.wind.as_ref().and_then(|wind| wind.following.as_ref()) {
        let range_k = following.range_c[1] - following.range_c[0];
        let own = following.mesh_rad_s.iter().zip(&following.outputs[output].f_k_per_k);
        own.for_each(|(&rate, f_k_per_k)| widen(rate, f_k_per_k.abs() * range_k));
    }
    widths
}

/// By whose temperatures the wind takes heat.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Losses {
    Predicted,
    Measured,
}

/// Runs the model over the record from its first row.
fn run(
    model: &Model,
    source: &mut dyn Source,
    forward: &mut Forward,
    losses: Losses,
    seen: &mut dyn FnMut(&super::residuals::Seen<'_>),
) -> Result<(), ValidateError> {
    source.restart()?;
    let path = source.survey().path.clone();
    let event_column = source.survey().event_column.clone().unwrap_or_default();
    let (inputs, outputs) = (model.inputs.len(), model.outputs.len());
    let constant_gas_c = match model.wind.as_ref().map(|wind| &wind.gas) {
        Some(Gas::ConstantC(gas_c)) => *gas_c,
        Some(Gas::EstimatedC(gas)) => gas.value,
        Some(Gas::Column(_)) | None => 0.0,
    };
    let (mut input_row, mut measured, mut predicted) = (vec![0.0; inputs], vec![0.0; outputs], vec![0.0; outputs]);
    let mut row = 0;
    // Which of the model's classes each of the record's is.
    let mut classes: Vec<usize> = Vec::new();
    while let Some(block) = source.next_block()?.cloned() {
        for label in source.classes().iter().skip(classes.len()) {
            let known = model.classes.iter().position(|known| known == label);
            if known.is_none() && model.classes.len() > 1 {
                let sentence = format!(
                    "column `{event_column}`: the model knows no class `{label}`; it was identified for {}",
                    model.classes.join(", ")
                );
                return Err(ValidateError::Unfit { record: path, sentence });
            }
            classes.push(known.unwrap_or(0));
        }
        for at in 0..block.len() {
            for (value, column) in input_row.iter_mut().zip(&block.inputs) {
                *value = column[at];
            }
            for (value, column) in measured.iter_mut().zip(&block.outputs) {
                *value = column[at];
            }
            let class = classes[block.class[at] as usize];
            let gas_c = block.gas.get(at).copied().unwrap_or(constant_gas_c);
            match losses {
                Losses::Predicted => forward.row(&input_row, class, gas_c, &mut predicted),
                Losses::Measured => forward.row_of_measured(&input_row, class, gas_c, &measured, &mut predicted),
            }
            seen(&super::residuals::Seen { row, class, measured: &measured, predicted: &predicted });
            row += 1;
        }
    }
    source.restart()?;
    Ok(())
}
