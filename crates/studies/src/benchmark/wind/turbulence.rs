//! Answers beside a turbulent wind: coherence and gain by band, of the speed along the mean wind, by
//! Welch's estimate.
//!
//! ```text
//! γ²(f) = |Σ Y X*|² / (Σ |X|² Σ |Y|²)        |H(f)| = |Σ Y X*| / Σ |X|²
//! ```
//!
//! with X the true wind and Y the estimate, over segments that overlap by half, under Hann's window
//! and without their means (Welch, IEEE Trans. Audio Electroacoust. 15, 70 (1967)). Only the few
//! frequencies that are needed are computed.

use super::blown::blow;
use super::sphere::WindMode;
use crate::thesis::StudyLab;
use anemometry::head::Head;
use anyhow::Result;
use std::f64::consts::TAU;

/// Length of the estimate, s.
const SEGMENT_S: f64 = 20.48;
/// Edges of the bands, Hz.
const EDGES_HZ: [f64; 5] = [0.05, 0.5, 1.0, 1.5, 2.0];

/// One mode.
#[derive(Debug, Clone)]
pub struct TurbulenceResponse {
    /// The bandwidth.
    pub mode: WindMode,
    /// By band of frequency.
    pub bands: Vec<Band>,
}

/// Measures coherence and gain in turbulence, by bandwidth.
///
/// # Errors
/// What could not be run.
pub fn measure(lab: &StudyLab, head: &Head, modes: &[WindMode]) -> Result<Vec<TurbulenceResponse>> {
    let experiment = lab.experiment("turbulence")?;
    lab.announce(&experiment);
    let from_s = experiment.wind.last().map_or(0.0, |wind| wind.start_s);
    let mut truth = Vec::new();
    let mut answers: Vec<Vec<f64>> = vec![Vec::new(); modes.len()];
    let mut times_s = Vec::new();
    blow(&experiment, head, modes, &mut |place, moment, answer| {
        let Some(wind_m_s) = moment.wind_m_s.filter(|_| moment.time_s >= from_s) else { return };
        if place == 0 {
            times_s.push(moment.time_s);
            truth.push(anemometry::vector::length(wind_m_s));
        }
        answers[place].push(f64::from(answer.speed_m_s));
    })?;
    let every_s = times_s.get(1).zip(times_s.first()).map_or(f64::NAN, |(next, first)| next - first);
    let of = |(answer, &mode): (&Vec<f64>, &WindMode)| TurbulenceResponse {
        mode,
        bands: bands(&truth, answer, every_s, SEGMENT_S, &EDGES_HZ),
    };
    Ok(answers.iter().zip(modes).map(of).collect())
}

/// A band of frequencies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Band {
    /// Lower edge, Hz.
    pub from_hz: f64,
    /// Upper edge, Hz.
    pub to_hz: f64,
    /// Mean coherence γ² of the band.
    pub coherence: f64,
    /// Mean gain |H| of the band.
    pub gain: f64,
}

/// Sums over segments: of |X|², |Y|² and Y X*.
#[derive(Debug, Clone, Copy, Default)]
struct Spectra {
    x: f64,
    y: f64,
    cross: (f64, f64),
}

/// Coherence and gain in bands: means over their frequencies, which are multiples of 1/segment_s.
pub fn bands(truth: &[f64], answer: &[f64], every_s: f64, segment_s: f64, edges_hz: &[f64]) -> Vec<Band> {
    let length = (segment_s / every_s).round() as usize;
    let step_hz = 1.0 / (length as f64 * every_s);
    let rows = truth.len().min(answer.len());
    let of_bin = |bin: usize| {
        let mut sums = Spectra::default();
        for from in (0..=rows.saturating_sub(length)).step_by((length / 2).max(1)) {
            let (x, y) = (line(&truth[from..from + length], bin), line(&answer[from..from + length], bin));
            sums.x += x.0 * x.0 + x.1 * x.1;
            sums.y += y.0 * y.0 + y.1 * y.1;
            sums.cross.0 += y.0 * x.0 + y.1 * x.1;
            sums.cross.1 += y.1 * x.0 - y.0 * x.1;
        }
        let cross2 = sums.cross.0.powi(2) + sums.cross.1.powi(2);
        (cross2 / (sums.x * sums.y), cross2.sqrt() / sums.x)
    };
    let band = |edges: &[f64]| {
        let (from_hz, to_hz) = (edges[0], edges[1]);
        let bins = (from_hz / step_hz).ceil().max(1.0) as usize..=(to_hz / step_hz).floor() as usize;
        let count = bins.clone().count().max(1) as f64;
        let (coherence, gain) = bins.map(of_bin).fold((0.0, 0.0), |sum, of| (sum.0 + of.0, sum.1 + of.1));
        Band { from_hz, to_hz, coherence: coherence / count, gain: gain / count }
    };
    if rows < length { Vec::new() } else { edges_hz.windows(2).map(band).collect() }
}

/// One line of a segment's spectrum.
fn line(values: &[f64], bin: usize) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    values.iter().enumerate().fold((0.0, 0.0), |(re, im), (n, value)| {
        let window = 0.5 - 0.5 * libm::cos(TAU * n as f64 / count);
        let (sin, cos) = libm::sincos(TAU * (bin * n % values.len()) as f64 / count);
        let weighed = window * (value - mean);
        (re + weighed * cos, im - weighed * sin)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers that follow no pattern, −0.5 … 0.5.
    fn noise(mut state: u64) -> impl FnMut() -> f64 {
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        }
    }

    #[test]
    fn a_lag_and_noise_have_the_gain_and_the_coherence_that_they_should() {
        // y follows white x by a first-order lag of corner 1 Hz, |H|² = 1/(1 + f²), and noise of
        // the same strength is added to it: γ² = |H|²/(|H|² + 1). 200 segments leave errors of
        // about 5 % of it.
        let (every_s, corner_hz) = (0.01, 1.0);
        let share = 1.0 - libm::exp(-TAU * corner_hz * every_s);
        let (mut x, mut e) = (noise(1), noise(2));
        let mut state = 0.0;
        let (truth, answer): (Vec<f64>, Vec<f64>) = (0..102_400)
            .map(|_| {
                let value = x();
                state += share * (value - state);
                (value, state + e())
            })
            .unzip();
        for band in bands(&truth, &answer, every_s, 10.24, &[0.45, 0.55, 0.95, 1.05, 1.95, 2.05]).iter().step_by(2) {
            let f = 0.5 * (band.from_hz + band.to_hz);
            let h2 = 1.0 / (1.0 + f * f);
            assert!((band.gain / h2.sqrt() - 1.0).abs() < 0.1, "{band:?} {}", h2.sqrt());
            assert!((band.coherence / (h2 / (h2 + 1.0)) - 1.0).abs() < 0.15, "{band:?} {}", h2 / (h2 + 1.0));
        }
        let same = &bands(&truth, &truth, every_s, 10.24, &[0.1, 2.0])[0];
        assert!((same.coherence - 1.0).abs() < 1e-9 && (same.gain - 1.0).abs() < 1e-9);
    }
}
