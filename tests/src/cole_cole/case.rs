//! Records of Cole and Cole's system, exact up to f64, and with white noise if wanted.
//!
//! The input is held over [t_n, t_{n+1}). It is piecewise constant with steps Δ_j at t_j, so that
//!
//! ```text
//! y(t_n) = Σ_{t_j ≤ t_n} Δ_j S(t_n − t_j),    S(t) = 1 − erfcx(√t)
//! ```
//!
//! Bits last a whole number of rows, so one table of S serves all the shifts.

use diffusive::random::StandardNormal;
use dr_core::signal::Prbs;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng as _;
use rand_distr::Distribution as _;
use serde::Serialize;

use super::exact::step_response;

/// 2 kHz.
pub const SAMPLE_PERIOD_S: f64 = 5e-4;

/// Rows of the whole experiment, 1000 s with both ends.
pub const ROWS: usize = 2_000_001;

/// Rows that a bit of the PRBS lasts: 1 s.
const ROWS_PER_BIT: usize = 2000;

/// Bits of the shift register, taps 10 and 7.
const PRBS_ORDER: u8 = 10;

/// Where the register starts. Its bits are used inverted, which makes an XOR register of the XNOR
/// one, and this is the start from which the first ten inverted bits are ones.
const PRBS_SEED: u32 = 0b01_1100_0111;

/// Input of the system.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ColeColeInput {
    /// 1 from the first row on.
    Step,
    /// 0 or 1, drawn anew every second.
    Prbs,
}

impl ColeColeInput {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Step => "unit step",
            Self::Prbs => "pseudo-random bits of 1 s",
        }
    }
}

/// A record from rest: row n holds y at n·Ts and u over [n, n + 1)·Ts.
#[derive(Debug, Clone, PartialEq)]
pub struct ColeColeCase {
    /// Distance of rows in time.
    pub sample_period_s: f64,
    /// Input of the system.
    pub input: Vec<f64>,
    /// The exact output.
    pub clean: Vec<f64>,
    /// The output with noise.
    pub output: Vec<f64>,
}

/// The thesis' experiment, with white Gaussian noise of standard deviation `noise_sigma` (finite,
/// at least 0) on the output, or its first `rows` rows. The same seed gives the same noise.
pub fn case(input: ColeColeInput, noise_sigma: f64, seed: u64, rows: Option<usize>) -> ColeColeCase {
    let rows = rows.unwrap_or(ROWS);
    let step: Vec<f64> = (0..rows).map(|n| step_response(n as f64 * SAMPLE_PERIOD_S)).collect();
    let (input, clean) = match input {
        ColeColeInput::Step => (vec![1.0; rows], step),
        ColeColeInput::Prbs => {
            let bits = bits(rows.div_ceil(ROWS_PER_BIT));
            let input = bits.iter().flat_map(|&bit| std::iter::repeat_n(bit, ROWS_PER_BIT)).take(rows).collect();
            (input, superposed(&bits, &step))
        }
    };
    let output = with_noise(&clean, noise_sigma, seed);
    ColeColeCase { sample_period_s: SAMPLE_PERIOD_S, input, clean, output }
}

fn bits(count: usize) -> Vec<f64> {
    let mut prbs = Prbs::new(PRBS_ORDER, PRBS_SEED).expect("order and seed are constants that fit");
    let next = || {
        // The bit is read from the register: of a choice between two constants by what `step`
        // returns, rustc 1.95 (LLVM 22.1.2) makes wrong code here from opt-level 2 on, code in
        // which no one ever enters the register.
        prbs.step();
        1.0 - f64::from(prbs.register() & 1)
    };
    std::iter::repeat_with(next).take(count).collect()
}

/// The answer to `bits` from rest, as long as the step response is.
///
/// Bit after bit, so that the rows under work stay in the cache while the shifted step responses
/// pass by.
fn superposed(bits: &[f64], step: &[f64]) -> Vec<f64> {
    let before = std::iter::once(0.0).chain(bits.iter().copied());
    let changes: Vec<f64> = bits.iter().zip(before).map(|(bit, before)| bit - before).collect();
    let mut output = vec![0.0; step.len()];
    for (at, rows) in output.chunks_mut(ROWS_PER_BIT).enumerate() {
        for (since, &change) in changes[..=at].iter().rev().enumerate().filter(|(_, change)| **change != 0.0) {
            for (y, s) in rows.iter_mut().zip(&step[since * ROWS_PER_BIT..]) {
                *y += change * s;
            }
        }
    }
    output
}

fn with_noise(clean: &[f64], sigma: f64, seed: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let noisy = clean.iter().map(|y| {
        let standard: f64 = StandardNormal.sample(&mut random);
        y + sigma * standard
    });
    noisy.collect()
}
