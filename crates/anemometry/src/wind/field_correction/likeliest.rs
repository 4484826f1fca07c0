//! How large and quick slow errors are: by the likelihood of the equations.

use super::kind::SlowErrorKind;
use super::smoother::{SlowPrior, SlowSeries, doubt};

const OFFSETS_MW: [f64; 9] = [0.0, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0];
const GAINS_PERCENT: [f64; 8] = [0.0, 0.1, 0.3, 1.0, 2.0, 4.0, 8.0, 16.0];
const WALKS: [f64; 6] = [0.0, 0.01, 0.03, 0.1, 0.2, 0.4];
const TIMES_S: [f64; 11] = [100.0, 200.0, 400.0, 800.0, 1600.0, 3200.0, 6400.0, 12800.0, 25600.0, 51200.0, 102400.0];
const NOISES: [f64; 7] = [0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0];

/// A prior with each number in turn taken as it makes the equations likeliest.
pub fn likeliest(mut prior: SlowPrior, series: &SlowSeries<'_>, kind: SlowErrorKind) -> SlowPrior {
    let mut best = |of: &[f64], set: &dyn Fn(&mut SlowPrior, f64)| {
        let with = |&value: &f64| {
            let mut other = prior;
            set(&mut other, value);
            (other, doubt(&other, series))
        };
        if let Some((other, _)) = of.iter().map(with).min_by(|a, b| a.1.total_cmp(&b.1)) {
            prior = other;
        }
    };
    for _ in 0..2 {
        if kind != SlowErrorKind::Gains {
            best(&OFFSETS_MW, &|of, mw| of.offset_mw = mw);
            best(&TIMES_S, &|of, time_s| of.time_s = time_s);
        }
        if kind != SlowErrorKind::Offsets {
            best(&GAINS_PERCENT, &|of, percent| of.gain_percent = percent);
            best(&WALKS, &|of, walk| of.gain_walk = walk);
        }
        best(&NOISES, &|of, noise| of.noise = noise);
    }
    prior
}
