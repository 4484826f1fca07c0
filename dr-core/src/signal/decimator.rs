//! From the power of every tick to mean power: a cascaded integrator–comb (sinc^M) decimator.
//!
//! H(z) = ((1 − z^−R) / (R (1 − z^−1)))^M with order M and ratio R: M moving averages of R ticks,
//! one output in R ticks. Zeros at every multiple of the output rate, so that what would alias onto
//! the mean is taken out M-fold; a first-order modulator wants M ≥ 2 (Candy, *Decimation for sigma
//! delta modulation*, IEEE Trans. Commun. 34, 1986).
//!
//! | property | value |
//! |---|---|
//! | gain at zero frequency | 1 |
//! | length of the response | M (R − 1) + 1 ticks |
//! | group delay, to the last tick of an output | M (R − 1) / 2 ticks |
//!
//! Sums are kept in wrapping integers of 2⁻²⁸ W: a comb then takes off exactly what an integrator
//! took in (Hogenauer, 1981), which floats would not. Range ±8 W; the last bit is 3.7 nW.

use crate::error::{self, ConfigError, Parameter};

/// Counts a watt.
const COUNTS_PER_WATT: f32 = 268_435_456.0;

/// A decimator of order M. Immutable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decimator<const M: usize> {
    ratio: u32,
    watt_per_count: f32,
}

/// State of a decimator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DecimatorState<const M: usize> {
    integrators: [i64; M],
    combs: [i64; M],
    ticks: u32,
    outputs: u32,
}

impl<const M: usize> Default for DecimatorState<M> {
    fn default() -> Self {
        Self { integrators: [0; M], combs: [0; M], ticks: 0, outputs: 0 }
    }
}

impl<const M: usize> Decimator<M> {
    const IS_PROPER: () = assert!(M >= 2, "one moving average lets the modulator's noise alias onto the mean");

    /// A decimator that makes one mean of `ratio` ticks.
    ///
    /// # Errors
    /// If the ratio is 0, or so large that ratio^M times 8 W would not fit the sums (ratio^M >
    /// 2³²).
    pub fn new(ratio: u32) -> Result<Self, ConfigError> {
        let () = Self::IS_PROPER;
        let gain = (0..M).try_fold(1_u64, |gain, _| gain.checked_mul(u64::from(ratio))).unwrap_or(u64::MAX);
        if ratio == 0 || gain > 1 << 32 {
            let most = libm::floor(libm::pow(4_294_967_296.0, 1.0 / M as f64) + 1e-9) as f32;
            return Err(error::out_of_range(Parameter::DecimatorRatio, 1.0, most));
        }
        Ok(Self { ratio, watt_per_count: (1.0 / (gain as f64 * f64::from(COUNTS_PER_WATT))) as f32 })
    }

    /// Ticks from the middle of an output's window to its last tick.
    pub fn delay_ticks(&self) -> f32 {
        (M as f32) * (self.ratio as f32 - 1.0) / 2.0
    }

