//! Ticks of all lengths: none is late.

use crate::rig::{Rig, experiment};
use dr_core::control::RunState;
use host_sim::experiment::Experiment;
use host_sim::instrument::InstrumentPort;
use host_sim::run::start;
use silicon::time::us;

/// Runs so many ticks of a shipped experiment whose sample period is another, in µs; returns how
/// many ticks came late.
fn late_ticks(tick_us: u64, ticks: u32) -> u32 {
    let experiment = Experiment { sample_period_s: tick_us as f64 * 1e-6, ..experiment("held.toml", ticks) };
    let rig = Rig::of(&experiment);
    let mut instrument = rig.instrument();
    start(&experiment, &mut instrument).unwrap();
    let begin = rig.machine().now();
    let mut samples = Vec::new();
    Rig::observe(&mut instrument, ticks, |sample| samples.push((sample.tick, sample.state)));
    assert!(samples.iter().map(|sample| sample.0).eq(0..ticks), "none is lost");
    assert!(samples.iter().all(|sample| sample.1 == RunState::Running));
    // A tick has its length by the converter's clock, to the time that a frame takes to the host.
    let took = rig.machine().now() - begin;
    let expected = u64::from(ticks) * us(tick_us);
    assert!(took.abs_diff(expected) < us(tick_us) + us(5_000), "{took} for {expected}");
    let report = Box::new(instrument).finish().unwrap();
    rig.assert_no_complaint();
    let status = report.status.unwrap();
    assert_eq!((status.unsent, status.deadlines), (0, 0));
    status.control.late_ticks
}

#[test]
fn ticks_of_a_millisecond_are_in_time() {
    assert_eq!(late_ticks(1_000, 1_000), 0);
}

#[test]
fn ticks_of_two_milliseconds_are_in_time() {
    assert_eq!(late_ticks(2_000, 500), 0);
}

#[test]
fn ticks_of_ten_milliseconds_are_in_time() {
    assert_eq!(late_ticks(10_000, 100), 0);
}

#[test]
fn ticks_of_a_tenth_of_a_second_are_in_time() {
    assert_eq!(late_ticks(100_000, 20), 0);
}
