//! A long run: no tick is late, none is lost, nobody complains.

use crate::rig::{Rig, experiment};
use dr_core::control::RunState;
use host_sim::instrument::InstrumentPort;
use host_sim::run::start;

/// Simulated seconds; `ANEMO_SOAK_S` asks for others.
const SECONDS: u32 = 30;

#[test]
fn a_long_run_has_no_late_tick() {
    let seconds = std::env::var("ANEMO_SOAK_S").ok().and_then(|seconds| seconds.parse().ok()).unwrap_or(SECONDS);
    let experiment = experiment("turbulence.toml", u32::MAX);
    let ticks = (f64::from(seconds) / experiment.sample_period_s) as u32;
    let rig = Rig::of(&experiment);
    let mut instrument = rig.instrument();
    start(&experiment, &mut instrument).unwrap();
    let mut next = 0;
    Rig::observe(&mut instrument, ticks, |sample| {
        assert_eq!((sample.tick, sample.state), (next, RunState::Running));
        next += 1;
    });
    let report = Box::new(instrument).finish().unwrap();
    let status = report.status.unwrap();
    println!("{seconds} s: {status:?}");
    assert_eq!((status.unsent, status.deadlines, report.link.damaged), (0, 0, 0));
    assert_eq!(rig.machine().resets(), []);
    // Its set-up, with models, may be late once.
    assert!(status.late_ticks <= 1, "{}", status.late_ticks);
}