    /// Takes in the power of one tick in W; every `ratio` ticks gives the mean in W, once the
    /// window is full.
    pub fn push(&self, state: &mut DecimatorState<M>, power_w: f32) -> Option<f32> {
        // Adding half a count makes the truncation of the cast a rounding, for the positive values
        // that powers are.
        let mut value = i64::from((power_w * COUNTS_PER_WATT + 0.5) as i32);
        for integrator in &mut state.integrators {
            *integrator = integrator.wrapping_add(value);
            value = *integrator;
        }
        state.ticks += 1;
        if state.ticks < self.ratio {
            return None;
        }
        state.ticks = 0;
        for comb in &mut state.combs {
            let before = core::mem::replace(comb, value);
            value = value.wrapping_sub(before);
        }
        // The first M − 1 outputs still see the emptiness before the start.
        if (state.outputs as usize) < M - 1 {
            state.outputs += 1;
            return None;
        }
        Some(value as f32 * self.watt_per_count)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::error::ParameterProblem;
    use crate::signal::sigma_delta::SigmaDelta;
    use std::vec::Vec;

    fn run<const M: usize>(ratio: u32, powers: impl Iterator<Item = f32>) -> Vec<f32> {
        let decimator = Decimator::<M>::new(ratio).unwrap();
        let mut state = DecimatorState::default();
        powers.filter_map(|power_w| decimator.push(&mut state, power_w)).collect()
    }

    #[test]
    fn a_constant_comes_through_from_the_first_output() {
        for output in run::<3>(100, core::iter::repeat_n(0.0421, 100_000)) {
            // half a count of rounding, one f32 rounding
            assert!((output - 0.0421).abs() < 6e-9);
        }
    }

    #[test]
    fn its_response_is_the_cascade_of_moving_averages() {
        // Ratio 4, order 2: an impulse spread over a triangle of weights 1 2 3 4 3 2 1 over 16.
        for offset in 0..4 {
            let powers = (0..24).map(|n| if n == 8 + offset { 1.0 } else { 0.0 });
            let sum: f32 = run::<2>(4, powers).iter().sum();
            // whatever its place, the weights that an impulse meets add up to one output in R
            assert!((sum - 0.25).abs() < 1e-8, "{offset}: {sum}");
        }
        let triangle = run::<2>(4, (0..24).map(|n| if n == 8 { 1.0 } else { 0.0 }));
        assert_eq!(&triangle[1..3], &[4.0 / 16.0, 0.0]);
        let next = run::<2>(4, (0..24).map(|n| if n == 9 { 1.0 } else { 0.0 }));
        assert_eq!(&next[1..3], &[3.0 / 16.0, 1.0 / 16.0]);
    }

    #[test]
    fn reads_the_mean_of_a_sigma_delta_better_than_blocks_do() {
        let (low, high, delta) = (0.0015, 0.0421, 0.3712);
        let mean = f64::from(low) + f64::from(delta) * f64::from(high - low);
        let mut modulator = SigmaDelta::default();
        let powers: Vec<f32> = (0..50_000).map(|_| if modulator.step(delta) { high } else { low }).collect();
        let rms = |outputs: &[f32]| {
            (outputs.iter().map(|&p| (f64::from(p) - mean).powi(2)).sum::<f64>() / outputs.len() as f64).sqrt()
        };
        let blocks: Vec<f32> = powers.chunks_exact(100).map(|c| c.iter().sum::<f32>() / 100.0).collect();
        let (third, block) = (rms(&run::<3>(100, powers.iter().copied())), rms(&blocks));
        assert!(third < block / 20.0, "sinc³ {third:e}, blocks {block:e}");
    }

    #[test]
    fn a_ramp_comes_out_late_by_the_stated_delay() {
        // Each output of a ramp of one count a tick is the ramp's value in the middle of its
        // window.
        let count_w = 1.0 / COUNTS_PER_WATT;
        let decimator = Decimator::<3>::new(9).unwrap();
        let mut state = DecimatorState::default();
        assert_eq!(decimator.delay_ticks(), 12.0);
        for tick in 0..900 {
            if let Some(output) = decimator.push(&mut state, tick as f32 * count_w) {
                assert!((output / count_w - (tick as f32 - decimator.delay_ticks())).abs() < 1e-3, "tick {tick}");
            }
        }
    }

    #[test]
    fn powers_are_rounded_to_the_nearest_count() {
        for (counts, nearest) in [(10.4, 10.0), (10.6, 11.0)] {
            for output in run::<2>(4, core::iter::repeat_n(counts / COUNTS_PER_WATT, 40)) {
                assert_eq!(output * COUNTS_PER_WATT, nearest);
            }
        }
    }

    #[test]
    fn sums_may_wrap_without_harm() {
        // 8e6 ticks of 7.9 W overflow the third integrator's 64 bits many times.
        let outputs = run::<3>(1600, core::iter::repeat_n(7.9, 8_000_000));
        assert_eq!(outputs.len(), 4998);
        assert!(outputs.iter().all(|p| (p - 7.9).abs() < 1e-6));
    }

    #[test]
    fn refuses_ratios_that_would_not_fit() {
        assert!(Decimator::<2>::new(0).is_err());
        assert!(Decimator::<2>::new(65_536).is_ok());
        assert!(Decimator::<2>::new(65_537).is_err());
        assert_eq!(
            Decimator::<3>::new(2_000).unwrap_err().problem,
            ParameterProblem::OutOfRange { least: 1.0, most: 1625.0 }
        );
    }
}
