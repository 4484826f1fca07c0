//! From nothing to wind on heads of every form: `studies benchmark heads`.
//!
//! Each head comes as a folder that `anemo head new` writes: records in quiescent gas, a tunnel,
//! and winds that the calibration has not seen. A head of one element is also operated at constant
//! current and at constant power, calibrated and estimated in the same way: the convective loss is
//! what the network leaves of a power whose temperature moves.

pub mod report;
use super::modes::OperatingMode;
use super::wind::sphere::WindMode;
use super::wind::{chain, directions};
use crate::thesis::StudyLab;
use anemometry::head::Head;
use anemometry::network::identify::PolesPerPair;
use anyhow::{Context as _, Result};
use dr_core::sensor::Level;
use dr_core::wind::HeadForm;
use host_sim::experiment::Experiment;
use recording::text::short;
pub use report::HeadsReport;
use std::path::Path;

/// Left out of every wind of the tunnel, s.
const SETTLE_S: f64 = 5.0;
/// Bandwidth of the estimates.
const BANDWIDTH: WindMode = WindMode { bandwidth_hz: 1.0, fixed: true };

/// Figures of one head in one operating mode.
#[derive(Debug, Clone, PartialEq)]
pub struct HeadFigures {
    /// Its name.
    pub head: String,
    /// Form that its surfaces belong to.
    pub form: HeadForm,
    /// Number of surfaces.
    pub surfaces: usize,
    /// Mode in which its elements are operated.
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
    /// Heads that could not be calibrated in a mode, and why.
    pub refused: Vec<String>,
}

/// The figures of the head in a folder: at constant temperature, and where it has one surface, or
/// `all_modes`, in the two other modes; what cannot be calibrated in a mode goes into `refused`.
///
/// # Errors
/// What could not be read, run or identified.
pub fn measure(folder: &Path, all_modes: bool, progress: &dyn Fn(&str)) -> Result<MeasuredHead> {
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
            let tunnel = operated(&lab, "tunnel", &identified, mode)?;
            lab.announce(&tunnel);
            let (head, _) = chain::calibrated(&tunnel, &model, SETTLE_S)?;
            let winds = operated(&lab, "winds", &identified, mode)?;
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

fn figures(head: &Head, experiment: &host_sim::experiment::Experiment, mode: OperatingMode) -> Result<HeadFigures> {
    let calibration = head.calibration.as_ref().context("no calibration")?;
    let errors = directions::of(experiment, head, &[BANDWIDTH])?;
    let errors = errors.first().context("no estimates")?;
    let none = || format!("{}: no estimate of a speed", head.name);
    Ok(HeadFigures {
        head: head.name.clone(),
        form: calibration.table.form,
        surfaces: calibration.surfaces.len(),
        mode,
        made_from: calibration.table.made_from.clone(),
        winds: experiment.wind.iter().filter(|wind| wind.speed_m_s > 0.0).count(),
        direction_rms_deg: errors.direction_deg.rms(),
        speed_rms: errors.speed.rms().with_context(none)?,
        speed_mean: errors.speed.mean().with_context(none)?,
    })
}

/// Share of the power that holds the overheat in quiescent gas: no element becomes as warm as
/// there.
const SHARE: f64 = 0.9;

/// An experiment of a lab with its elements in a mode; for other modes than constant temperature
/// with the power that its identification had on average, which quiescent gas bears.
///
/// # Errors
/// If an experiment cannot be read.
fn operated(lab: &StudyLab, name: &str, elements: &[&str], mode: OperatingMode) -> Result<Experiment> {
    let known = lab.experiment(name)?;
    if mode == OperatingMode::Cta {
        return Ok(known);
    }
    let (mut currents, mut drives) = ("[currents]\n".to_owned(), "[drives]\n".to_owned());
    for element in elements {
        let identification = lab.experiment(&format!("identify-{element}"))?;
        let of = identification.head.elements.iter().find(|of| of.name == *element);
        let of = of.with_context(|| format!("{element}: is no element of the head"))?;
        let mean_w = 0.5 * SHARE * of.power_w(known.gas_temperature_c, Level::High);
        let high_a = of.nominal.current_high_a * (0.5 * SHARE).sqrt();
        if mode == OperatingMode::Cca {
            // Constant current has no use for its low level, but the two must differ.
            let low_a = of.nominal.current_low_a.min(0.5 * high_a);
            currents += &format!("{element} = {{ low_a = {}, high_a = {} }}\n", short(low_a, 4), short(high_a, 4));
            drives += &format!("{element} = {{ level = \"high\" }}\n");
        } else {
            drives += &format!("{element} = {{ power_w = {} }}\n", short(mean_w, 4));
        }
    }
    let mut source = known.source.clone();
    let table = |text: &str, heading: &str| text.find(heading).unwrap_or(text.len());
    let from = table(&source.text, "[drives]");
    let to = from + table(source.text.get(from..).unwrap_or_default(), "\n[sweep]");
    let own = if mode == OperatingMode::Cca { format!("{currents}\n{drives}") } else { drives };
    source.text.replace_range(from..to, &own);
    Ok(Experiment::from_source(source)?)
}
