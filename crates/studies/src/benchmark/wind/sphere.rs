//! The spheres of the benchmark, and the bandwidths at which they are measured.

use std::fmt;

/// The bandwidth of an anemometer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindMode {
    /// Steady bandwidth of the convective powers, Hz.
    pub bandwidth_hz: f64,
    /// It stays when the wind jumps.
    pub fixed: bool,
}

impl fmt::Display for WindMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} Hz{}", self.bandwidth_hz, if self.fixed { ", fixed" } else { "" })
    }
}

/// Bandwidths that rise after a jump of the wind, and the same ones fixed.
pub(super) fn modes(bandwidths_hz: &[f64]) -> Vec<WindMode> {
    let of = |fixed| bandwidths_hz.iter().map(move |&bandwidth_hz| WindMode { bandwidth_hz, fixed });
    of(false).chain(of(true)).collect()
}

/// A sphere, and what it has to reach.
#[derive(Debug, Clone, Copy)]
pub struct BenchmarkSphere {
    /// Its folder of experiments.
    pub folder: &'static str,
    /// Heading of its section.
    pub title: &'static str,
    /// One identification record each.
    pub elements: &'static [&'static str],
    /// Bandwidths at which it is stepped, Hz.
    pub step_hz: &'static [f64],
    /// Mode that is judged by its steps.
    pub judged: WindMode,
    /// Within 5 % for good after a step, s.
    pub response_s: f64,
    /// Bandwidths of its estimates in unseen winds, Hz.
    pub winds_hz: &'static [f64],
    /// Bandwidths in turbulence, Hz.
    pub turbulence_hz: &'static [f64],
    /// Its estimate has all of the direction.
    pub whole: bool,
}

/// Four sectors and two cores.
pub const SPHERE_B: BenchmarkSphere = BenchmarkSphere {
    folder: "sphere-b",
    title: "Sphere B",
    elements: &["sector1", "sector2", "sector3", "sector4", "core1", "core2"],
    step_hz: &[0.5, 1.0, 2.0, 3.0, 5.0],
    judged: WindMode { bandwidth_hz: 1.0, fixed: false },
    response_s: 0.2,
    winds_hz: &[0.5, 1.0, 2.0],
    turbulence_hz: &[2.0, 5.0, 10.0],
    whole: true,
};

/// Two hemispheres and two cores.
pub const SPHERE_A: BenchmarkSphere = BenchmarkSphere {
    folder: "sphere-a",
    title: "Sphere A",
    elements: &["hemisphere1", "hemisphere2", "core1", "core2"],
    step_hz: &[0.5, 0.7, 1.0, 1.4],
    judged: WindMode { bandwidth_hz: 0.5, fixed: false },
    response_s: 0.5,
    winds_hz: &[0.5, 1.0],
    turbulence_hz: &[0.5, 1.0, 1.4],
    whole: false,
};
