//! Errors of speed and direction in winds that no calibration has seen.

use super::Mode;
use super::blown::blow;
use crate::answer::errors::Errors;
use crate::answer::off_line::axes;
use crate::head::Head;
use crate::thesis::{Lab, StudyError};

/// Of every wind so much is left out, s: the answers that count are those of a wind, not of the change to it.
pub const SETTLE_S: f64 = 3.0;

/// One mode.
#[derive(Debug, Clone)]
pub struct Directions {
    pub mode: Mode,
    pub winds: usize,
    pub errors: Errors,
}

/// # Errors
/// What could not be run.
pub fn measure(lab: &Lab, head: &Head, modes: &[Mode]) -> Result<Vec<Directions>, StudyError> {
    let experiment = lab.experiment("winds")?;
    lab.tell(&experiment);
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
pub fn of(experiment: &crate::experiment::Experiment, head: &Head, modes: &[Mode]) -> Result<Vec<Errors>, StudyError> {
    let mut errors = vec![Errors::default(); modes.len()];
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
