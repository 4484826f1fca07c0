//! Frequency responses: |H(j2πf)| and arg H(j2πf) of every pair and class, wind included, with
//! bands of 95 % by the covariance of all parameters together.
//!
//! The record speaks of the band from 1/T, with T its duration, to its Nyquist frequency 1/(2 Ts).
//! Beyond it the model is extrapolated.

use std::f64::consts::{PI, TAU};

use dr_core::model::mesh;

use super::curves::{CURVES, NO_BAND, band, gain_unit, label, left_out, log_band, of};
use crate::engine::axis::Scale;
use crate::engine::chart::Chart;
use crate::engine::trace::Trace;
use diffusive::model::certainty::response_error;
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
    let nyquist = PI / model.sample_period_s;
    let duration_s = model.provenance.duration_s;
    let slowest = if duration_s > 0.0 { TAU / duration_s } else { rates().fold(nyquist, f64::min) };
    let (low, high) = (rates().fold(slowest, f64::min) / 3.0, rates().fold(nyquist, f64::max) * 3.0);
    let frequencies: Vec<f64> = (0..POINTS).map(|n| mesh::rate_rad_s(low, high, n, POINTS)).collect();
    let axes = |caption: &str, unit: &str| {
        let of_output = format!("{caption}{}", of(model, output));
        let chart = Chart::new(of_output, unit).y_title(caption).x(Scale::Log, "Hz").height(38.0);
        chart.shading(slowest / TAU, nyquist / TAU, 5, "band of the record")
    };
    let (mut magnitude, mut phase) = (axes("Magnitude", &unit).y(Scale::Log), axes("Phase", "°"));
    let by = model.inflation(output);
    let (mut curves, mut cut, mut bands) = (0, false, 0);
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
        let errors: Vec<_> = response.iter().map(|(omega, ..)| response_error(model, pair, class, *omega)).collect();
        bands += usize::from(errors.iter().any(Option::is_some));
        let sizes = response.iter().zip(&errors).map(|((omega, re, im), error)| {
            (omega / TAU, libm::hypot(*re, *im), error.map(|error| error.log_magnitude))
        });
        let degrees = unwound(&response);
        let whole = degrees.len();
        let degrees = degrees.into_iter().zip(&errors).filter(|((_, degrees), _)| *degrees >= LOWEST_PHASE);
        let degrees: Vec<_> = degrees
            .map(|((omega, degrees), error)| (omega / TAU, degrees, error.map(|error| error.phase_deg)))
            .collect();
        cut |= degrees.len() < whole;
        let sizes: Vec<_> = sizes.collect();
        magnitude = magnitude.trace(Trace::bins(label(model, pair, class), log_band(&sizes, by)));
        // The legend stands above the magnitude.
        phase = phase.trace(Trace::bins("", band(&degrees, by)));
    }
    let of_bands = match bands {
        0 => NO_BAND,
        _ if bands < curves.min(CURVES) => "bands: 95 %, of the reference only",
        _ => "bands: 95 %",
    };
    magnitude = magnitude.note(of_bands);
    let cut = cut.then(|| "cut where dead time turns it further".to_owned());
    [left_out(magnitude, curves), phase.notes(cut)]
}

/// Phases in degrees that go on where the angle jumps by a turn.
fn unwound(response: &[(f64, f64, f64)]) -> Vec<(f64, f64)> {
    let mut before = 0.0;
    let phase = response.iter().map(|&(omega, re, im)| {
        let degrees = libm::atan2(im, re).to_degrees();
        before = degrees + 360.0 * ((before - degrees) / 360.0_f64).round();
        (omega, before)
    });
    phase.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use diffusive::model::testing;

    #[test]
    fn bands_of_one_pole_are_those_of_its_resistance_and_its_rate() {
        // ln |H| = ln R − ½ ln(1 + w²) and arg H = −atan w with w = ω/ξ: by d ln R they move by 1
        // and 0, by d ln ξ by w²/(1 + w²) and w/(1 + w²).
        let (resistance, rate, se_r, se_rate, correlation) = (50.0, 0.2, 0.5, 0.02, -0.6);
        let mut model = testing::model(&[rate], &[resistance]);
        model.pairs[0].se_rate_rad_s = Some(vec![rate * se_rate]);
        let class = model.pairs[0].classes.get_mut("all").unwrap();
        class.se_steady_gain_k_per_w = se_r;
        class.covariance = Some(vec![se_r * se_r, 0.0, 0.0, correlation * se_r * se_rate, 0.0, se_rate * se_rate]);
        let relative = se_r / resistance;
        let [magnitude, phase] = bode(&model, "temperature_c_a");
        let mut inside = 0;
        for (size, angle) in magnitude.traces[0].bins.iter().zip(&phase.traces[0].bins) {
            let w = TAU * size.from_s / rate;
            let (of_log, of_angle) = (w * w / (1.0 + w * w), w / (1.0 + w * w));
            let covariance = correlation * relative * se_rate;
            let se_log = (relative.powi(2) + 2.0 * of_log * covariance + (of_log * se_rate).powi(2)).sqrt();
            let se_degrees = (of_angle * se_rate).to_degrees();
            assert!((size.mean - resistance / libm::hypot(w, 1.0)).abs() < 1e-9);
            assert!((libm::log(size.most / size.mean) - 1.96 * se_log).abs() < 1e-9, "{size:?}, {se_log}");
            assert!((libm::log(size.mean / size.least) - 1.96 * se_log).abs() < 1e-9, "{size:?}, {se_log}");
            assert!((angle.most - angle.mean - 1.96 * se_degrees).abs() < 1e-9, "{angle:?}, {se_degrees}");
            inside += usize::from((0.1..10.0).contains(&w));
        }
        // The corner itself is among them.
        assert!(inside > 50, "{inside}");
    }

    #[test]
    fn a_phase_goes_on_below_half_a_turn() {
        // A pure dead time of 1 s: −ω
        let response: Vec<_> = (0..100).map(|n| f64::from(n) * 0.1).map(|w| (w, libm::cos(w), -libm::sin(w))).collect();
        for (omega, degrees) in unwound(&response) {
            assert!((degrees + omega.to_degrees()).abs() < 1e-9);
        }
    }
}
