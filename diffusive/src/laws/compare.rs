//! Fits all laws and the diffusive model to the first part of a record, and holds them against the
//! second.

use super::fit::{FitProblem, LawFit};
use super::law::ResponseLaw;
use super::model_line;
use super::record::{FittedPart, ForecastRecord};
use super::report::{LawForecast, LawTerm, LawsReport, PartFigures};
use super::stream::InputStream;
use super::verdict::{block_errors, is_within_noise};
use crate::identify::Progress;
use crate::identify::record::{RecordError, RecordSource};
use crate::identify::residuals::Residuals;

/// Compares all laws on a record of one input and one output.
///
/// # Errors
/// A sentence that names the column or the part, and the remedy.
pub fn compare(
    source: &mut dyn RecordSource,
    part: FittedPart,
    progress: &mut Progress<'_>,
) -> Result<LawsReport, RecordError> {
    let record = ForecastRecord::read(source, part)?;
    let (output, fitted) = (record.output(), record.fitted);
    let mut laws = laws(&record, &output, progress)?;
    let (model, predicted) = model_line::forecast(&record, progress)?;
    let mut warnings: Vec<String> = laws.iter().flat_map(|(_, warnings)| warnings.clone()).collect();
    warnings.extend(model.warnings.iter().map(|warning| format!("{}: {warning}", model_line::NAME)));
    laws.push((
        LawForecast {
            numbers: model_line::numbers(&model),
            terms: model_line::terms(&model),
            ..scored(model_line::NAME, predicted, &output, fitted)
        },
        Vec::new(),
    ));
    let mut laws: Vec<LawForecast> = laws.into_iter().map(|(law, _)| law).collect();
    if let Some(law) = laws.last_mut() {
        law.rest = model.outputs[0].offset_c;
    }
    let best = (0..laws.len()).min_by(|&a, &b| laws[a].held_out.rmse.total_cmp(&laws[b].held_out.rmse)).unwrap_or(0);
    let errors: Vec<Vec<f64>> =
        laws.iter().map(|law| block_errors(&output[fitted..], &law.predicted[fitted..])).collect();
    for (law, own) in laws.iter_mut().zip(&errors) {
        law.within_noise = is_within_noise(own, &errors[best]);
    }
    Ok(LawsReport::new(record, output, laws, model, best, warnings))
}

/// Every law, with what must be known of its numbers.
fn laws(
    record: &ForecastRecord,
    output: &[f64],
    progress: &mut Progress<'_>,
) -> Result<Vec<(LawForecast, Vec<String>)>, RecordError> {
    let (period_s, fitted) = (record.survey.sample_period_s, record.fitted);
    let problem = FitProblem::new(&record.input()[..fitted], &output[..fitted], period_s);
    let whole = InputStream::new(record.input());
    let (mut found, mut shorter) = (Vec::new(), Vec::new());
    for (at, law) in ResponseLaw::ALL.into_iter().enumerate() {
        progress("fitting laws", at as u64, ResponseLaw::ALL.len() as u64);
        let fit = problem.fit(law, &shorter).ok_or_else(|| {
            record.survey.refuse(format!(
                "the law `{}` cannot be fitted: its numbers are too large or too small to compute with",
                law.name()
            ))
        })?;
        let predicted = fit.predicted(&whole, period_s);
        let forecast = LawForecast {
            numbers: law.numbers(),
            terms: terms(&fit),
            rest: fit.weights[fit.weights.len() - 1],
            ..scored(law.name(), predicted, output, fitted)
        };
        let warnings = fit.at_edge.contains(&true).then(|| {
            format!(
                "{}: a time constant or exponent stands at the edge of what the fitted part shows, so the record does not decide it",
                law.name()
            )
        });
        found.push((forecast, warnings.into_iter().collect()));
        shorter = if let ResponseLaw::Exponentials(_) = law { fit.shapes } else { Vec::new() };
    }
    Ok(found)
}

fn terms(fit: &LawFit) -> Vec<LawTerm> {
    let mut shapes = fit.shapes.iter().map(|shape| shape.exp());
    let mut weights = fit.weights.iter().copied();
    let term = |kernel: super::kernel::StepKernel| {
        let mut own = shapes.by_ref().take(kernel.shapes());
        let (time_constant_s, exponent) = (own.next(), own.next());
        let (gain, decay) = (weights.next().unwrap_or_default(), weights.next());
        LawTerm { gain, decay, time_constant_s, exponent }
    };
    fit.law.kernels().into_iter().map(term).collect()
}

/// A line without its numbers.
fn scored(law: &str, predicted: Vec<f64>, output: &[f64], fitted: usize) -> LawForecast {
    let figures = |measured: &[f64], predicted: &[f64]| {
        let mut residuals = Residuals::default();
        let rows = measured.iter().zip(predicted).filter(|(y, p)| !(*y - *p).is_nan());
        rows.for_each(|(y, p)| residuals.push(*y, *p, 0.0));
        PartFigures {
            fit_percent: residuals.constant().is_none().then(|| residuals.fit_percent()),
            rmse: residuals.rms(),
        }
    };
    LawForecast {
        law: law.to_owned(),
        numbers: 0,
        terms: Vec::new(),
        rest: 0.0,
        fitted: figures(&output[..fitted], &predicted[..fitted]),
        held_out: figures(&output[fitted..], &predicted[fitted..]),
        within_noise: false,
        predicted,
    }
}
