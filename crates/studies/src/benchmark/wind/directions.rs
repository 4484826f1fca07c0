//! Errors of speed and direction in winds that no calibration has seen.

use super::blown::blow;
use super::sphere::WindMode;
use crate::thesis::StudyLab;
use anemometry::head::Head;
use anemometry::head::calibration::checked::Calibration;
use anemometry::wind::comparison::WindComparison;
use anemometry::wind::off_line::axes;
use anyhow::Result;

/// Time left out at the beginning of every wind, left out, s: the answers that count are those of a
/// wind, not of the change to it.
pub const SETTLE_S: f64 = 3.0;

/// One mode.
#[derive(Debug, Clone)]
pub struct Directions {
    /// The bandwidth.
    pub mode: WindMode,
    /// Number of winds.
    pub winds: usize,
    /// Errors over all of them.
    pub errors: WindComparison,
}

/// Measures the errors in 500 unseen winds, by bandwidth.
///
/// # Errors
/// What could not be run.
pub fn measure(lab: &StudyLab, head: &Head, modes: &[WindMode]) -> Result<Vec<Directions>> {
    let experiment = lab.experiment("winds")?;
    lab.announce(&experiment);
    let winds = experiment.wind.iter().filter(|wind| wind.speed_m_s > 0.0).count();
    of(&experiment, head, modes).map(|all| {
        let all = modes.iter().zip(all);
        all.map(|(&mode, errors)| Directions { mode, winds, errors }).collect()
    })
}

/// Errors by mode in the winds of any experiment.
///
/// # Errors
/// What could not be run.
pub fn of(
    experiment: &host_sim::experiment::Experiment,
    head: &Head,
    modes: &[WindMode],
) -> Result<Vec<WindComparison>> {
    let plane = head.calibration.as_ref().and_then(Calibration::plane_normal);
    let mut errors = vec![WindComparison::in_plane(plane); modes.len()];
    let axes = head.calibration.as_ref().map(|calibration| axes(head, calibration)).unwrap_or_default();
    let mut begun = vec![(String::new(), 0.0); modes.len()];
    blow(experiment, head, modes, &mut |place, moment, answer| {
        let (label, from_s) = &mut begun[place];
        if *label != moment.event {
            (*label, *from_s) = (moment.event.clone(), moment.time_s);
        }
        if let Some(truth_m_s) = moment.wind_m_s
            && moment.time_s - *from_s >= SETTLE_S
        {
            errors[place].add(answer, &axes, truth_m_s);
        }
    })?;
    Ok(errors)
}
