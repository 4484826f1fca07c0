use std::path::Path;
use std::time::Duration;

use super::*;
use crate::experiment::Experiment;
use crate::instrument::in_process::InProcess;
use crate::instrument::{InstrumentError, InstrumentPort, LinkReport, LockStep, Observation};
use dr_core::control::{HardwareLimits, RunState, SelfTestFinding};
use dr_core::{Command, Instrument, Reply, RunDigests};
use recording::RecordingError;
use wire::Identity;

/// A shipped experiment, shortened.
fn shortened(name: &str, from: &str, to: &str) -> Experiment {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments").join(name);
    let mut source = recording::toml_file::TomlSource::read(&path).unwrap();
    assert!(source.text.contains(from));
    source.text = source.text.replace(from, to);
    Experiment::from_source(source).unwrap()
}

fn in_process(experiment: &Experiment) -> Box<dyn InstrumentPort> {
    Box::new(LockStep::new(InProcess::new(), experiment.sensor().unwrap()))
}

#[test]
fn every_tick_becomes_a_row_and_the_same_run_twice_is_the_same() {
    let experiment = shortened("all-drives.toml", "duration_s = 120.0", "duration_s = 70.0");
    let run_once = || {
        let mut rows = 0;
        let summary = run(&experiment, in_process(&experiment), &mut |row| {
            assert_eq!(row.time_s, f64::from(rows) / 100.0);
            assert_eq!(row.event, if rows < 6000 { "breeze" } else { "gust" });
            assert_eq!(row.state, "running");
            rows += 1;
            Ok(())
        });
        assert_eq!(rows, 7000);
        summary.unwrap()
    };
    let summary = run_once();
    assert_eq!(summary, run_once());
    assert_eq!((summary.ticks, summary.lost, summary.trips.len()), (7000, 0, 0));
    assert!(summary.hash.is_some());
    // core1 is held at its high level: I²R of 16 mA between −53 and 0 °C.
    let power_w = summary.elements[4].mean_power_w;
    assert!((0.0374..0.0449).contains(&power_w), "{power_w}");
}

#[test]
fn an_open_resistor_trips_within_a_tick_and_shows_in_the_rows() {
    let fault = "\n[[faults]]\nstart_s = 1.0\nelement = \"sector3\"\nkind = \"open\"\n\n[[wind]]\nstart_s = 0.0\n";
    let experiment = shortened("steady.toml", "\n[[wind]]\nstart_s = 0.0\n", fault);
    let mut rows = Vec::new();
    let summary = run(&experiment, in_process(&experiment), &mut |row| {
        rows.push((row.state.to_owned(), row.heaters, row.temperature_c[2]));
        Ok(())
    })
    .unwrap();
    assert_eq!(summary.trips, [TripSummary { time_s: 1.01, cause: "open", element: "sector3".to_owned() }]);
    // The interval from tick 100 on is the first that flows through nothing: read at tick 101.
    assert!(rows[..101].iter().all(|(state, _, _)| state == "running"));
    assert!(
        rows[101..].iter().all(|(state, heaters, t)| state == "tripped:open:sector3" && *heaters == 0 && t.is_nan())
    );
}

#[test]
fn a_change_after_a_trip_changes_nothing() {
    let fault = "\n[[faults]]\nstart_s = 1.0\nelement = \"sector3\"\nkind = \"open\"\n\n[[wind]]\nstart_s = 0.0\n";
    let change =
        "\n[[changes]]\nstart_s = 2.0\ndrives = { sector1 = \"passive\", core2 = { temperature_c = -20.0 } }\n";
    let run_of = |text: &str| {
        let mut experiment = shortened("steady.toml", "\n[[wind]]\nstart_s = 0.0\n", text);
        experiment.ticks = 300;
        let mut rows = Vec::new();
        let summary = run(&experiment, in_process(&experiment), &mut |row| {
            rows.push((row.state.to_owned(), row.heaters));
            Ok(())
        });
        (summary.unwrap(), rows)
    };
    let (summary, rows) = run_of(&format!("{change}{fault}"));
    let (without, rows_without) = run_of(fault);
    assert_eq!(summary.trips, [TripSummary { time_s: 1.01, cause: "open", element: "sector3".to_owned() }]);
    assert_eq!((rows.len(), rows), (300, rows_without));
    assert_eq!((summary.hash, summary.unreached), (without.hash, without.unreached));
}

