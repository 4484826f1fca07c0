//! A sensor that breaks: heaters low within one tick, latched, on host and board alike.

use anemo_tests::{changed, emulated, in_process, start};
use dr_core::Command;
use dr_core::control::{Cause, Heaters, Refusal, RunState, Trip};
use host_sim::instrument::emulated::EmulatorLink as Way;
use host_sim::instrument::{InstrumentError, InstrumentPort};

const FAULT_TICK: u32 = 300;

/// Breaks element 2 of the gusts experiment after 3 s, and says what came of it.
fn broken(kind: &str, on_board: bool) -> Trip {
    let fault = format!("[[faults]]\nstart_s = 3.0\nelement = \"sector3\"\nkind = \"{kind}\"\n\n[[wind]]");
    let experiment = changed("gusts.toml", &[("[[wind]]", &fault)]);
    let mut instrument: Box<dyn InstrumentPort> =
        if on_board { emulated(&experiment, Way::Fifo) } else { in_process(&experiment) };
    start(&experiment, &mut *instrument);
    let mut tripped = None;
    for tick in 0..FAULT_TICK + 200 {
        let sample = instrument.observe().unwrap().sample;
        match sample.state {
            RunState::Tripped(trip) => {
                assert_eq!(sample.heaters, Heaters(0), "{kind}: a heater is on in a trip, tick {tick}");
                let (first, _) = *tripped.get_or_insert((tick, trip));
                // The interval that begins at the fault's tick is the first that is broken: read
                // one tick later.
                assert_eq!(first, FAULT_TICK + 1, "{kind}");
            }
            state => assert!(tripped.is_none(), "{kind}: {state:?} after a trip"),
        }
    }
    let refusal = instrument.command(Command::Start).unwrap_err();
    assert!(matches!(refusal, InstrumentError::Refused(Refusal::Tripped(_))), "{refusal}");
    // Acknowledged it is in standby; the fault is still there and trips it again, without a run.
    instrument.command(Command::Acknowledge).unwrap();
    assert!(matches!(instrument.observe().unwrap().sample.state, RunState::Tripped(_)));
    tripped.expect("it has tripped").1
}

#[test]
fn an_open_or_shorted_resistor_trips_within_a_tick_on_both_bodies() {
    for (kind, cause) in [("open", Cause::Open), ("shorted", Cause::Short)] {
        for on_board in [false, true] {
            assert_eq!(broken(kind, on_board), Trip::of(2, cause));
        }
    }
}

#[test]
fn an_element_that_gets_too_hot_trips_within_a_tick_on_both_bodies() {
    // The limit is set into the warm-up, which is what an element does that has lost its cooling.
    let limits = ("temperature_max_c = 70.0", "temperature_max_c = -30.0");
    for on_board in [false, true] {
        let head = std::fs::read_to_string(anemo_tests::file("heads/sphere-b.toml")).unwrap();
        assert!(head.contains(limits.0));
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("head.toml"), head.replace(limits.0, limits.1)).unwrap();
        let head = format!("head = \"{}\"", folder.path().join("head.toml").display());
        let level = "sector1 = { level = \"high\" }";
        let experiment = changed(
            "steady.toml",
            &[
                ("head = \"../heads/sphere-b.toml\"", &head),
                ("sector1 = { temperature_c = -23.15 }", level),
                (
                    "sector2 = { temperature_c = -23.15 }\nsector3 = { temperature_c = -23.15 }\nsector4 = { temperature_c = -23.15 }\ncore1 = { temperature_c = -23.15 }\ncore2 = { temperature_c = -23.15 }\n",
                    "",
                ),
            ],
        );
        let mut instrument: Box<dyn InstrumentPort> =
            if on_board { emulated(&experiment, Way::Fifo) } else { in_process(&experiment) };
        start(&experiment, &mut *instrument);
        let mut before_c = f32::MIN;
        loop {
            let sample = instrument.observe().unwrap().sample;
            if let RunState::Tripped(trip) = sample.state {
                assert_eq!(trip, Trip::of(0, Cause::OverTemperature));
                assert_eq!(sample.heaters, Heaters(0));
                break;
            }
            assert!(sample.tick < 20_000, "it never got hot: {} °C", sample.temperature_c[0]);
            before_c = sample.temperature_c[0];
        }
        assert!((-30.5..=-30.0).contains(&before_c), "the tick before the trip was at {before_c} °C");
    }
}
