//! The wind of a calibrated head, estimated in every tick: the decision does not wait for it.

use crate::rig::Rig;
use dr_core::control::RunState;
use host_sim::experiment::Experiment;
use host_sim::instrument::InstrumentPort;
use host_sim::run::start;
use std::path::Path;
use wire::{MAX_FRAME, Status, ToBoard, encode};

/// Simulated seconds. `ANEMO_SOAK_S` asks for others: an hour at 10 ms, ten minutes at 1 ms.
const SECONDS: [f64; 2] = [6.0, 2.0];
/// What the decision may take of a conversion, µs.
const EDGE_TO_PINS_US: u32 = 200;

/// Sphere B with the calibration of one that has a reference, which is one element more than this
/// board has, in turbulence, with an estimate in every tick.
pub fn experiment(sample_period_s: f64) -> Experiment {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let text = |name: &str| std::fs::read_to_string(root.join(name)).unwrap();
    let calibrated = text("tests/fixtures/sphere-b-calibrated.toml");
    let (_, calibration) = calibrated.split_once("[calibration]").unwrap();
    let calibration = calibration.replacen("reference = \"reference\"\n", "", 1);
    let head = format!("{}\n[calibration]{calibration}", text("heads/sphere-b.toml"));
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("head.toml"), head).unwrap();
    let mut text = text("experiments/wind/sphere-b/turbulence.toml");
    for (from, to) in [
        ("../../../heads/sphere-b-reference.toml", "head.toml".to_owned()),
        ("sample_period_s = 0.001", format!("sample_period_s = {sample_period_s}")),
        ("start_s = 150.0", "start_s = 1.0".to_owned()),
        ("[[wind]]", format!("[wind_output]\ninterval_s = {sample_period_s}\n\n[[wind]]")),
    ] {
        assert!(text.contains(from), "{from}");
        text = text.replacen(from, &to, 1);
    }
    let path = folder.path().join("experiment.toml");
    std::fs::write(&path, text).unwrap();
    Experiment { ticks: u32::MAX, ..Experiment::read(&path).unwrap() }
}

/// Messages that find the queue full before the board has the request for fewer.
const LOST_AT_START: u32 = 2;

/// Runs for so many seconds with a sample and an estimate every so many ticks; returns the status
/// of the end.
fn status_after(sample_period_s: f64, telemetry_every: u16, seconds: f64) -> Status {
    let experiment = experiment(sample_period_s);
    let rig = Rig::of(&experiment);
    let mut instrument = rig.instrument();
    start(&experiment, &mut instrument).unwrap();
    let request = ToBoard::Telemetry { every: telemetry_every };
    let mut buffer = [0; MAX_FRAME];
    rig.machine().board_mut().receive(encode(60_000, &request, &mut buffer).unwrap());
    let last = (seconds / sample_period_s) as u32;
    let (mut estimates, mut samples) = (0, 0);
    loop {
        let seen = instrument.observe().unwrap();
        assert_eq!(seen.sample.state, RunState::Running);
        // Others were sent before the board had the request.
        if seen.sample.tick.is_multiple_of(u32::from(telemetry_every)) {
            samples += 1;
            estimates += u32::from(seen.wind.is_some());
        }
        rig.machine().board_mut().pins.clear();
        if seen.sample.tick >= last {
            break;
        }
    }
    assert!(samples >= last / u32::from(telemetry_every), "{samples}");
    assert_eq!(estimates, samples, "each sample has its estimate");
    let report = Box::new(instrument).finish().unwrap();
    rig.assert_no_complaint();
    println!("{sample_period_s} s, {samples} samples: {:?}, {:?}", report.link, report.status);
    let status = report.status.unwrap();
    // At a millisecond the line has no room for all samples and estimates; until the board has the
    // request they fill its queue. What does not fit is counted.
    let most = if sample_period_s < 0.002 { LOST_AT_START } else { 0 };
    assert_eq!((report.link.lost, report.link.damaged), (status.unsent, 0));
    assert!(status.unsent <= most, "{} unsent", status.unsent);
    status
}

#[test]
fn ticks_with_the_wind_of_a_calibrated_head_are_in_time() {
    let seconds = std::env::var("ANEMO_SOAK_S").ok().and_then(|seconds| seconds.parse().ok());
    // Of two in a row at a millisecond the line has no room for all samples.
    for ((sample_period_s, every), usual_s) in [(0.01, 1), (0.001, 10)].into_iter().zip(SECONDS) {
        let status = status_after(sample_period_s, every, seconds.unwrap_or(usual_s));
        assert_eq!((status.control.late_ticks, status.control.missed_estimates), (0, 0), "{sample_period_s} s");
        assert_eq!((status.deadlines, status.control.lost_conversions), (0, 0));
        let took_us = status.control.edge_to_pins_us;
        assert!((1..=EDGE_TO_PINS_US).contains(&took_us), "{took_us} µs");
    }
}
