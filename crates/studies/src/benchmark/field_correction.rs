//! An experiment judged as it is, and again with its slow errors corrected.

use anemometry::head::Head;
use anemometry::wind::field_correction::{FieldCorrection, SlowErrorKind, SlowEvidence};
use anemometry::wind::gas_uncertainty::GasUncertainty;
use anemometry::wind::moment::Moment;
use anemometry::wind::moment::Ticks;
use anyhow::Result;
use host_sim::experiment::Experiment;
use wire::WindSample;

use super::wind::WindMode;
use super::wind::blown::{beside, gas_errors_beside};
use crate::thesis::record::rows;

/// Runs an experiment and hands out every estimate: of the whole run without a correction, then of
/// the whole run with it, and with what such an uncertainty of its gas does.
///
/// # Errors
/// What could not be run, or that nothing can be corrected.
pub fn blow_corrected(
    experiment: &Experiment,
    head: &Head,
    mode: WindMode,
    kind: SlowErrorKind,
    gas: GasUncertainty,
    each: &mut dyn FnMut(bool, &Moment, &WindSample),
) -> Result<()> {
    let mut moments = Vec::new();
    let mut live = Ticks::new(experiment.sample_period_s);
    rows(experiment, &mut |row| {
        moments.push(live.moment(row));
        Ok(())
    })?;
    let mut evidence = SlowEvidence::default();
    let mut first = beside(experiment, head, mode)?;
    for moment in &moments {
        if let Some(estimate) = first.step_whole(&moment.tick) {
            evidence.add(moment.time_s, &estimate);
            each(false, moment, &WindSample::from(&estimate));
        }
    }
    let correction = FieldCorrection::find(&evidence, first.anemometer(), kind, mode.bandwidth_hz)?;
    let mut second = beside(experiment, head, mode)?;
    let mut gas_errors = gas_errors_beside(experiment, head, mode, gas)?;
    for moment in &moments {
        let corrections = correction.corrections(moment.time_s, first.anemometer().corrections());
        second.correct(corrections);
        gas_errors.correct(corrections);
        let estimate = second.step_whole(&moment.tick);
        let mut sample = estimate.as_ref().map(WindSample::from);
        gas_errors.step(&moment.tick, sample.as_mut());
        if let (Some(estimate), Some(mut sample)) = (estimate, sample) {
            correction.widen(moment.time_s, second.anemometer(), &estimate, &mut sample);
            each(true, moment, &sample);
        }
    }
    Ok(())
}
