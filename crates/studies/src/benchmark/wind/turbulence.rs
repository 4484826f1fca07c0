//! Answers beside a turbulent wind: coherence and gain by band, of the speed along the mean wind.

use super::blown::blow;
use super::coherence::{Band, bands};
use super::sphere::WindMode;
use crate::thesis::{StudyError, StudyLab};
use anemometry::head::Head;

/// Of the estimate, s.
const SEGMENT_S: f64 = 20.48;
/// Edges of the bands, Hz.
const EDGES_HZ: [f64; 5] = [0.05, 0.5, 1.0, 1.5, 2.0];

/// One mode.
#[derive(Debug, Clone)]
pub struct TurbulenceResponse {
    /// The bandwidth.
    pub mode: WindMode,
    /// By band of frequency.
    pub bands: Vec<Band>,
}

/// Measures coherence and gain in turbulence, by bandwidth.
///
/// # Errors
/// What could not be run.
pub fn measure(lab: &StudyLab, head: &Head, modes: &[WindMode]) -> Result<Vec<TurbulenceResponse>, StudyError> {
    let experiment = lab.experiment("turbulence")?;
    lab.announce(&experiment);
    let from_s = experiment.wind.last().map_or(0.0, |wind| wind.start_s);
    let mut truth = Vec::new();
    let mut answers: Vec<Vec<f64>> = vec![Vec::new(); modes.len()];
    let mut times_s = Vec::new();
    blow(&experiment, head, modes, &mut |place, moment, answer| {
        let Some(wind_m_s) = moment.wind_m_s.filter(|_| moment.time_s >= from_s) else { return };
        if place == 0 {
            times_s.push(moment.time_s);
            truth.push(anemometry::vector::length(wind_m_s));
        }
        answers[place].push(f64::from(answer.speed_m_s));
    })?;
    let every_s = times_s.get(1).zip(times_s.first()).map_or(f64::NAN, |(next, first)| next - first);
    let of = |(answer, &mode): (&Vec<f64>, &WindMode)| TurbulenceResponse {
        mode,
        bands: bands(&truth, answer, every_s, SEGMENT_S, &EDGES_HZ),
    };
    Ok(answers.iter().zip(modes).map(of).collect())
}
