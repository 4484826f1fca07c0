//! Which values the keys of a sweep take together: a grid, a random set or a Latin hypercube.
//!
//! A grid has every combination, the last key varying fastest. Of a random set every key is drawn
//! by itself, uniformly, or uniformly in its logarithm. A Latin hypercube of n runs parts the range
//! of every key into n intervals of equal probability and draws once in each (McKay, Beckman and
//! Conover, Technometrics 21, 1979).
//!
//! Values that are computed have six digits: they read well, and are the same on every machine.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};
use serde::Deserialize;
use toml::Value;

/// How values are combined.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum SampleSet {
    #[default]
    Grid,
    Random,
    LatinHypercube,
}

/// The values that a key may take.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Points {
    Listed(Vec<Value>),
    Between {
        low: f64,
        high: f64,
        is_log: bool,
        /// Whole numbers only.
        is_whole: bool,
        /// How many of them a grid has.
        steps: usize,
    },
}

impl Points {
    /// How many a grid has.
    pub fn count(&self) -> usize {
        match self {
            Self::Listed(values) => values.len(),
            Self::Between { steps, .. } => *steps,
        }
    }

    /// The n-th of a grid; both ends of a range belong to it.
    fn nth(&self, n: usize) -> Value {
        match self {
            Self::Listed(values) => values[n].clone(),
            Self::Between { low, high, is_log, is_whole, steps } => {
                let share = n as f64 / (steps - 1).max(1) as f64;
                number(between(*low, *high, *is_log, share), *is_whole)
            }
        }
    }

    /// The value below which this share of all lies, 0 ≤ share < 1.
    fn quantile(&self, share: f64) -> Value {
        match self {
            Self::Listed(values) => values[((share * values.len() as f64) as usize).min(values.len() - 1)].clone(),
            // Every whole number has an equal share, the last one too.
            Self::Between { low, high, is_log: false, is_whole: true, .. } => {
                number((low + share * (high - low + 1.0)).floor().min(*high), true)
            }
            Self::Between { low, high, is_log, is_whole, .. } => {
                number(between(*low, *high, *is_log, share).clamp(*low, *high), *is_whole)
            }
        }
    }
}

fn between(low: f64, high: f64, is_log: bool, share: f64) -> f64 {
    if is_log { low * (high / low).powf(share) } else { low + share * (high - low) }
}

fn number(value: f64, is_whole: bool) -> Value {
    // Twelve digits: what arithmetic adds behind them says nothing.
    let rounded = || format!("{value:.11e}").parse().unwrap_or(value);
    if is_whole { Value::Integer(value.round() as i64) } else { Value::Float(rounded()) }
}

/// The values of every run, in the order of the keys.
pub(crate) fn combinations(set: SampleSet, count: usize, seed: u64, keys: &[Points]) -> Vec<Vec<Value>> {
    if set == SampleSet::Grid {
        let runs: usize = keys.iter().map(Points::count).product();
        return (0..runs).map(|run| of_grid(run, keys)).collect();
    }
    let columns: Vec<Vec<Value>> = keys
        .iter()
        .enumerate()
        .map(|(place, points)| {
            // A stream of its own: another key more changes none of the others.
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            random.set_stream(place as u64);
            let shares = match set {
                SampleSet::LatinHypercube => strata(count, &mut random),
                _ => (0..count).map(|_| uniform(&mut random)).collect(),
            };
            shares.into_iter().map(|share| points.quantile(share)).collect()
        })
        .collect();
    (0..count).map(|run| columns.iter().map(|column| column[run].clone()).collect()).collect()
}

fn of_grid(run: usize, keys: &[Points]) -> Vec<Value> {
    let mut rest = run;
    let mut values: Vec<Value> = Vec::with_capacity(keys.len());
    for points in keys.iter().rev() {
        values.push(points.nth(rest % points.count()));
        rest /= points.count();
    }
    values.reverse();
    values
}

