//! Speed of a closed loop's prediction: an hour at 100 Hz with a hundred changes of the wind, K =
//! 8.
//!
//! `cargo bench -p anemo-tests --bench predict`. Both predictions are in it: the limit, and the
//! one-bit rule.

use std::time::Duration;

use anemo_tests::loops::{scenario, symbol_model};
use criterion::{Criterion, criterion_group, criterion_main};
use diffusive::predict::closed::{LoopStart, predict};

fn an_hour(criterion: &mut Criterion) {
    let winds = (0..100).map(|n| (n * 3600, [0, 2, 1, 0, 1, 2][n % 6])).collect();
    let (model, scenario) = (symbol_model(), scenario(34.0, winds, 360_000));
    let mut group = criterion.benchmark_group("closed loop");
    group.sample_size(20).measurement_time(Duration::from_secs(3));
    group.bench_function("1 h at 100 Hz, 100 winds, K = 8", |b| b.iter(|| predict(&model, &scenario, LoopStart::Rest)));
    group.finish();
}

criterion_group!(benches, an_hour);
criterion_main!(benches);
