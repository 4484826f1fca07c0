//! Frequency responses: |H(jω)| and arg H(jω) of every pair and class, wind included.
//!
//! The record speaks of the band from 2π/T, with T its duration, to its Nyquist frequency π/Ts.
//! Beyond it the model is extrapolated.

use dr_core::model::mesh;

use super::naming::{CURVES, gain_unit, label, left_out, of};
use crate::engine::axis::Scale;
use crate::engine::chart::Chart;
use crate::engine::trace::Trace;
use diffusive::model::export::response_in_class;
use diffusive::model::{Model, Pair};

/// Points of a curve.
const POINTS: usize = 400;
/// Dead time turns the phase without end: it is cut here, where two points of a curve still differ
/// by less than half a turn.
const LOWEST_PHASE: f64 = -720.0;

/// Magnitude and phase of the pairs that lead to an output, over the record's band.
pub fn bode(model: &Model, output: &str) -> [Chart; 2] {
    let pairs: Vec<&Pair> = model.pairs.iter().filter(|pair| pair.output == output).collect();
    let unit = gain_unit(model, output);
    let rates = || pairs.iter().flat_map(|pair| pair.mesh_rad_s.iter().copied());
    let nyquist = std::f64::consts::PI / model.sample_period_s;
    let duration_s = model.provenance.duration_s;
    let slowest = if duration_s > 0.0 { std::f64::consts::TAU / duration_s } else { rates().fold(nyquist, f64::min) };
    let (low, high) = (rates().fold(slowest, f64::min) / 3.0, rates().fold(nyquist, f64::max) * 3.0);
    let frequencies: Vec<f64> = (0..POINTS).map(|n| mesh::rate_rad_s(low, high, n, POINTS)).collect();
    let axes = |caption: &str, unit: &str| {
        Chart::new(format!("{caption}{}", of(model, output)), unit).x(Scale::Log, "rad/s").height(38.0).shading(
            slowest,
            nyquist,
            5,
            "band of the record",
        )
    };
    let (mut magnitude, mut phase) = (axes("Magnitude", &unit).y(Scale::Log), axes("Phase", "°"));
    let (mut curves, mut cut) = (0, false);
    for (pair, class) in pairs.iter().flat_map(|pair| model.classes.iter().map(move |class| (pair, class))) {
        let at = |omega: &f64| response_in_class(model, pair, class, *omega).map(|value| (*omega, value.re, value.im));
        let response: Vec<(f64, f64, f64)> = frequencies.iter().filter_map(at).collect();
        if response.is_empty() {
            continue;
        }
        curves += 1;
        if curves > CURVES {
            continue;
        }
        let mut degrees = unwound(&response);
        let whole = degrees.len();
        degrees.retain(|(_, degrees)| *degrees >= LOWEST_PHASE);
        cut |= degrees.len() < whole;
        let sizes = response.iter().map(|(omega, re, im)| (*omega, re.hypot(*im))).collect();
        magnitude = magnitude.trace(Trace::line(label(model, pair, class), sizes));
        // The legend stands above the magnitude.
        phase = phase.trace(Trace::line("", degrees));
    }
    let cut = cut.then(|| "cut where dead time turns it further".to_owned());
    [left_out(magnitude, curves), phase.notes(cut)]
}

/// Phases in degrees that go on where the angle jumps by a turn.
fn unwound(response: &[(f64, f64, f64)]) -> Vec<(f64, f64)> {
    let mut before = 0.0;
    let phase = response.iter().map(|&(omega, re, im)| {
        let degrees = im.atan2(re).to_degrees();
        before = degrees + 360.0 * ((before - degrees) / 360.0_f64).round();
        (omega, before)
    });
    phase.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_phase_goes_on_below_half_a_turn() {
        // A pure dead time of 1 s: −ω
        let response: Vec<_> = (0..100).map(|n| f64::from(n) * 0.1).map(|w| (w, w.cos(), -w.sin())).collect();
        for (omega, degrees) in unwound(&response) {
            assert!((degrees + omega.to_degrees()).abs() < 1e-9);
        }
    }
}
