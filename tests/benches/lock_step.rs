//! Speed of runs: in process, and exchanges with the emulated board over both links.
//!
//! `cargo bench -p anemo-tests` after `cargo xtask size` (which builds the firmware). Elements a
//! second are ticks a second. Machines differ and are shared: compare figures of one run.

use anemo_tests::{experiment, firmware, in_process, readings, sensor, start, started};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use host_sim::instrument::InstrumentPort;
use host_sim::instrument::emulated::{Emulated, EmulatorLink as Way};

fn lock_step(criterion: &mut Criterion) {
    let experiment = experiment("gusts.toml");
    let mut group = criterion.benchmark_group("ticks");
    group.throughput(Throughput::Elements(1));

    let mut host = in_process(&experiment);
    start(&experiment, &mut *host);
    group.bench_function("in process: controller and simulated sensor", |b| b.iter(|| host.observe()));

    for (name, way) in [("fast link", Way::Fifo), ("USART", Way::Usart)] {
        let mut board = started(&experiment, Emulated::start(&firmware(), way).expect("the emulated board starts"));
        group.bench_function(format!("{name}: exchange with sample"), |b| b.iter(|| board.observe()));
    }
    for (name, way) in [("fast link", Way::Fifo), ("USART", Way::Usart)] {
        let mut board = started(&experiment, Emulated::start(&firmware(), way).expect("the emulated board starts"));
        board.body_mut().without_samples().expect("the board listens");
        // Readings of a few ticks, over and over: the exchange is what is measured, not the sensor.
        let mut sensor = sensor(&experiment);
        let readings: Vec<_> = (0..64).map(|_| (readings(&sensor), sensor.advance(0)).0).collect();
        let mut turn = readings.iter().cycle();
        group.bench_function(format!("{name}: exchange of readings, levels and digest"), |b| {
            b.iter(|| turn.next().map(|readings| board.body_mut().exchange_levels(readings)));
        });
    }
    group.finish();
}

criterion_group!(benches, lock_step);
criterion_main!(benches);
