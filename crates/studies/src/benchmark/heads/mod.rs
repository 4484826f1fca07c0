//! From nothing to wind on heads of every form: `studies benchmark heads`.
//!
//! Each head comes as a folder that `anemo head new` writes: records in quiescent gas, a tunnel,
//! and winds that the calibration has not seen. A head of one element is also operated at constant
//! current and at constant power, calibrated and estimated in the same way: the convective loss is
//! what the network leaves of a power whose temperature moves.
//!
//! | file | what |
//! |---|---|
//! | [`operation`] | the experiments of a folder in another operating mode |
//! | [`report`] | the figures as text, as JSON and as a page |

pub mod operation;
pub mod report;

use std::path::Path;

use anemometry::head::Head;
use anemometry::network::identify::PolesPerPair;
use dr_core::wind::HeadForm;
use serde::Serialize;

use super::modes::OperatingMode;
use super::wind::sphere::WindMode;
use super::wind::{chain, directions};
use crate::thesis::{StudyError, StudyLab};

pub use report::HeadsReport;

/// Left out of every wind of the tunnel, s.
const SETTLE_S: f64 = 5.0;
/// Bandwidth of the estimates.
const BANDWIDTH: WindMode = WindMode { bandwidth_hz: 1.0, fixed: true };

/// What one head reaches in one operating mode.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HeadFigures {
    /// Its name.
    pub head: String,
    /// What its surfaces belong to.
    pub form: HeadForm,
    /// How many there are.
    pub surfaces: usize,
    /// How its elements are operated.
    pub mode: OperatingMode,
    /// Its calibration, with errors in winds that were left out.
    pub made_from: String,
    /// Winds that were estimated.
    pub winds: usize,
    /// Error of direction, rms, °; none where the head tells none.
    pub direction_rms_deg: Option<f64>,
    /// Relative error of speed, rms.
    pub speed_rms: f64,
    /// The same, its mean.
    pub speed_mean: f64,
}

/// One head in the modes that are compared.
#[derive(Debug, Default)]
pub struct MeasuredHead {
    /// Mode by mode.
    pub figures: Vec<HeadFigures>,
    /// What could not be calibrated in a mode, and why.
    pub refused: Vec<String>,
}

/// The figures of the head in a folder: at constant temperature, and where it has one surface, or
/// `all_modes`, in the two other modes; what cannot be calibrated in a mode goes into `refused`.
///
/// # Errors
/// What could not be read, run or identified.
pub fn measure(folder: &Path, all_modes: bool, progress: &dyn Fn(&str)) -> Result<MeasuredHead, StudyError> {
    let lab = StudyLab::new(folder, progress);
    let head = lab.experiment("tunnel")?.head;
    let names = head.names();
    let identified = names.iter().filter(|name| folder.join(format!("identify-{name}.toml")).is_file());
    let identified: Vec<&str> = identified.copied().collect();
    let model = chain::network(&lab, &identified, PolesPerPair::default(), None)?;
    let modes: &[OperatingMode] = match head.elements.iter().filter(|element| element.is_surface()).count() {
        surfaces if surfaces == 1 || all_modes => &OperatingMode::ALL,
        _ => &[OperatingMode::Cta],
    };
    let mut head_measured = MeasuredHead::default();
    for &mode in modes {
        let measured = || {
            let tunnel = operation::experiment(&lab, "tunnel", &identified, mode)?;
            lab.announce(&tunnel);
            let (head, _) = chain::calibrated(&tunnel, &model, SETTLE_S)?;
            let winds = operation::experiment(&lab, "winds", &identified, mode)?;
            lab.announce(&winds);
            figures(&head, &winds, mode)
        };
        match measured() {
            Ok(figures) => head_measured.figures.push(figures),
            Err(error) => head_measured.refused.push(format!("{}, {}: {error}", head.name, mode.name())),
        }
    }
    Ok(head_measured)
}

fn figures(
    head: &Head,
    experiment: &host_sim::experiment::Experiment,
    mode: OperatingMode,
) -> Result<HeadFigures, StudyError> {
    let calibration = head.calibration.as_ref().ok_or_else(|| StudyError::Other("no calibration".to_owned()))?;
    let errors = directions::of(experiment, head, &[BANDWIDTH])?;
    let errors = errors.first().ok_or_else(|| StudyError::Other("no estimates".to_owned()))?;
    let none = || StudyError::Other(format!("{}: no estimate of a speed", head.name));
    Ok(HeadFigures {
        head: head.name.clone(),
        form: calibration.table.form,
        surfaces: calibration.surfaces.len(),
        mode,
        made_from: calibration.table.made_from.clone(),
        winds: experiment.wind.iter().filter(|wind| wind.speed_m_s > 0.0).count(),
        direction_rms_deg: errors.direction_deg.rms(),
        speed_rms: errors.speed.rms().ok_or_else(none)?,
        speed_mean: errors.speed.mean().ok_or_else(none)?,
    })
}
