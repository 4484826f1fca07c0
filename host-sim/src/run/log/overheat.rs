//! Set-points above the gas, as its reference element measures it.

use dr_core::control::Drive;

use super::LogRefusal;
use crate::experiment::Experiment;
use crate::instrument::Observation;
use anemometry::head::HeadElement;

/// The gas is taken from the mean over so long, s: longer than a fluctuation, shorter than weather.
const MEAN_OVER_S: f64 = 10.0;
/// Smaller changes of the gas leave the set-points, K.
const DEAD_BAND_K: f64 = 0.05;

/// The element that measures the gas beside a head.
pub(super) fn reference(experiment: &Experiment) -> Option<usize> {
    experiment.head.names().iter().position(|name| *name == recording::REFERENCE)
}

/// Follows the gas.
pub(super) struct Overheat {
    overheat_k: f64,
    reference: usize,
    sum_c: f64,
    count: f64,
    rows: f64,
    gas_c: Option<f64>,
}

impl Overheat {
    pub fn new(overheat_k: f64, reference: usize) -> Self {
        Self { overheat_k, reference, sum_c: 0.0, count: 0.0, rows: 0.0, gas_c: None }
    }

    /// Adds a sample; the new set-point, °C, when the gas has another temperature.
    pub fn add(&mut self, observation: &Observation, experiment: &Experiment) -> Option<f64> {
        let sample = &observation.sample;
        if sample.valid >> self.reference & 1 == 1 {
            self.sum_c += f64::from(sample.temperature_c[self.reference]);
            self.count += 1.0;
        }
        self.rows += 1.0;
        if self.rows * experiment.sample_period_s < MEAN_OVER_S {
            return None;
        }
        let mean_c = (self.count > 0.0).then_some(self.sum_c / self.count);
        (self.sum_c, self.count, self.rows) = (0.0, 0.0, 0.0);
        let gas_c = mean_c.filter(|now_c| self.gas_c.is_none_or(|gas_c| (now_c - gas_c).abs() >= DEAD_BAND_K))?;
        self.gas_c = Some(gas_c);
        Some(gas_c + self.overheat_k)
    }
}

/// Gives every element that holds a temperature this one.
///
/// # Errors
/// If it is beyond an element's limit: all stay as they are.
pub fn set(experiment: &mut Experiment, target_c: f64) -> Result<(), LogRefusal> {
    let holds = |drive: &Drive| matches!(drive, Drive::Temperature { .. });
    let held = || experiment.drives.iter().zip(&experiment.head.elements).filter(|(drive, _)| holds(drive));
    let most_c = |of: &HeadElement| of.config.hottest_set_point().0;
    if let Some((_, element)) = held().find(|(_, of)| target_c > f64::from(most_c(of))) {
        let (element, most_c) = (element.name.clone(), most_c(element));
        return Err(LogRefusal::BeyondLimit { temperature_c: target_c, element, most_c });
    }
    let target_c = target_c as f32;
    experiment
        .drives
        .iter_mut()
        .filter(|drive| holds(drive))
        .for_each(|drive| *drive = Drive::Temperature { target_c });
    Ok(())
}
