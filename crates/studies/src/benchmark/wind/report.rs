//! What `studies benchmark wind` prints: its page as text, and its numbers as JSON.

use std::fmt;

use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

use super::coherence::Band;
use super::directions::Directions;
use super::findings::findings;
use super::measure::MeasuredSphere;
use super::page::page;
use super::sphere::WindMode;
use super::steps::{Drift, Way};
use anemometry::calibrate::report::ConductanceNoise;

/// The spheres that were measured.
pub struct BenchmarkReport<'a>(pub &'a [MeasuredSphere]);

impl fmt::Display for BenchmarkReport<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&page(self.0).map_err(|_| fmt::Error)?)
    }
}

impl Serialize for BenchmarkReport<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for of in self.0 {
            map.serialize_entry(of.sphere.folder, &SphereJson::of(of))?;
        }
        map.end()
    }
}

#[derive(Serialize)]
struct SphereJson<'a> {
    bars: usize,
    met: usize,
    findings: Vec<BarJson>,
    winds: Vec<InMode<UnseenWindsJson>>,
    steps: Vec<InMode<&'a Way>>,
    #[serde(flatten)]
    drift: &'a Drift,
    turbulence: Vec<InMode<&'a Band>>,
    gas_swing_worst_error: f64,
    conductance_noise_w_k: &'a [ConductanceNoise],
}

#[derive(Serialize)]
struct BarJson {
    what: String,
    bar: String,
    measured: String,
    beside: String,
    met: Option<bool>,
}

/// What was measured in one mode.
#[derive(Serialize)]
struct InMode<T> {
    #[serde(flatten)]
    mode: WindMode,
    #[serde(flatten)]
    measured: T,
}

#[derive(Serialize)]
struct UnseenWindsJson {
    winds: usize,
    speed_rms_error: Option<f64>,
    direction_rms_error_deg: Option<f64>,
    linear_direction_rms_error_deg: Option<f64>,
}

impl<'a> SphereJson<'a> {
    fn of(of: &'a MeasuredSphere) -> Self {
        let found = findings(of);
        let (bars, met) = found.score();
        let findings = found.findings.into_iter().map(|finding| BarJson {
            what: finding.what,
            bar: finding.bar,
            measured: finding.ours,
            beside: finding.published,
            met: finding.met,
        });
        let winds = |row: &Directions| UnseenWindsJson {
            winds: row.winds,
            speed_rms_error: row.errors.speed.rms(),
            direction_rms_error_deg: row.errors.direction_deg.rms(),
            linear_direction_rms_error_deg: row.errors.linear_deg.rms(),
        };
        let steps = of.steps.iter().flat_map(|steps| steps.ways.iter().map(|way| (steps.mode, way)));
        let bands = of.turbulence.iter().flat_map(|row| row.bands.iter().map(|band| (row.mode, band)));
        Self {
            bars,
            met,
            findings: findings.collect(),
            winds: of.directions.iter().map(|row| InMode { mode: row.mode, measured: winds(row) }).collect(),
            steps: steps.map(|(mode, measured)| InMode { mode, measured }).collect(),
            drift: &of.drift,
            turbulence: bands.map(|(mode, measured)| InMode { mode, measured }).collect(),
            gas_swing_worst_error: of.swing.speed_worst,
            conductance_noise_w_k: &of.noise_w_k,
        }
    }
}