#[test]
fn set_points_of_changes_are_judged_and_said_to_be_missed_too() {
    let wind = "\n[[wind]]\nstart_s = 0.0\n";
    // core2 is far too cold to get to −20 °C in a second; core1 has a set-point for a while, and
    // misses it.
    let text = "\n[[changes]]\nstart_s = 1.0\ndrives = { core1 = { temperature_c = -20.0 }, core2 = { temperature_c = -20.0 } }\n\
                \n[[changes]]\nstart_s = 1.5\ndrives = { core1 = \"passive\", sector1 = \"passive\" }\n";
    let mut experiment = shortened("steady.toml", wind, &format!("{text}{wind}"));
    experiment.ticks = 200;
    let plain = shortened("steady.toml", wind, wind);
    let judged = |experiment| rehearse(experiment, None).unwrap();
    let (with, without) = (judged(&experiment), judged(&plain));
    assert_eq!(with.judged + with.unjudged, without.judged + without.unjudged + 2);
    let summary = run(&experiment, in_process(&experiment), &mut |_| Ok(())).unwrap();
    assert_eq!(summary.judgement, with);
    assert!(summary.unreached.contains(&"core1".to_owned()) && summary.unreached.contains(&"core2".to_owned()));
    assert_eq!(summary.unreached.iter().filter(|name| *name == "core1").count(), 1);
}

#[test]
fn observing_changes_no_decision_and_its_power_goes_with_the_rows() {
    let plain = shortened("gusts.toml", "duration_s = 1000.0", "duration_s = 900.0");
    let mut rows = Vec::new();
    run(&plain, in_process(&plain), &mut |row| {
        assert!(row.equivalent_power_w.is_empty());
        rows.push((row.temperature_c.to_vec(), row.heaters));
        Ok(())
    })
    .unwrap();
    let observing = shortened("gusts.toml", "duration_s = 1000.0", "observe = true\nduration_s = 900.0");
    assert_eq!(observing.observed(), [0, 1, 2, 3, 4, 5]);
    let (mut n, mut structure_w, mut mean_c) = (0, 0.0, 0.0);
    run(&observing, in_process(&observing), &mut |row| {
        assert_eq!((row.temperature_c.to_vec(), row.heaters), rows[n]);
        // the last wind
        if n >= 85_000 {
            structure_w += f64::from(row.equivalent_power_w[0]) / 5000.0;
            mean_c += f64::from(row.temperature_c[0]) / 5000.0;
        }
        n += 1;
        Ok(())
    })
    .unwrap();
    let model = observing.model(0).unwrap();
    let steady_w = (mean_c - f64::from(model.reference_c)) / f64::from(model.r_k_per_w.iter().sum::<f32>());
    println!("gusts, sector 1: the structure takes {structure_w:.5} W, at rest it would take {steady_w:.5} W");
    // Held for 800 s, twice the slowest time constant of the still gas, in whatever wind; the
    // closed loop's own are shorter.
    assert!((structure_w / steady_w - 1.0).abs() < 0.02, "{structure_w} {steady_w}");
}

#[test]
fn a_change_of_drives_begins_with_its_tick() {
    let change = "\n[[changes]]\nstart_s = 1.0\ndrives = { sector1 = \"passive\", core2 = { level = \"high\" } }\n\n[[wind]]\nstart_s = 0.0\n";
    let experiment = shortened("steady.toml", "\n[[wind]]\nstart_s = 0.0\n", change);
    let mut heaters = Vec::new();
    run(&experiment, in_process(&experiment), &mut |row| {
        heaters.push(row.heaters);
        Ok(())
    })
    .unwrap();
    // From rest far below their set-points all heat, until sector 1 is told to stop.
    assert!(heaters[..100].iter().all(|bits| *bits == 0b11_1111), "{heaters:?}");
    assert!(heaters[100..].iter().all(|bits| bits & 1 == 0 && bits >> 5 == 1));
    assert!(heaters[100..200].iter().all(|bits| *bits == 0b11_1110));
}

#[test]
fn rows_carry_the_gas_only_where_it_swings() {
    let gas = "temperature_c = -53.15";
    let run_of = |text: &str| {
        let experiment = shortened("steady.toml", gas, text);
        let experiment = Experiment { ticks: 200, ..experiment };
        let mut rows = Vec::new();
        run(&experiment, in_process(&experiment), &mut |row| {
            rows.push((row.time_s, row.gas_temperature_c));
            Ok(())
        })
        .unwrap();
        rows
    };
    assert!(run_of(gas).iter().all(|(_, gas_c)| gas_c.is_none()));
    let swing = format!("{gas}\nswing = {{ amplitude_k = 2.0, period_s = 3.0, start_s = 1.0 }}");
    for (time_s, gas_c) in run_of(&swing) {
        // A third of a turn a second from 1 s on.
        let expected = -53.15 + 2.0 * libm::sin(std::f64::consts::TAU * (time_s - 1.0).max(0.0) / 3.0);
        assert!((gas_c.unwrap() - expected).abs() < 1e-9, "{time_s} s: {gas_c:?} for {expected}");
    }
}

/// A board that grants less of the high current than its head has.
static WEAK: HardwareLimits = HardwareLimits { current_high_a: (0.01, 0.015), ..HardwareLimits::SENSOR_BOARD };

