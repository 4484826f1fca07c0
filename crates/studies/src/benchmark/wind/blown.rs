//! A run with anemometers beside it: several modes on the same ticks, for an anemometer decides
//! nothing.

use anyhow::{Context as _, Result};
use wire::WindSample;

use super::sphere::WindMode;
use crate::thesis::record::rows;
use anemometry::head::calibration::checked::Calibration;
use anemometry::head::{Head, WindOutput};
use anemometry::wind::gas_uncertainty::{GasReadingErrors, GasUncertainty};
use anemometry::wind::moment::Moment;
use anemometry::wind::moment::Ticks;
use anemometry::wind::off_line::OffLineAnemometer;
use host_sim::experiment::Experiment;

/// Runs an experiment, whose head has the elements of the calibrated one, and hands out every
/// answer of every mode by its place.
///
/// # Errors
/// What could not be run, or which bandwidth cannot be had.
pub fn blow(
    experiment: &Experiment,
    head: &Head,
    modes: &[WindMode],
    each: &mut dyn FnMut(usize, &Moment, &WindSample),
) -> Result<()> {
    let anemometers = modes.iter().map(|mode| beside(experiment, head, *mode));
    let mut anemometers: Vec<OffLineAnemometer<'_>> = anemometers.collect::<Result<_, _>>()?;
    let mut live = Ticks::new(experiment.sample_period_s);
    rows(experiment, &mut |row| {
        let moment = live.moment(row);
        for (place, anemometer) in anemometers.iter_mut().enumerate() {
            if let Some(answer) = anemometer.step(&moment.tick) {
                each(place, &moment, &answer);
            }
        }
        Ok(())
    })
}

/// An anemometer of the calibrated head beside a run of an experiment, with its gas.
///
/// # Errors
/// If the head has no calibration, or the bandwidth cannot be had.
pub fn beside<'a>(experiment: &Experiment, head: &'a Head, mode: WindMode) -> Result<OffLineAnemometer<'a>> {
    let setup = SetUp::of(experiment, head, mode)?;
    let mut anemometer = OffLineAnemometer::new(head, setup.calibration, &setup.output, experiment.sample_period_s)?;
    anemometer.gas(setup.pressure_pa, setup.gas_c)?;
    Ok(anemometer)
}

/// Errors by such an uncertainty of the gas, beside the same run.
///
/// # Errors
/// As of [`beside`].
pub fn gas_errors_beside<'a>(
    experiment: &Experiment,
    head: &'a Head,
    mode: WindMode,
    gas: GasUncertainty,
) -> Result<GasReadingErrors<'a>> {
    let setup = SetUp::of(experiment, head, mode)?;
    let mut errors = GasReadingErrors::new(gas, head, setup.calibration, &setup.output, experiment.sample_period_s)?;
    errors.gas(setup.pressure_pa, setup.gas_c)?;
    Ok(errors)
}

/// Set-up of an anemometer beside a run.
struct SetUp<'a> {
    calibration: &'a Calibration,
    output: WindOutput,
    pressure_pa: f32,
    gas_c: Option<f32>,
}

impl<'a> SetUp<'a> {
    fn of(experiment: &Experiment, head: &'a Head, mode: WindMode) -> Result<Self> {
        let none = || format!("head `{}` has no calibration", head.name);
        let calibration = head.calibration.as_ref().with_context(none)?;
        Ok(Self {
            calibration,
            output: WindOutput::new(Some(mode.bandwidth_hz), None, mode.fixed, experiment.sample_period_s),
            pressure_pa: experiment.pressure_pa as f32,
            gas_c: calibration.reference.is_none().then_some(experiment.gas_temperature_c as f32),
        })
    }
}

/// Mean of the raw conductances of the parts that are measured, W/K.
pub fn raw_w_k(answer: &WindSample) -> f64 {
    let parts = answer.raw_w_k.iter().filter(|&&w_k| w_k != 0.0);
    let (sum, count) = parts.fold((0.0, 0), |(sum, count), &w_k| (sum + f64::from(w_k), count + 1));
    sum / f64::from(count.max(1))
}

/// Speeds by raw conductances: the power law U ∝ G^n through two winds in which they have long been
/// settled.
#[derive(Debug, Clone, Copy)]
pub struct RawLaw {
    /// Speed in m/s and mean raw conductance in W/K in the slower wind.
    pub slow: (f64, f64),
    /// The same in the faster wind.
    pub fast: (f64, f64),
}

impl RawLaw {
    /// Speed at a mean raw conductance, m/s.
    pub fn speed_m_s(&self, raw_w_k: f64) -> f64 {
        let power = libm::log(self.fast.0 / self.slow.0) / libm::log(self.fast.1 / self.slow.1);
        self.slow.0 * libm::pow(raw_w_k / self.slow.1, power)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_law_goes_through_both_of_its_winds() {
        // G = 3 √U.
        let law = RawLaw { slow: (4.0, 6.0), fast: (9.0, 9.0) };
        for (speed_m_s, raw) in [(4.0, 6.0), (9.0, 9.0), (1.0, 3.0)] {
            assert!((law.speed_m_s(raw) - speed_m_s).abs() < 1e-12);
        }
    }
}
