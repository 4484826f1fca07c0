//! How well a model predicts a record that it has not seen.
//!
//! The model runs forward over the record's inputs. What it cannot know is taken from the record's
//! outputs first: the offset, which belongs to the day, and what was stored before the first row.
//! Or, if the record goes on where the identified one ended, the model goes on as well, and nothing
//! is taken from the outputs.

mod report;
mod run;
mod start;
#[cfg(test)]
mod tests;

pub use report::{ValidatedOutput, ValidationReport, ValidationStart};

use super::options::FitObserver;
use super::record::{RecordError, RecordSource, Survey};
use super::residuals::Residuals;
use super::validate_options::LEAST_ROWS;
use crate::model::{Forward, Model, ModelOutput, RecordEnd};
use recording::text::short;
use run::{LossesBy, run};
use start::{EstimatedStart, estimate, prior_widths};

/// How often the offset is estimated where losses count from it: what is wrong with it shrinks by
/// 2 b ΔT each time.
const OFFSETS: usize = 6;

/// Fit below which a model is said not to hold, %.
const POOR_PERCENT: f64 = 50.0;

/// Times the error that is to be expected beyond which conditions are other ones: 80 % of measured
/// records are within two.
const BEYOND: f64 = 2.5;

/// Predicts the record. Its inputs and outputs are the model's, in order.
///
/// # Errors
/// If the record cannot be read, or model, record and start do not go together.
pub fn validate(
    model: &Model,
    source: &mut dyn RecordSource,
    start: ValidationStart,
    observer: &mut FitObserver<'_>,
) -> Result<ValidationReport, RecordError> {
    check_columns(model, source.survey())?;
    let (rows, period_s) = (source.survey().rows, source.survey().sample_period_s);
    let starts = starts(model, source, start)?;
    let mut residuals = vec![Residuals::default(); model.outputs.len()];
    let mut begin = |segment: usize| starts[segment].forward(model, period_s);
    run(model, source, &mut begin, LossesBy::Predicted, &mut |_, seen| {
        for ((residuals, measured), predicted) in residuals.iter_mut().zip(seen.measured).zip(seen.predicted) {
            if !measured.is_nan() && !predicted.is_nan() {
                residuals.push(*measured, *predicted, 0.0);
            }
        }
        observer(seen);
    })?;
    let validated = |output: usize| ValidatedOutput {
        name: model.outputs[output].name.clone(),
        rmse: residuals[output].rms(),
        fit_percent: residuals[output].constant().is_none().then(|| residuals[output].fit_percent()),
        constant: residuals[output].constant(),
        offset_c: starts[0].offset_c(model, output),
        whiteness: residuals[output].whiteness(),
    };
    let outputs: Vec<ValidatedOutput> = (0..model.outputs.len()).map(validated).collect();
    let is_finite = |output: &ValidatedOutput| output.rmse.is_finite() && output.fit_percent.is_none_or(f64::is_finite);
    if let Some(output) = outputs.iter().find(|output| !is_finite(output)) {
        return Err(source.survey().refuse(format!(
            "what the model predicts for `{}` is too large to compute with: are the inputs in the units of the model's record?",
            output.name
        )));
    }
    let mut warnings = warnings(&outputs, rows);
    warnings.extend(model.outputs.iter().zip(&outputs).filter_map(|(known, scored)| beyond(known, scored)));
    let short = starts.iter().filter(|start| matches!(start, SegmentStart::TooShort)).count();
    if short > 0 {
        warnings.push(format!(
            "{short} of {} segments left out: no more rows than what a segment begins with has numbers",
            starts.len()
        ));
    }
    let Survey { segments, notes, .. } = source.survey().clone();
    Ok(ValidationReport { outputs, rows, segments, notes, start, warnings })
}

fn check_columns(model: &Model, survey: &Survey) -> Result<(), RecordError> {
    let (inputs, outputs) = (survey.inputs.len(), survey.outputs.len());
    let (model_inputs, model_outputs) = (model.inputs.len(), model.outputs.len());
    survey.refuse_if(
        (inputs, outputs) != (model_inputs, model_outputs),
        format_args!("has {inputs} inputs and {outputs} outputs where the model has {model_inputs} and {model_outputs}: name them with --input and --output, in the model's order"),
    )?;
    match model.gas_column() {
        Some(column) if survey.gas_column.is_none() => Err(survey.refuse(format!(
            "has no gas column: the model needs the temperature of gas or surroundings, which was column `{column}`"
        ))),
        _ => Ok(()),
    }
}

/// How the model begins a segment.
enum SegmentStart<'m> {
    Rest,
    Continue(&'m RecordEnd),
    Estimate {
        offset_c: Vec<f64>,
        decays: Vec<Vec<(f64, f64)>>,
    },
    /// Too short to tell.
    TooShort,
}

impl SegmentStart<'_> {
    fn forward(&self, model: &Model, period_s: f64) -> Option<Forward> {
        match self {
            Self::Rest => Some(Forward::at_rest(model, period_s)),
            Self::Continue(end) => Some(Forward::going_on(model, end)),
            Self::Estimate { offset_c, decays } => {
                let mut forward = Forward::at_rest(model, period_s);
                for (output, (&offset_c, decays)) in offset_c.iter().zip(decays).enumerate() {
                    forward.set_offset(output, offset_c);
                    forward.add_decays(output, decays, period_s);
                }
                Some(forward)
            }
            Self::TooShort => None,
        }
    }

    fn offset_c(&self, model: &Model, output: usize) -> f64 {
        match self {
            Self::Estimate { offset_c, .. } => offset_c[output],
            Self::Rest | Self::Continue(_) | Self::TooShort => model.outputs[output].offset_c,
        }
    }
}