#[test]
fn currents_that_a_board_does_not_grant_are_refused_where_they_are_stated() {
    let refused = |text: &str, hardware| {
        let experiment = shortened("steady.toml", "[drives]", text);
        let mut controller = InProcess::new();
        *controller.station_mut() = Instrument::new(hardware);
        start(&experiment, &mut LockStep::new(controller, experiment.sensor().unwrap())).unwrap_err().to_string()
    };
    let stated = "[currents]\nsector3 = { low_a = 0.003, high_a = 0.0199 }\n\n[drives]";
    let sentence = refused(stated, &HardwareLimits::SENSOR_BOARD);
    let steady = include_str!("../../../experiments/steady.toml");
    let line = steady.lines().position(|line| line == "[drives]").unwrap() + 2;
    let expected = format!("line {line}: `currents.sector3` asks for what this board does not grant: ");
    assert!(sentence.contains(&expected) && !sentence.contains("sector3:"), "{sentence}");
    let sentence = refused("[drives]", &WEAK);
    assert!(sentence.contains("`head` asks for what this board does not grant: sector1: "), "{sentence}");
}

/// An instrument of which something breaks at a tick.
struct Breaking {
    inner: Box<dyn InstrumentPort>,
    tick: u32,
    how: Break,
}

enum Break {
    Link,
    /// Somebody else stops it.
    Standby,
    /// The last `Stop` is not answered.
    Stop,
}

impl InstrumentPort for Breaking {
    fn identity(&self) -> &Identity {
        self.inner.identity()
    }

    fn command(&mut self, command: Command) -> Result<Reply, InstrumentError> {
        self.inner.command(command)
    }

    fn observe(&mut self) -> Result<Observation, InstrumentError> {
        let mut observation = self.inner.observe()?;
        match self.how {
            Break::Link if observation.sample.tick == self.tick => {
                return Err(std::io::Error::other("unplugged").into());
            }
            Break::Standby if observation.sample.tick >= self.tick => observation.sample.state = RunState::Standby,
            _ => {}
        }
        Ok(observation)
    }

    fn findings(&mut self) -> Vec<SelfTestFinding> {
        Vec::new()
    }

    fn digests(&self) -> Option<RunDigests> {
        None
    }

    fn finish(self: Box<Self>) -> Result<LinkReport, InstrumentError> {
        match self.how {
            Break::Stop => Err(InstrumentError::Silent(Duration::from_secs(3))),
            _ => self.inner.finish(),
        }
    }
}

fn broken(how: Break, tick: u32) -> (u32, Result<RunSummary, RunError>) {
    let experiment = shortened("steady.toml", "duration_s = 300.0", "duration_s = 1.0");
    let instrument = Breaking { inner: in_process(&experiment), tick, how };
    let mut rows = 0;
    let ended = run(&experiment, Box::new(instrument), &mut |_| {
        rows += 1;
        Ok(())
    });
    (rows, ended)
}

#[test]
fn a_run_that_ends_early_keeps_its_rows_and_says_why() {
    for (how, rows, why) in [(Break::Link, 10, "unplugged"), (Break::Standby, 11, "another program")] {
        let (kept, summary) = broken(how, 10);
        let summary = summary.unwrap();
        let ended = summary.ended.unwrap();
        assert!(ended.why.contains(why) && ended.stopped, "{ended:?}");
        assert_eq!((kept, summary.ticks, summary.duration_s), (rows, rows, f64::from(rows) / 100.0));
    }
    let (rows, unstopped) = broken(Break::Stop, 0);
    let unstopped = unstopped.unwrap();
    assert_eq!(unstopped.duration_s, 1.0);
    let ended = unstopped.ended.unwrap();
    assert_eq!((rows, ended.stopped), (100, false));
    assert!(ended.to_string().contains("heaters may still be on"), "{ended}");
    // Without a row there is nothing to keep.
    assert!(broken(Break::Link, 0).1.unwrap_err().to_string().contains("unplugged"));
}

#[test]
fn who_asks_for_the_end_keeps_the_rows() {
    let experiment = shortened("steady.toml", "duration_s = 300.0", "duration_s = 1.0");
    let mut rows = 0;
    let summary = run(&experiment, in_process(&experiment), &mut |_| {
        rows += 1;
        if rows == 10 { Err(RunError::Interrupted) } else { Ok(()) }
    });
    let summary = summary.unwrap();
    assert_eq!((rows, summary.ticks), (10, 10));
    assert_eq!(summary.ended.unwrap().to_string(), "interrupted");
}

#[test]
fn a_recording_that_fails_ends_the_run_with_its_error() {
    let experiment = shortened("steady.toml", "duration_s = 300.0", "duration_s = 1.0");
    let full = || RecordingError::new("r.csv".as_ref(), "the disk is full");
    let error = run(&experiment, in_process(&experiment), &mut |_| Err(full().into())).unwrap_err();
    assert_eq!(error.to_string(), "r.csv: the disk is full");
}
