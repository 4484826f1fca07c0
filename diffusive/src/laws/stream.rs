//! Convolution of a step response with an input that is held from row to row.
//!
//! ```text
//! v_n = Σ_{m<n} u_m (S_{n−m} − S_{n−m−1})
//! ```
//!
//! Any response goes by FFT, in a time that hardly grows faster than the rows: 10⁶ rows take some
//! tenths of a second. The error is rounding alone, about 1e-15 of the greatest input times the
//! greatest response. An exponential needs no FFT, as it goes from row to row by its own relaxation
//! step.

use std::sync::Arc;

use dr_core::model::mesh;
use realfft::num_complex::Complex;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};

/// An input, row by row, and its spectrum.
pub struct InputStream {
    input: Vec<f64>,
    forward: Arc<dyn RealToComplex<f64>>,
    back: Arc<dyn ComplexToReal<f64>>,
    spectrum: Vec<Complex<f64>>,
}

impl InputStream {
    pub fn new(input: &[f64]) -> Self {
        // As much room again, so that the end of the response does not come round to the first
        // rows.
        let length = (2 * input.len()).next_power_of_two();
        let mut planner = RealFftPlanner::new();
        let (forward, back) = (planner.plan_fft_forward(length), planner.plan_fft_inverse(length));
        let spectrum = transformed(forward.as_ref(), input.iter().copied());
        Self { input: input.to_vec(), forward, back, spectrum }
    }

    pub fn rows(&self) -> usize {
        self.input.len()
    }

    /// The answer to the input from rest, for a step response that is sampled at the rows.
    pub fn response(&self, steps: &[f64]) -> Vec<f64> {
        let rises = std::iter::once(0.0).chain(steps.windows(2).map(|pair| pair[1] - pair[0]));
        let mut product = transformed(self.forward.as_ref(), rises);
        product.iter_mut().zip(&self.spectrum).for_each(|(bin, of_input)| *bin *= of_input);
        let mut rows = self.back.make_output_vec();
        // It asks that lengths are the plan's, and that the ends of the spectrum are real, which
        // products of such are.
        if self.back.process(&mut product, &mut rows).is_err() {
            rows.fill(f64::NAN);
        }
        let scale = 1.0 / rows.len() as f64;
        rows.truncate(self.input.len());
        rows.iter_mut().for_each(|value| *value *= scale);
        rows
    }

    /// The answer of an exponential from rest, and its slope by ln τ.
    pub fn relaxation(&self, time_constant_s: f64, sample_period_s: f64) -> [Vec<f64>; 2] {
        relaxed(self.input.iter().copied(), 0.0, time_constant_s, sample_period_s)
    }

    /// What an exponential leaves of 1 at the first row, and its slope by ln τ.
    pub fn decay(&self, time_constant_s: f64, sample_period_s: f64) -> [Vec<f64>; 2] {
        relaxed(std::iter::repeat_n(0.0, self.rows()), 1.0, time_constant_s, sample_period_s)
    }
}

fn relaxed(
    input: impl ExactSizeIterator<Item = f64>,
    start: f64,
    time_constant_s: f64,
    sample_period_s: f64,
) -> [Vec<f64>; 2] {
    let gain = mesh::gain(1.0 / time_constant_s, sample_period_s);
    let steep = -sample_period_s / time_constant_s * (1.0 - gain);
    let (mut state, mut slope) = (start, 0.0);
    let (mut states, mut slopes) = (Vec::with_capacity(input.len()), Vec::with_capacity(input.len()));
    for input in input {
        states.push(state);
        slopes.push(slope);
        slope += steep * (input - state) - gain * slope;
        state += gain * (input - state);
    }
    [states, slopes]
}

fn transformed(forward: &dyn RealToComplex<f64>, values: impl Iterator<Item = f64>) -> Vec<Complex<f64>> {
    let (mut padded, mut spectrum) = (forward.make_input_vec(), forward.make_output_vec());
    padded.iter_mut().zip(values).for_each(|(place, value)| *place = value);
    // Lengths are those of the plan.
    if forward.process(&mut padded, &mut spectrum).is_err() {
        spectrum.fill(Complex::new(f64::NAN, 0.0));
    }
    spectrum
}

#[cfg(test)]
mod tests {
    use super::super::kernel::StepKernel;
    use super::*;

    /// ±1, in no rhythm.
    fn symbols(rows: usize) -> Vec<f64> {
        let bit = |n: usize| (n as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 62 & 1;
        (0..rows).map(|n| if bit(n) == 1 { 1.0 } else { -1.0 }).collect()
    }

    #[test]
    fn the_transform_gives_the_sum_itself() {
        let (rows, period_s) = (300, 0.5);
        let input = symbols(rows);
        for kernel in [StepKernel::Stretched, StepKernel::SquareRoot] {
            let step = |n: usize| kernel.answer(&[3.0, 0.5_f64.ln()], n as f64 * period_s).value;
            let steps: Vec<f64> = (0..rows).map(step).collect();
            let found = InputStream::new(&input).response(&steps);
            for n in 0..rows {
                let sum: f64 = (0..n).map(|m| input[m] * (steps[n - m] - steps[n - m - 1])).sum();
                assert!((found[n] - sum).abs() < 1e-13, "{kernel:?} {n}: {} {sum}", found[n]);
            }
        }
    }

    #[test]
    fn a_long_stream_through_an_exponential_is_the_same_by_transform_and_by_recursion() {
        let (rows, period_s, tau_s) = (200_000, 1.0, 5000.0_f64);
        let stream = InputStream::new(&symbols(rows));
        let answer = |n: usize| StepKernel::Exponential.answer(&[tau_s.ln()], n as f64 * period_s);
        let steps: Vec<f64> = (0..rows).map(|n| answer(n).value).collect();
        let slopes: Vec<f64> = (0..rows).map(|n| answer(n).slopes[0]).collect();
        let [state, slope] = stream.relaxation(tau_s, period_s);
        let most = |by: &[f64], other: &[f64]| by.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // 2e5 sums of rounded terms, whose errors are of either sign: √2e5 × 1e-16, and as much of
        // the transform.
        assert!(most(&stream.response(&steps), &state) < 1e-12);
        assert!(most(&stream.response(&slopes), &slope) < 1e-12);
        // What is left after n steps has n roundings.
        let [left, left_slope] = stream.decay(tau_s, period_s);
        let ends: Vec<f64> = (0..rows).map(|n| answer(n).left).collect();
        let rising: Vec<f64> = slopes.iter().map(|slope| -slope).collect();
        assert!(most(&left, &ends) < 1e-11 && most(&left_slope, &rising) < 1e-11);
    }
}
