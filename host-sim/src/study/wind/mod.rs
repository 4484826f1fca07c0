//! The wind's numbers: every one measured on heads that were identified and calibrated by their own records, never from the truth.
//!
//! | module | measures |
//! |---|---|
//! | [`chain`] | runs the records, identifies the windless network, calibrates the head |
//! | [`blown`] | a run, with anemometers of several bandwidths beside the same ticks |
//! | [`directions`] | errors of speed and direction in 500 winds that no calibration has seen |
//! | [`steps`] | the answer to sudden steps, and what drifts after one |
//! | [`turbulence`], [`coherence`] | how far up in frequency the answers follow |
//! | [`swing`] | the gas's temperature swinging |
//! | [`page`] | what is written |
//!
//! Experiments are those of `experiments/wind/sphere-a` and `sphere-b`.

pub mod blown;
pub mod chain;
pub mod coherence;
pub mod directions;
pub mod page;
pub mod steps;
pub mod swing;
pub mod turbulence;

use std::fmt;
use std::path::Path;

use crate::head::Head;
use crate::network::identified::Poles;
use crate::thesis::{Lab, StudyError};
use directions::Directions;
use steps::{Drift, Steps};
use swing::Swing;
use turbulence::Turbulence;

/// How an anemometer answers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mode {
    /// Steady bandwidth of the convective powers, Hz.
    pub bandwidth_hz: f64,
    /// Whether it stays when the wind jumps.
    pub fixed: bool,
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} Hz{}", self.bandwidth_hz, if self.fixed { ", fixed" } else { "" })
    }
}

/// Bandwidths that rise after a jump of the wind, and the same ones fixed.
fn modes(bandwidths_hz: &[f64]) -> Vec<Mode> {
    let of = |fixed| bandwidths_hz.iter().map(move |&bandwidth_hz| Mode { bandwidth_hz, fixed });
    of(false).chain(of(true)).collect()
}

/// A sphere, and what is asked of it.
#[derive(Debug, Clone, Copy)]
pub struct Sphere {
    /// Its folder of experiments.
    pub folder: &'static str,
    pub title: &'static str,
    pub elements: &'static [&'static str],
    /// Bandwidths at which it is stepped, Hz.
    pub step_hz: &'static [f64],
    /// What is judged by its steps.
    pub judged: Mode,
    /// Within 5 % for good after a step, s.
    pub response_s: f64,
    /// Of its answers in unseen winds.
    pub winds_hz: &'static [f64],
    /// In turbulence.
    pub turbulence_hz: &'static [f64],
    /// Whether it tells all of the direction.
    pub whole: bool,
}

pub const SPHERE_B: Sphere = Sphere {
    folder: "sphere-b",
    title: "Sphere B",
    elements: &["sector1", "sector2", "sector3", "sector4", "core1", "core2"],
    step_hz: &[0.5, 1.0, 2.0, 3.0, 5.0],
    judged: Mode { bandwidth_hz: 1.0, fixed: false },
    response_s: 0.2,
    winds_hz: &[0.5, 1.0, 2.0],
    turbulence_hz: &[2.0, 5.0, 10.0],
    whole: true,
};

pub const SPHERE_A: Sphere = Sphere {
    folder: "sphere-a",
    title: "Sphere A",
    elements: &["hemisphere1", "hemisphere2", "core1", "core2"],
    step_hz: &[0.5, 0.7, 1.0, 1.4],
    judged: Mode { bandwidth_hz: 0.5, fixed: false },
    response_s: 0.5,
    winds_hz: &[0.5, 1.0],
    turbulence_hz: &[0.5, 1.0, 1.4],
    whole: false,
};

/// All that was measured of a sphere.
pub struct Measured {
    pub sphere: Sphere,
    pub head: Head,
    /// The calibrated head's file.
    pub text: String,
    pub made_from: String,
    /// Noise of a part's conductance at 30 K and 1 kHz by bandwidth, W/K.
    pub noise_w_k: Vec<(f64, f64)>,
    pub directions: Vec<Directions>,
    pub steps: Vec<Steps>,
    pub drift: Drift,
    pub turbulence: Vec<Turbulence>,
    pub swing: Swing,
}

/// Measures one sphere. `folder` is the one that holds the folders of the spheres.
///
/// # Errors
/// What could not be read, run, identified or calibrated.
pub fn measure(folder: &Path, sphere: Sphere, told: &dyn Fn(&str)) -> Result<Measured, StudyError> {
    let lab = Lab::new(folder.join(sphere.folder), told);
    let model = chain::network(&lab, sphere.elements, Poles::default(), None)?;
    let (head, text) = chain::calibrated(&lab, &model)?;
    Ok(Measured {
        sphere,
        made_from: head.calibration.as_ref().map(|of| of.made_from().to_owned()).unwrap_or_default(),
        noise_w_k: chain::noise_w_k(&head),
        directions: directions::measure(&lab, &head, &modes(sphere.winds_hz))?,
        steps: steps::measure(&lab, &head, &modes(sphere.step_hz))?,
        drift: steps::drift(&lab, &head)?,
        turbulence: turbulence::measure(&lab, &head, &modes(sphere.turbulence_hz))?,
        swing: swing::measure(&lab, &head)?,
        head,
        text,
    })
}

/// Measures both, each in a thread of its own.
///
/// # Errors
/// The first that came to no end.
pub fn both(folder: &Path, told: &(dyn Fn(&str) + Sync)) -> Result<[Measured; 2], StudyError> {
    let ended = || StudyError::Other("a thread of the study ended before its time".to_owned());
    std::thread::scope(|scope| {
        let other = scope.spawn(|| measure(folder, SPHERE_A, &|what: &str| told(what)));
        let b = measure(folder, SPHERE_B, &|what: &str| told(what));
        let a = other.join().map_err(|_| ended())?;
        Ok([b?, a?])
    })
}
