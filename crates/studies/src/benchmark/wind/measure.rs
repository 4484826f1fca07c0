//! All measurements of one sphere, and of both at once.

use anyhow::{Result, anyhow};
use std::path::Path;

use super::chain;
use super::directions::{self, Directions};
use super::sphere::{BenchmarkSphere, SPHERE_A, SPHERE_B, modes};
use super::steps::{self, Drift, StepResponses};
use super::swing::{self, TemperatureSwingErrors};
use super::turbulence::{self, TurbulenceResponse};
use crate::thesis::StudyLab;
use anemometry::calibrate::report::{ConductanceNoise, conductance_noise};
use anemometry::network::identify::PolesPerPair;

/// All that was measured of a sphere.
pub struct MeasuredSphere {
    /// Sphere.
    pub sphere: BenchmarkSphere,
    /// The calibrated head's file.
    pub text: String,
    /// Records of its calibration, and its cross-validated errors.
    pub made_from: String,
    /// Noise of a part's conductance at 30 K and 1 kHz by bandwidth.
    pub noise_w_k: Vec<ConductanceNoise>,
    /// Errors in unseen winds, by bandwidth.
    pub directions: Vec<Directions>,
    /// Responses to steps, by bandwidth.
    pub steps: Vec<StepResponses>,
    /// Drift after a step.
    pub drift: Drift,
    /// Coherence and gain, by bandwidth.
    pub turbulence: Vec<TurbulenceResponse>,
    /// Errors in an oscillating gas temperature.
    pub swing: TemperatureSwingErrors,
}

/// Measures one sphere. `folder` is the one that holds the folders of the spheres.
///
/// # Errors
/// What could not be read, run, identified or calibrated.
pub fn measure(folder: &Path, sphere: BenchmarkSphere, progress: &dyn Fn(&str)) -> Result<MeasuredSphere> {
    let lab = StudyLab::new(folder.join(sphere.folder), progress);
    let model = chain::network(&lab, sphere.elements, PolesPerPair::default(), None)?;
    let tunnel = lab.experiment("tunnel")?;
    lab.announce(&tunnel);
    let (head, text) = chain::calibrated(&tunnel, &model, chain::SETTLE_S)?;
    let mut drift = steps::drift(&lab, &head)?;
    Ok(MeasuredSphere {
        sphere,
        made_from: head.calibration.as_ref().map(|of| of.table.made_from.clone()).unwrap_or_default(),
        noise_w_k: conductance_noise(&head),
        directions: directions::measure(&lab, &head, &modes(sphere.winds_hz))?,
        steps: steps::measure(&lab, &head, &modes(sphere.step_hz), &mut drift)?,
        drift,
        turbulence: turbulence::measure(&lab, &head, &modes(sphere.turbulence_hz))?,
        swing: swing::measure(&lab, &head)?,
        text,
    })
}

/// Measures both, each in a thread of its own.
///
/// # Errors
/// The first that came to no end.
pub fn both(folder: &Path, progress: &(dyn Fn(&str) + Sync)) -> Result<[MeasuredSphere; 2]> {
    std::thread::scope(|scope| {
        let other = scope.spawn(|| measure(folder, SPHERE_A, &|what: &str| progress(what)));
        let b = measure(folder, SPHERE_B, &|what: &str| progress(what));
        let a = other.join().map_err(|_| anyhow!("a thread of the benchmark ended before its time"))?;
        Ok([b?, a?])
    })
}
