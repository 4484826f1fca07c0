//! Inputs of a simulated experiment: inputs of two or more levels, held for whole rows.

use dr_core::signal::Prbs;
use rand_distr::{Distribution as _, Uniform};

use super::Random;

/// Kinds of input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Excitation {
    /// A pseudo-random binary sequence of 2^20 − 1 bits, starting anywhere.
    Prbs { rows_per_bit: usize },
    /// A random telegraph: two levels, switched in every row with probability 1/`mean_rows`.
    Telegraph { mean_rows: f64 },
    /// Levels drawn evenly between the lowest and the highest, each held for `least_rows` to
    /// `most_rows`.
    Steps { least_rows: usize, most_rows: usize },
    /// The highest level from the first row on.
    Step,
}

impl Excitation {
    /// An input of that kind between `low` and `high`.
    pub fn draw(self, rows: usize, low: f64, high: f64, random: &mut Random) -> Vec<f64> {
        let level = |up: bool| if up { high } else { low };
        match self {
            Self::Prbs { rows_per_bit } => {
                // Any start but the lock-up word of ones.
                let mut prbs = Prbs::new(20, uniform(0, (1 << 20) - 2, random) as u32).expect("order and seed fit");
                let mut input = Vec::with_capacity(rows);
                while input.len() < rows {
                    prbs.step();
                    let held = rows_per_bit.min(rows - input.len());
                    input.extend(std::iter::repeat_n(level(prbs.register() & 1 == 1), held));
                }
                input
            }
            Self::Telegraph { mean_rows } => {
                let mut up = uniform(0, 1, random) == 1;
                let each = (0..rows).map(|_| {
                    let now = up;
                    up ^= fraction(random) * mean_rows < 1.0;
                    level(now)
                });
                each.collect()
            }
            Self::Steps { least_rows, most_rows } => {
                runs(rows, least_rows, most_rows, random, |random| low + (high - low) * fraction(random))
            }
            Self::Step => vec![high; rows],
        }
    }
}

/// Values that are each held for `least` to `most` rows.
pub fn runs<T: Copy>(
    rows: usize,
    least: usize,
    most: usize,
    random: &mut Random,
    mut draw: impl FnMut(&mut Random) -> T,
) -> Vec<T> {
    let mut values = Vec::with_capacity(rows);
    while values.len() < rows {
        let held = uniform(least, most, random).min(rows - values.len());
        values.extend(std::iter::repeat_n(draw(random), held));
    }
    values
}

/// A whole number from `least` to `most`, both included.
pub fn uniform(least: usize, most: usize, random: &mut Random) -> usize {
    Uniform::new_inclusive(least, most).expect("the least is not above the most").sample(random)
}

/// A number from 0 to 1, 1 excluded.
pub fn fraction(random: &mut Random) -> f64 {
    Uniform::new(0.0, 1.0).expect("0 lies below 1").sample(random)
}

#[cfg(test)]
mod tests {
    use super::super::random;
    use super::*;

    #[test]
    fn a_prbs_has_two_levels_and_the_mean_and_autocorrelation_of_its_bits() {
        let input = Excitation::Prbs { rows_per_bit: 3 }.draw(30_000, 1.0, 5.0, &mut random(3, 0));
        assert!(input.iter().all(|&u| u == 1.0 || u == 5.0));
        let bits: Vec<f64> = input.chunks(3).map(|held| (held[0] - 3.0) / 2.0).collect();
        assert!(input.chunks(3).all(|held| held.iter().all(|u| *u == held[0])));
        // Mean and correlations of 10 000 fair and independent bits have standard deviation 0.01;
        // five of them.
        assert!(bits.iter().sum::<f64>().abs() / 1e4 < 0.05);
        for lag in 1..30 {
            let sum: f64 = bits.iter().zip(&bits[lag..]).map(|(a, b)| a * b).sum();
            assert!(sum.abs() / 1e4 < 0.05, "lag {lag}: {sum}");
        }
    }

    #[test]
    fn a_telegraph_switches_as_often_as_asked_for() {
        let input = Excitation::Telegraph { mean_rows: 20.0 }.draw(100_000, 0.0, 1.0, &mut random(4, 0));
        let switched = input.windows(2).filter(|pair| pair[0] != pair[1]).count() as f64;
        // Poisson: 5000 ± √5000, five standard deviations.
        assert!((switched - 5000.0).abs() < 350.0, "{switched}");
    }

    #[test]
    fn steps_stay_between_their_levels_and_last_as_long_as_they_should() {
        let input = Excitation::Steps { least_rows: 7, most_rows: 9 }.draw(10_000, -1.0, 3.0, &mut random(5, 0));
        assert!(input.iter().all(|&u| (-1.0..3.0).contains(&u)));
        let runs: Vec<usize> = input.chunk_by(|a, b| a == b).map(<[f64]>::len).collect();
        assert!(runs[..runs.len() - 1].iter().all(|run| (7..=9).contains(run)));
        assert_eq!(input, Excitation::Steps { least_rows: 7, most_rows: 9 }.draw(10_000, -1.0, 3.0, &mut random(5, 0)));
    }
}