/// How the model begins every segment: the first as `start` says, the others as they tell.
fn starts<'m>(
    model: &'m Model,
    source: &mut dyn RecordSource,
    start: ValidationStart,
) -> Result<Vec<SegmentStart<'m>>, RecordError> {
    let first = match start {
        ValidationStart::Rest => Some(SegmentStart::Rest),
        ValidationStart::Continue => Some(SegmentStart::Continue(continued(model, source.survey())?)),
        ValidationStart::Estimate => None,
    };
    match first {
        Some(first) if source.survey().segments == 1 => Ok(vec![first]),
        Some(first) => Ok(std::iter::once(first).chain(estimated(model, source)?.into_iter().skip(1)).collect()),
        None => estimated(model, source),
    }
}

/// What the outputs of every segment tell of its beginning.
fn estimated<'m>(model: &'m Model, source: &mut dyn RecordSource) -> Result<Vec<SegmentStart<'m>>, RecordError> {
    let (period_s, rows) = (source.survey().sample_period_s, source.survey().rows);
    let unknowns = (0..model.outputs.len()).map(|output| prior_widths(model, output).len() + 1).max().unwrap_or(1);
    source.survey().refuse_if(
        rows <= unknowns as u64,
        format_args!("has {rows} rows, from which {unknowns} numbers would be estimated before anything is left to compare: give a longer record, or say --start rest"),
    )?;
    // Growing losses count from the offset, which is the day's: once more with what was found, as
    // it moves them a little.
    let given: Vec<f64> = model.outputs.iter().map(|output| output.offset_c).collect();
    let (mut offsets, mut found) = (Vec::<Vec<f64>>::new(), Vec::new());
    for _ in 0..if model.losses.is_some() { OFFSETS } else { 1 } {
        let mut begin = |segment: usize| {
            let mut forward = Forward::at_rest(model, period_s);
            let own = offsets.get(segment).unwrap_or(&given);
            own.iter().enumerate().for_each(|(output, &offset_c)| forward.set_offset(output, offset_c));
            Some(forward)
        };
        found = estimate(model, source, &mut begin)?;
        offsets.resize(found.len(), given.clone());
        for (offsets, found) in offsets.iter_mut().zip(&found) {
            offsets.iter_mut().zip(&found.offset_k).for_each(|(offset, more)| *offset += more);
        }
    }
    let start = |(found, offset_c): (EstimatedStart, Vec<f64>)| match found.rows > unknowns as u64 {
        true => SegmentStart::Estimate { offset_c, decays: found.decays },
        false => SegmentStart::TooShort,
    };
    Ok(found.into_iter().zip(offsets).map(start).collect())
}

/// Where the identified record ended, if this one goes on with the next row.
fn continued<'m>(model: &'m Model, survey: &Survey) -> Result<&'m RecordEnd, RecordError> {
    let no_end = "cannot be continued: the model does not hold where its record ended, as none does that was merged; say --start estimate or --start rest";
    let end = model.end.as_ref().ok_or_else(|| survey.refuse(no_end))?;
    let gap_s = survey.first_time_s - end.next_time_s;
    if gap_s.abs() < 0.5 * survey.sample_period_s {
        return Ok(end);
    }
    Err(survey.refuse(format!(
        "begins at {} s, but the identified record goes on at {} s: only the row that follows it can be continued",
        shown_s(survey.first_time_s),
        shown_s(end.next_time_s)
    )))
}

/// Why figures say less than they seem to.
fn warnings(outputs: &[ValidatedOutput], rows: u64) -> Vec<String> {
    let mut warnings = Vec::new();
    for (scored, value) in outputs.iter().filter_map(|scored| Some((scored, scored.constant?))) {
        warnings.push(format!(
            "`{}` is {value} in all rows, so there is no fit to tell: is it the right column, and is the sensor connected?",
            scored.name
        ));
    }
    for (scored, fit) in outputs.iter().filter_map(|scored| Some((scored, scored.fit_percent?))) {
        if fit < POOR_PERCENT {
            let verdict = if fit <= 0.0 { "no better than its mean" } else { "poorly" };
            warnings.push(format!(
                "`{}` is predicted {verdict}: the model does not hold for this record. Are these the same columns, units and conditions, and does the identified record support its model (its warnings)? Another offset is found by --start estimate",
                scored.name
            ));
        }
    }
    if rows < LEAST_ROWS {
        warnings.push(format!("{rows} rows say next to nothing of a model: give a record of {LEAST_ROWS} at least"));
    }
    warnings
}

/// An error that is much larger than what the model's own record lets expect.
fn beyond(known: &ModelOutput, scored: &ValidatedOutput) -> Option<String> {
    let expected = known.forecast_rms?;
    let is_poor = scored.fit_percent.is_some_and(|fit| fit < POOR_PERCENT);
    (scored.rmse > BEYOND * expected && !is_poor).then(|| {
        format!(
            "`{}` is predicted with {:.1} times the error that the model's record lets expect ({}): this record has other conditions, or a disturbance, that the model has not seen",
            scored.name,
            scored.rmse / expected,
            short(expected, 2)
        )
    })
}

/// A time without the digits that come of adding periods up.
fn shown_s(time_s: f64) -> f64 {
    format!("{time_s:.9e}").parse().unwrap_or(time_s)
}
