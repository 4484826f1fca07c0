//! Loss of a smaller model in f32, measured: the core's own relaxations beside the whole model in
//! f64, on the same input.
//!
//! | input | is |
//! |---|---|
//! | bits | a pseudo-random binary sequence of two sample periods a bit, as experiments use it |
//! | levels | random levels, held for anything from two periods to three of the slowest time constants |
//!
//! Both swing by ±1 about zero, so that the mean, which is easy, does not hide the rest.
//! Feed-through and dead time are the same in both models and left out.

use dr_core::model::{ORDER, RelaxationState, Relaxations, Symbol, mesh};
use dr_core::signal::Prbs;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng as _;
use rand_distr::{Distribution as _, Uniform};

use crate::model::ModelError;
use crate::model::content::Model;

/// Under one input.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize)]
pub struct Difference {
    /// Root mean square of the outputs' difference, as a share of the output's.
    pub rms_share: f64,
    /// Largest difference for an input of ±1, K/W.
    pub largest_k_per_w: f64,
}

/// Loss of one pair in one class.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Loss {
    /// Column that heats.
    pub input: String,
    /// Column that is heated.
    pub output: String,
    /// Label of the class.
    pub class: String,
    /// Under random bits.
    pub bits: Difference,
    /// Under random levels.
    pub levels: Difference,
    /// Relative to the whole model's steady gain; to 1 K/W if that is zero.
    pub steady_gain_change: f64,
}

/// A smaller model and, for every pair and class, what it loses.
#[derive(Debug, Clone)]
pub struct Reduced {
    /// The smaller model.
    pub model: Model,
    /// One a pair and class.
    pub losses: Vec<Loss>,
}

/// Enough to see the slowest pole swing a few times; more only costs time.
const SAMPLES: std::ops::RangeInclusive<f64> = 20_000.0..=400_000.0;

/// One pole an entry: rate in rad/s and resistance in K/W.
type PoleList<'a> = (&'a [f64], &'a [f64]);

/// (bits, levels), or why the core refuses the smaller model.
pub fn measure(
    whole: PoleList,
    rates_rad_s: &[f32; ORDER],
    r_k_per_w: &[f32; ORDER],
    period_s: f64,
) -> Result<(Difference, Difference), ModelError> {
    let small =
        (Relaxations::new(rates_rad_s, period_s as f32).map_err(refused)?, Symbol::new(*r_k_per_w).map_err(refused)?);
    let slowest = whole.0.first().copied().unwrap_or(1.0) * period_s;
    let samples = (40.0 / slowest).clamp(*SAMPLES.start(), *SAMPLES.end()) as usize;
    let mut prbs = Prbs::new(31, 0x0b5e_55ed).map_err(refused)?;
    let mut bit = false;
    let bits = run(whole, &small, period_s, samples, |n| {
        if n % 2 == 0 {
            bit = prbs.step();
        }
        if bit { 1.0 } else { -1.0 }
    });
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let spans = Uniform::new(libm::log(2.0), libm::log((3.0 / slowest).max(4.0))).map_err(refused)?;
    let levels = Uniform::new(-1.0_f32, 1.0).map_err(refused)?;
    let (mut left, mut level) = (0, 0.0);
    let levels = run(whole, &small, period_s, samples, |_| {
        if left == 0 {
            (left, level) = (libm::exp(spans.sample(&mut random)) as usize, levels.sample(&mut random));
        }
        left -= 1;
        level
    });
    Ok((bits, levels))
}

fn refused(error: impl std::fmt::Display) -> ModelError {
    model_error!("the board refuses the reduced model: {error}")
}

fn run(
    (mesh_rad_s, whole): PoleList,
    (relaxations, symbol): &(Relaxations<ORDER>, Symbol<ORDER>),
    period_s: f64,
    samples: usize,
    mut input: impl FnMut(usize) -> f32,
) -> Difference {
    let mut state = RelaxationState::default();
    let gain: Vec<f64> = mesh_rad_s.iter().map(|&rate| mesh::gain(rate, period_s)).collect();
    let mut x = vec![0.0; gain.len()];
    let (mut energy, mut lost, mut largest) = (0.0, 0.0, 0.0_f64);
    for n in 0..samples {
        let u = input(n);
        relaxations.step(&mut state, u);
        let mut output = 0.0;
        for ((x, gain), r) in x.iter_mut().zip(&gain).zip(whole) {
            *x += gain * (f64::from(u) - *x);
            output += r * *x;
        }
        let difference = f64::from(symbol.output(&state)) - output;
        energy += output * output;
        lost += difference * difference;
        largest = largest.max(difference.abs());
    }
    let rms_share = if energy > 0.0 { (lost / energy).sqrt() } else { 0.0 };
    Difference { rms_share, largest_k_per_w: largest }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_model_loses_the_rounding_of_f32_only() {
        let rates: [f32; ORDER] = mesh::geometric(0.003, 30.0).unwrap();
        let r = [600.0, 20.0, 5.0, 2.0, 1.0, 0.5, 0.25, 0.125];
        let (wide_rates, wide_r) = (rates.map(f64::from), r.map(f64::from));
        let (bits, levels) = measure((&wide_rates, &wide_r), &rates, &r, 0.01).unwrap();
        // The states are right to 2e-7 of ±1 (tests of the core), 600 K/W of them; the bits' output
        // is some 10 K only.
        assert!(levels.rms_share < 1e-6 && bits.rms_share < 1e-4, "{bits:?} {levels:?}");
        assert!(bits.largest_k_per_w < 3e-4 && levels.largest_k_per_w < 3e-4, "{bits:?} {levels:?}");
    }

    #[test]
    fn a_tenth_too_much_is_a_tenth_lost() {
        let rates: [f32; ORDER] = mesh::geometric(0.003, 30.0).unwrap();
        let r = [600.0, 20.0, 5.0, 2.0, 1.0, 0.5, 0.25, 0.125];
        let (wide_rates, wide_r) = (rates.map(f64::from), r.map(f64::from));
        let (bits, levels) = measure((&wide_rates, &wide_r), &rates, &r.map(|r| r * 1.1), 0.01).unwrap();
        assert!((bits.rms_share - 0.1).abs() < 1e-4 && (levels.rms_share - 0.1).abs() < 1e-4);
    }
}
