//! What `anemo benchmark wind` prints: its page as text, and its numbers as JSON.

use std::fmt;

use serde::ser::{Serialize, SerializeMap, Serializer};

use super::findings::findings;
use super::measure::MeasuredSphere;
use super::page::page;

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

#[derive(serde::Serialize)]
struct SphereJson {
    bars: usize,
    met: usize,
    findings: Vec<BarJson>,
    winds: Vec<UnseenWindsJson>,
    steps: Vec<StepsJson>,
    drift: [f64; 2],
    raw_drift: [f64; 2],
    raw_response_s: [f64; 2],
    turbulence: Vec<BandJson>,
    gas_swing_worst_error: f64,
    conductance_noise_w_k: Vec<NoiseJson>,
}

#[derive(serde::Serialize)]
struct BarJson {
    what: String,
    bar: String,
    measured: String,
    beside: String,
    met: Option<bool>,
}

#[derive(serde::Serialize)]
struct UnseenWindsJson {
    bandwidth_hz: f64,
    fixed: bool,
    winds: usize,
    speed_rms_error: Option<f64>,
    direction_rms_error_deg: Option<f64>,
    linear_direction_rms_error_deg: Option<f64>,
}

#[derive(serde::Serialize)]
struct StepsJson {
    bandwidth_hz: f64,
    fixed: bool,
    to_m_s: f64,
    mean_response_s: f64,
    single_response_s: f64,
    noise: f64,
    outside: f64,
}

#[derive(serde::Serialize)]
struct BandJson {
    bandwidth_hz: f64,
    fixed: bool,
    from_hz: f64,
    to_hz: f64,
    coherence: f64,
    gain: f64,
}

#[derive(serde::Serialize)]
struct NoiseJson {
    bandwidth_hz: f64,
    value: f64,
}

impl SphereJson {
    fn of(of: &MeasuredSphere) -> Self {
        let found = findings(of);
        let (bars, met) = found.score();
        let findings = found.findings.into_iter().map(|finding| BarJson {
            what: finding.what,
            bar: finding.bar,
            measured: finding.ours,
            beside: finding.published,
            met: finding.met,
        });
        let winds = of.directions.iter().map(|row| UnseenWindsJson {
            bandwidth_hz: row.mode.bandwidth_hz,
            fixed: row.mode.fixed,
            winds: row.winds,
            speed_rms_error: row.errors.speed.rms(),
            direction_rms_error_deg: row.errors.direction_deg.rms(),
            linear_direction_rms_error_deg: row.errors.linear_deg.rms(),
        });
        let steps = of.steps.iter().flat_map(|steps| {
            steps.ways.iter().map(|way| StepsJson {
                bandwidth_hz: steps.mode.bandwidth_hz,
                fixed: steps.mode.fixed,
                to_m_s: way.to_m_s,
                mean_response_s: way.mean_response_s,
                single_response_s: way.single_response_s,
                noise: way.noise,
                outside: way.outside,
            })
        });
        let turbulence = of.turbulence.iter().flat_map(|row| {
            row.bands.iter().map(|band| BandJson {
                bandwidth_hz: row.mode.bandwidth_hz,
                fixed: row.mode.fixed,
                from_hz: band.from_hz,
                to_hz: band.to_hz,
                coherence: band.coherence,
                gain: band.gain,
            })
        });
        let noise = of.noise_w_k.iter().map(|&(bandwidth_hz, value)| NoiseJson { bandwidth_hz, value });
        Self {
            bars,
            met,
            findings: findings.collect(),
            winds: winds.collect(),
            steps: steps.collect(),
            drift: of.drift.answer,
            raw_drift: of.drift.raw,
            raw_response_s: of.drift.raw_response_s,
            turbulence: turbulence.collect(),
            gas_swing_worst_error: of.swing.speed_worst,
            conductance_noise_w_k: noise.collect(),
        }
    }
}
