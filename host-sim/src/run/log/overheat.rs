//! Set-points above the gas, as its reference element measures it.

use anyhow::{anyhow, bail};
use dr_core::control::Drive;

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

/// Tells whether a drive holds one temperature, or two in turn.
pub(super) const fn holds(drive: &Drive) -> bool {
    matches!(drive, Drive::Temperature { .. } | Drive::Alternation { .. })
}

/// Lets every element that holds a temperature alternate between it, at an overheat of `high_k`,
/// and that of `low_k`, each for `half_s`.
///
/// # Errors
/// If these are no two overheats, or no whole number of ticks.
pub fn alternate(experiment: &mut Experiment, [high_k, low_k]: [f64; 2], half_s: f64) -> anyhow::Result<()> {
    let ticks = half_s / experiment.sample_period_s;
    let is_whole = (1.0..=f64::from(u32::MAX)).contains(&ticks) && (ticks - ticks.round()).abs() < 1e-6 * ticks;
    if !(is_whole && low_k > 0.0 && high_k > low_k) {
        bail!(
            "overheats of {high_k} and {low_k} K, each for {half_s} s, cannot alternate: they must descend to one above 0, and last whole sample periods"
        );
    }
    for drive in &mut experiment.drives {
        if let Drive::Temperature { target_c } = *drive {
            let low_c = target_c - (high_k - low_k) as f32;
            *drive = Drive::Alternation { low_c, high_c: target_c, half_ticks: ticks.round() as u32 };
        }
    }
    Ok(())
}

/// Refusal of a set-point that the head does not allow.
pub(super) fn beyond_limit(temperature_c: f64, element: &str, most_c: f32) -> anyhow::Error {
    anyhow!("a set-point of {temperature_c:.2} °C is beyond the limit of {element}, {most_c} °C: it stays")
}

/// Gives every element that holds a temperature this one. One that alternates has it as its higher
/// one, and the lower one as far below as before.
///
/// # Errors
/// If it is beyond an element's limit: all stay as they are.
pub fn set(experiment: &mut Experiment, target_c: f64) -> anyhow::Result<()> {
    let held = || experiment.drives.iter().zip(&experiment.head.elements).filter(|(drive, _)| holds(drive));
    let most_c = |of: &HeadElement| of.config.hottest_set_point().0;
    if let Some((_, element)) = held().find(|(_, of)| target_c > f64::from(most_c(of))) {
        return Err(beyond_limit(target_c, &element.name, most_c(element)));
    }
    let target_c = target_c as f32;
    for drive in &mut experiment.drives {
        *drive = match *drive {
            Drive::Temperature { .. } => Drive::Temperature { target_c },
            Drive::Alternation { low_c, high_c, half_ticks } => {
                Drive::Alternation { low_c: target_c - (high_c - low_c), high_c: target_c, half_ticks }
            }
            other => other,
        };
    }
    Ok(())
}
