//! Speed of identification: states, normal equations and solution, and how that grows with every
//! size.
//!
//! `cargo bench -p anemo-tests --bench identify`. Elements a second are rows a second. Machines
//! differ and are shared: compare figures of one run; `limits` stand beside them for that.

use std::time::Duration;

use anemo_tests::records::rod::Rod;
use anemo_tests::speed::{bytes_a_second, design, flops_a_row, flops_a_second, record, solve};
use anemo_tests::winds::{self, options, run};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use diffusive::identify::Constraints;
use diffusive::identify::record::RecordTable;
use diffusive::identify::{GasGiven, IdentifyOptions, identify};

const ROWS: usize = 2_000_000;

/// Rows for the sizes that are tried at a fixed length.
const FEWER_ROWS: usize = 200_000;

/// Rows of a record in winds: 50 min at 20 Hz.
const WIND_ROWS: usize = 60_000;

fn everything(criterion: &mut Criterion) {
    eprintln!("limits: {:.1} Gflop/s, {:.1} GB/s on one core", flops_a_second() / 1e9, bytes_a_second() / 1e9);
    let mut group = criterion.benchmark_group("identify");
    group.sample_size(10).warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(1));
    let mut one = |name: &str, size: usize, table: &mut RecordTable, order: usize, inputs: usize, classes: usize| {
        let (design, rows) = (design(order, inputs, classes), table_rows(table));
        eprintln!("{name} {size}: {} flop a row", flops_a_row(&design));
        group.throughput(Throughput::Elements(rows));
        group.bench_function(BenchmarkId::new(name, size), |b| b.iter(|| solve(table, &design)));
    };
    for rows in [10_000, 100_000, 1_000_000, ROWS, 10_000_000] {
        one("rows, K = 8", rows, &mut record(rows, 1, 1), 8, 1, 1);
    }
    let mut table = record(FEWER_ROWS, 1, 1);
    for order in [2, 4, 8, 16, 32] {
        one("rates", order, &mut table, order, 1, 1);
    }
    for classes in [1, 2, 4, 8] {
        one("classes, K = 8", classes, &mut record(FEWER_ROWS, 1, classes), 8, 1, classes);
    }
    for inputs in [1, 2, 4, 8] {
        one("inputs, K = 8", inputs, &mut record(FEWER_ROWS, inputs, 1), 8, inputs, 1);
    }
    group.finish();

    let mut group = criterion.benchmark_group("all choices made by cross-validation");
    group.sample_size(10).warm_up_time(Duration::from_millis(1)).measurement_time(Duration::from_secs(1));
    let mut table = record(FEWER_ROWS, 1, 1);
    group.throughput(Throughput::Elements(FEWER_ROWS as u64));
    group.bench_function(BenchmarkId::new("rows", FEWER_ROWS), |b| {
        b.iter(|| identify(&mut table, &IdentifyOptions::default(), &mut |_, _, _| {}, &mut |_| {}));
    });
    group.finish();

    // A head on a rod in three winds; from one reading of the record to the last residual.
    let mut group = criterion.benchmark_group("wind as feedback, K = 14, 3 classes");
    group.sample_size(10).warm_up_time(Duration::from_millis(1)).measurement_time(Duration::from_secs(1));
    let mut winds = winds::table(&Rod { rows: WIND_ROWS, ..Rod::default() }.simulate());
    let given = Constraints { order: Some(14), ..Constraints::default() };
    group.throughput(Throughput::Elements(WIND_ROWS as u64));
    let ways = [
        ("gas constant", GasGiven::ConstantC(18.0)),
        ("gas in a column", GasGiven::Column),
        ("gas unknown", GasGiven::Unknown),
    ];
    for (name, gas) in ways {
        let options = IdentifyOptions { constraints: given.clone(), ..options(gas) };
        group.bench_function(BenchmarkId::new(name, WIND_ROWS), |b| b.iter(|| run(&mut winds, &options)));
    }
    group.finish();
}

fn table_rows(table: &RecordTable) -> u64 {
    use diffusive::identify::record::RecordSource as _;
    table.survey().rows
}

criterion_group!(benches, everything);
criterion_main!(benches);
