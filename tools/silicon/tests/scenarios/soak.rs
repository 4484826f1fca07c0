//! A long run: no tick is late, none is lost, nobody complains.

use crate::rig::{Rig, experiment};
use dr_core::control::RunState;
use host_sim::instrument::InstrumentPort;
use host_sim::run::start;
use silicon::time::seconds;

/// Simulated seconds. `ANEMO_SOAK_S` asks for others, 86400 for a day.
const SECONDS: u32 = 60;
const HOUR_S: u32 = 3_600;

#[test]
fn a_long_run_has_no_late_tick() {
    let seconds_wanted = std::env::var("ANEMO_SOAK_S").ok().and_then(|seconds| seconds.parse().ok()).unwrap_or(SECONDS);
    let experiment = experiment("turbulence.toml", u32::MAX);
    let ticks_in = |seconds: u32| (f64::from(seconds) / experiment.sample_period_s) as u32;
    let rig = Rig::of(&experiment);
    let mut instrument = rig.instrument();
    start(&experiment, &mut instrument).unwrap();
    let (mut next, mut changes) = (0, 0);
    Rig::observe(&mut instrument, ticks_in(seconds_wanted), |sample| {
        assert_eq!((sample.tick, sample.state), (next, RunState::Running));
        next += 1;
        // A day of them would fill the memory.
        changes += rig.machine().board_mut().pins.drain(..).count();
        if next % ticks_in(HOUR_S) == 0 {
            println!("{} h", next / ticks_in(HOUR_S));
        }
    });
    let report = Box::new(instrument).finish().unwrap();
    let status = report.status.unwrap();
    println!("{:.0} s, {changes} changes of the heaters: {status:?}", seconds(rig.machine().now()));
    assert_eq!((status.unsent, status.deadlines, report.link.damaged), (0, 0, 0));
    assert_eq!(rig.machine().resets(), []);
    // Its set-up, with models, may be late once.
    assert!(status.control.late_ticks <= 1, "{}", status.control.late_ticks);
    rig.assert_no_complaint();
}