/// One share in every n-th, in random order.
fn strata(count: usize, random: &mut ChaCha8Rng) -> Vec<f64> {
    let mut shares: Vec<f64> = (0..count).map(|n| (n as f64 + uniform(random)) / count as f64).collect();
    for last in (1..count).rev() {
        let other = (uniform(random) * (last + 1) as f64) as usize;
        shares.swap(last, other.min(last));
    }
    shares
}

/// Uniform in [0, 1), of 53 bits.
fn uniform(random: &mut ChaCha8Rng) -> f64 {
    (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn range(low: f64, high: f64, is_log: bool, is_whole: bool, steps: usize) -> Points {
        Points::Between { low, high, is_log, is_whole, steps }
    }

    fn listed(words: &[&str]) -> Points {
        Points::Listed(words.iter().map(|&word| Value::from(word)).collect())
    }

    fn floats(runs: &[Vec<Value>], key: usize) -> Vec<f64> {
        runs.iter().map(|values| values[key].as_float().unwrap()).collect()
    }

    #[test]
    fn a_grid_has_every_combination_and_the_ends_of_its_ranges() {
        let keys = [listed(&["a", "b"]), range(0.01, 100.0, true, false, 5)];
        let runs = combinations(SampleSet::Grid, 0, 0, &keys);
        assert_eq!(runs.len(), 10);
        assert_eq!(floats(&runs[..5], 1), [0.01, 0.1, 1.0, 10.0, 100.0]);
        let words: Vec<&str> = runs.iter().map(|values| values[0].as_str().unwrap()).collect();
        assert_eq!(words, ["a", "a", "a", "a", "a", "b", "b", "b", "b", "b"]);
    }

    #[test]
    fn a_latin_hypercube_is_once_in_every_interval_of_every_key() {
        let keys = [range(0.0, 1.0, false, false, 0), range(1.0, 1e4, true, false, 0), listed(&["a", "b", "c", "d"])];
        let runs = combinations(SampleSet::LatinHypercube, 100, 7, &keys);
        let mut linear: Vec<usize> = floats(&runs, 0).iter().map(|value| (value * 100.0) as usize).collect();
        let mut log: Vec<usize> = floats(&runs, 1).iter().map(|value| (value.log10() * 25.0) as usize).collect();
        assert_ne!(linear, log, "the keys go together");
        linear.sort_unstable();
        log.sort_unstable();
        let each: Vec<usize> = (0..100).collect();
        assert_eq!((linear, log), (each.clone(), each));
        let a = runs.iter().filter(|values| values[2].as_str() == Some("a")).count();
        assert_eq!(a, 25);
    }

    #[test]
    fn values_of_a_narrow_range_far_from_zero_stay_in_it_and_differ() {
        for set in [SampleSet::Random, SampleSet::LatinHypercube] {
            let runs = combinations(set, 50, 1, &[range(101_325.4, 101_325.6, false, false, 0)]);
            let mut values = floats(&runs, 0);
            assert!(values.iter().all(|value| (101_325.4..=101_325.6).contains(value)), "{values:?}");
            values.sort_by(f64::total_cmp);
            values.dedup();
            assert_eq!(values.len(), 50);
        }
    }

    #[test]
    fn a_random_set_is_the_same_again_and_another_key_leaves_it_alone() {
        let (one, two) = (range(-1.0, 1.0, false, false, 0), range(0.0, 3.0, false, true, 0));
        let alone = combinations(SampleSet::Random, 4000, 3, std::slice::from_ref(&one));
        let both = combinations(SampleSet::Random, 4000, 3, &[one.clone(), two]);
        assert_eq!(floats(&alone, 0), floats(&both, 0));
        assert_ne!(floats(&alone, 0), floats(&combinations(SampleSet::Random, 4000, 4, &[one]), 0));
        // Mean of 4000 uniform numbers in (−1, 1): 0 ± 0.0091, here within five of these.
        let mean = floats(&alone, 0).iter().sum::<f64>() / 4000.0;
        assert!(mean.abs() < 0.046, "{mean}");
        // Binomial, 1000 ± 27: within five.
        for whole in 0..4 {
            let count = both.iter().filter(|values| values[1].as_integer() == Some(whole)).count();
            assert!((863..1137).contains(&count), "{whole}: {count}");
        }
    }
}
