//! A gas whose temperature swings in a steady wind: what its reference leaves of the swing in the
//! speed.

use super::blown::{blow, raw_w_k};
use super::sphere::WindMode;
use crate::thesis::{StudyError, StudyLab};
use anemometry::head::Head;

/// Means that are looked at, s.
const MEAN_S: f64 = 10.0;
const MODE: WindMode = WindMode { bandwidth_hz: 0.5, fixed: false };

/// Relative, of means over ten seconds.
#[derive(Debug, Clone, Copy)]
pub struct TemperatureSwingErrors {
    /// Peak to peak of the gas temperature, K.
    pub kelvin: f64,
    /// Root mean square error of the speed.
    pub speed_rms: f64,
    /// Largest error of the speed.
    pub speed_worst: f64,
    /// Peak to peak of the mean raw conductance, in percent of its mean, which says what a speed of
    /// it would do.
    pub raw_span: f64,
}

/// Measures the errors of the speed in an oscillating gas temperature.
///
/// # Errors
/// What could not be run.
pub fn measure(lab: &StudyLab, head: &Head) -> Result<TemperatureSwingErrors, StudyError> {
    let experiment = lab.experiment("gas-swing")?;
    lab.announce(&experiment);
    let swing = experiment.gas_swing;
    let swing = swing.ok_or_else(|| StudyError::Other(format!("{}: its gas does not swing", experiment.title)))?;
    let truth_m_s = experiment.wind[0].speed_m_s;
    let mut means: Vec<(f64, f64, f64)> = Vec::new();
    blow(&experiment, head, &[MODE], &mut |_, moment, answer| {
        let Some(since_s) = Some(moment.time_s - swing.start_s).filter(|since_s| *since_s >= 0.0) else { return };
        let place = (since_s / MEAN_S) as usize;
        means.resize(means.len().max(place + 1), (0.0, 0.0, 0.0));
        let (count, speed, raw) = &mut means[place];
        *count += 1.0;
        *speed += f64::from(answer.speed_m_s) / truth_m_s - 1.0;
        *raw += raw_w_k(answer);
    })?;
    let errors = || means.iter().map(|(count, speed, _)| speed / count);
    let raws = || means.iter().map(|(count, _, raw)| raw / count);
    let count = means.len().max(1) as f64;
    let (least, most) = raws().fold((f64::INFINITY, 0.0_f64), |(a, b), raw| (a.min(raw), b.max(raw)));
    Ok(TemperatureSwingErrors {
        kelvin: 2.0 * swing.amplitude_k,
        speed_rms: (errors().map(|e| e * e).sum::<f64>() / count).sqrt(),
        speed_worst: errors().fold(0.0, |worst, e| worst.max(e.abs())),
        raw_span: (most - least) / (raws().sum::<f64>() / count),
    })
}
