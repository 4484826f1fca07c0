//! The command and a board at a serial port: what gets lost is repeated or counted, and whatever
//! breaks is one sentence.

use anemo_tests::Desk;
use anemo_tests::fake_board::{FakeBoard, Quirks, Report};
use dr_core::Command;
use dr_core::control::RunState;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use recording::Recording;
use serde_json::Value;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// Four seconds of all drives.
fn desk() -> Desk {
    Desk::new("all-drives.toml", &[("duration_s = 120.0", "duration_s = 4.0"), ("start_s = 60.0", "start_s = 2.0")])
}

const TICKS: u32 = 400;

/// A run on a board with quirks, recorded: the JSON summary, the recording, and what the board
/// says.
fn run(quirks: Quirks) -> (Value, Recording, Report) {
    let desk = desk();
    let board = FakeBoard::new(&desk.experiment(), quirks);
    let on = format!("serial:{}", board.device);
    let output = desk.anemo(&["run", "e.toml", "--on", &on, "-o", "r.csv", "--json"], &[]);
    assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
    assert_eq!(desk.files(), ["e.toml", "r.csv"]);
    let recording = Recording::read(&desk.path().join("r.csv")).unwrap();
    (serde_json::from_slice(&output.stdout).unwrap(), recording, board.finish())
}

/// The run that fails: the sentence, and how long it took.
fn fails(quirks: Quirks) -> (String, f64) {
    let desk = desk();
    let board = FakeBoard::new(&desk.experiment(), quirks);
    let begin = Instant::now();
    let on = format!("serial:{}", board.device);
    let (code, sentence) = desk.refused(&["run", "e.toml", "--on", &on, "-o", "r.parquet", "--plot", "p.svg"], &[]);
    assert_eq!(code, 1, "{sentence}");
    println!("{:.1} s  {sentence}", begin.elapsed().as_secs_f64());
    board.finish();
    (sentence, begin.elapsed().as_secs_f64())
}

/// The run that ends early: the sentence, how long it took, and what was recorded, which is the
/// simulated run up to the end.
fn ends_early(quirks: Quirks) -> (String, f64, Recording) {
    let desk = desk();
    let board = FakeBoard::new(&desk.experiment(), quirks);
    let begin = Instant::now();
    let on = format!("serial:{}", board.device);
    let output = desk.anemo(&["run", "e.toml", "--on", &on, "-o", "r.csv", "--plot", "p.svg"], &[]);
    let sentence = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(4), "{sentence}");
    assert_eq!(sentence.lines().count(), 1, "{sentence}");
    assert_eq!(desk.files(), ["e.toml", "p.svg", "r.csv"]);
    let seconds = begin.elapsed().as_secs_f64();
    board.finish();
    let recording = Recording::read(&desk.path().join("r.csv")).unwrap();
    assert_same(&recording, &simulated());
    assert_eq!(recording.metadata("complete"), Some("false"));
    let why = sentence.trim_end().strip_prefix("anemo: the run ended early: ").unwrap().to_owned();
    assert_eq!(recording.metadata("ended"), Some(why.as_str()));
    (why, seconds, recording)
}

/// Sentence where nobody knows whether the heaters are low.
const NOT_STOPPED: &str = "; its `Stop` was not confirmed, so heaters may still be on: switch its supply off";

/// The same experiment on the simulated instrument.
fn simulated() -> Recording {
    let desk = desk();
    assert!(desk.anemo(&["run", "e.toml", "--on", "sim", "-o", "r.csv"], &[]).status.success());
    Recording::read(&desk.path().join("r.csv")).unwrap()
}

/// Every row that is there holds what the simulated run has at that time.
fn assert_same(recording: &Recording, expected: &Recording) {
    let names = ["sector1", "sector2", "sector3", "sector4", "core1", "core2"];
    let ticks = |recording: &Recording| -> Vec<usize> {
        recording.numbers("time_s").unwrap().iter().map(|time_s| (time_s * 100.0).round() as usize).collect()
    };
    assert_eq!(ticks(expected), (0..TICKS as usize).collect::<Vec<_>>());
    for quantity in ["temperature_c", "power_w", "heater"] {
        for name in names {
            let column = format!("{quantity}_{name}");
            let (seen, expected) = (recording.numbers(&column).unwrap(), expected.numbers(&column).unwrap());
            let there: Vec<f64> = ticks(recording).iter().map(|&tick| expected[tick]).collect();
            assert_eq!(*seen, there, "{column}");
        }
    }
}

#[test]
fn a_run_over_the_cable_is_the_simulated_run() {
    let (summary, recording, report) = run(Quirks::default());
    assert_eq!((&summary["ticks"], &summary["lost"], &summary["damaged"]), (&TICKS.into(), &0.into(), &0.into()));
    assert_eq!((&summary["judged"], &summary["unjudged"]), (&2.into(), &0.into()));
    assert_eq!(summary["firmware"], "fake board");
    assert!(summary["hash"].is_null(), "a cable does not show every state");
    assert_same(&recording, &simulated());
    assert!(recording.numbers("true_wind_x_m_s").is_err(), "nobody knows the wind around a real sensor");
    // Stopped at the end, and nothing said twice.
    assert_eq!((report.state, report.obeyed.last()), (RunState::Standby, Some(&Command::Stop)));
    assert_eq!((report.link.lost, report.link.repeated, report.link.damaged), (0, 0, 0));
}

#[test]
fn lost_samples_are_counted_and_leave_gaps() {
    let (summary, recording, _) =
        run(Quirks { lost_samples: vec![0, 17, 18, 19, 200, TICKS - 1], ..Quirks::default() });
    assert_eq!((&summary["ticks"], &summary["lost"]), (&(TICKS - 6).into(), &6.into()));
    assert_eq!(recording.metadata("lost"), Some("6"));
    assert_eq!(recording.len(), TICKS as usize - 6);
    assert_same(&recording, &simulated());
}

#[test]
fn garbage_on_the_cable_costs_what_it_hits_and_no_more() {
    let ended = (0..60).map(|i| i * 37 % 255 + 1).chain([0]).collect();
    let open = vec![0x55; 9];
    let long = [vec![0xaa; 1000], vec![0]].concat();
    let (summary, recording, _) =
        run(Quirks { garbage: vec![(10, ended), (100, open), (150, long)], ..Quirks::default() });
    // Garbage with an end of its own costs nothing but itself; without, it takes the sample behind
    // it along.
    assert_eq!((&summary["lost"], &summary["damaged"]), (&1.into(), &3.into()));
    assert_same(&recording, &simulated());
}

#[test]
fn a_command_that_gets_lost_is_sent_again() {
    for kind in [(|command| matches!(command, Command::Model { element: 3, .. })) as fn(&Command) -> bool, |command| {
        matches!(command, Command::Start)
    }] {
        let (summary, recording, report) = run(Quirks { lost_command: Some(kind), ..Quirks::default() });
        assert_eq!((&summary["ticks"], &summary["lost"]), (&TICKS.into(), &0.into()));
        assert_eq!(report.obeyed.iter().filter(|command| kind(command)).count(), 1);
        assert_eq!(report.link.lost, 1);
        assert_same(&recording, &simulated());
    }
}

#[test]
fn a_reply_that_gets_lost_does_no_harm() {
    let (summary, recording, _) =
        run(Quirks { lost_reply: Some(|command| matches!(command, Command::Clear)), ..Quirks::default() });
    assert_eq!((&summary["ticks"], &summary["lost"]), (&TICKS.into(), &0.into()));
    assert_same(&recording, &simulated());
}

#[test]
fn a_start_whose_reply_gets_lost_is_carried_out_once_and_no_tick_is_missed() {
    let is_start: fn(&Command) -> bool = |command| matches!(command, Command::Start);
    let (summary, recording, report) = run(Quirks { lost_reply: Some(is_start), ..Quirks::default() });
    assert_eq!((&summary["ticks"], &summary["lost"]), (&TICKS.into(), &0.into()));
    assert_eq!((&summary["judged"], &summary["unjudged"]), (&2.into(), &0.into()));
    assert_eq!(report.obeyed.iter().filter(|command| is_start(command)).count(), 1);
    assert_same(&recording, &simulated());
}

#[test]
fn a_trip_is_recorded_and_kept_until_it_is_acknowledged() {
    let fault = "[[faults]]\nstart_s = 1.0\nelement = \"sector3\"\nkind = \"open\"\n\n[[wind]]";
    let desk = Desk::new(
        "all-drives.toml",
        &[("duration_s = 120.0", "duration_s = 2.0"), ("[[wind]]", fault), ("start_s = 60.0", "start_s = 1.5")],
    );
    let board = FakeBoard::new(&desk.experiment(), Quirks::default());
    let on = format!("serial:{}", board.device);
    let run = ["run", "e.toml", "--on", &on, "--json"];
    let again = ["run", "e.toml", "--on", &on, "--json", "--acknowledge"];

    let output = desk.anemo(&run, &[]);
    assert_eq!(output.status.code(), Some(3), "{output:?}");
    assert_eq!(String::from_utf8_lossy(&output.stderr), "anemo: the run tripped at 1.01 s: open, sector3\n");
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(summary["trips"][0]["cause"], "open");
    assert_eq!(summary["trips"][0]["element"], "sector3");
    assert_eq!(summary["trips"][0]["time_s"], 1.01);

    // Plain, acknowledged while the resistor is still open, and acknowledged when that has been
    // mended.
    for arguments in [run.as_slice(), &again] {
        let (code, sentence) = desk.refused(arguments, &[]);
        assert_eq!(code, 1);
        let expected = "the board is tripped (open, sector3) and keeps its heaters low; mend the cause, then run again with --acknowledge";
        assert_eq!(sentence, expected);
    }
    board.mend();
    let output = desk.anemo(&again, &[]);
    assert!(output.status.success(), "{output:?}");
    assert_eq!(serde_json::from_slice::<Value>(&output.stdout).unwrap()["trips"], Value::Array(Vec::new()));
    // There being nothing to acknowledge is no error.
    assert!(desk.anemo(&again, &[]).status.success());
    assert_eq!(board.finish().state, RunState::Standby);
}

#[test]
fn an_interrupted_run_stops_the_heaters_and_keeps_what_it_has() {
    for signal in [Signal::SIGINT, Signal::SIGTERM, Signal::SIGHUP] {
        let desk = Desk::new("all-drives.toml", &[]);
        let board = FakeBoard::new(&desk.experiment(), Quirks::default());
        let on = format!("serial:{}", board.device);
        let mut run = desk.command(&["run", "e.toml", "--on", &on, "-o", "r.csv", "--json"], &[]);
        let run = run.stderr(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        while !board.is_running() {
            std::thread::sleep(Duration::from_millis(10));
        }
        kill(Pid::from_raw(run.id().try_into().unwrap()), signal).unwrap();
        let output = run.wait_with_output().unwrap();
        let sentence = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(4), "{sentence}");
        assert_eq!(sentence, "anemo: the run ended early: interrupted\n");
        let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(summary["ended"]["stopped"], true);
        assert_eq!(desk.files(), ["e.toml", "r.csv"]);
        let recording = Recording::read(&desk.path().join("r.csv")).unwrap();
        assert_eq!((&summary["ticks"], recording.metadata("complete")), (&recording.len().into(), Some("false")));
        assert_eq!(board.finish().state, RunState::Standby);
    }
}

/// Rows that had arrived half a second before are there, whether or not anything could be tidied
/// up.
#[test]
fn a_killed_run_leaves_what_it_has_recorded() {
    for (name, journal) in [("r.parquet", "r.parquet.journal"), ("folder", "folder/recording.journal")] {
        let desk = Desk::new("all-drives.toml", &[]);
        let board = FakeBoard::new(&desk.experiment(), Quirks::default());
        let on = format!("serial:{}", board.device);
        let mut run =
            desk.command(&["run", "e.toml", "--on", &on, "-o", name, "--segment", "1s"], &[]).spawn().unwrap();
        let path = desk.path().join(name);
        let deadline = Instant::now() + Duration::from_secs(60);
        let rows_now = || Recording::read(&desk.path().join(journal)).map_or(0, |recording| recording.len());
        while rows_now() < 20 {
            assert!(Instant::now() < deadline);
            std::thread::sleep(Duration::from_millis(10));
        }
        run.kill().unwrap();
        run.wait().unwrap();
        board.finish();
        let before = Recording::read(&desk.path().join(journal)).unwrap().len();
        let output = desk.anemo(&["recover", name], &[]);
        assert!(output.status.success(), "{output:?}");
        let said = String::from_utf8(output.stdout).unwrap();
        assert!(said.ends_with(&format!(": {before} rows\n")), "{said}");
        let recording = Recording::read(&path).unwrap();
        assert_eq!((recording.metadata("complete"), recording.time_s().unwrap()[0]), (Some("false"), 0.0));
        // No row twice, and none missing between segments.
        assert_eq!(recording.sample_period_s().unwrap(), 0.01);
        let again = String::from_utf8(desk.anemo(&["recover", name], &[]).stdout).unwrap();
        assert!(again.contains("nothing to recover"), "{again}");
    }
}

#[test]
fn a_board_that_says_nothing_is_given_three_seconds() {
    let (sentence, seconds) = fails(Quirks { mute: true, ..Quirks::default() });
    assert!(sentence.starts_with("the board has not answered for 3.0 s; is its firmware running"), "{sentence}");
    assert!((3.0..6.0).contains(&seconds), "{seconds} s");
}

#[test]
fn a_board_of_another_wire_version_is_named_as_that() {
    let (sentence, _) = fails(Quirks { foreign: true, ..Quirks::default() });
    let versions =
        format!("version {} of the wire protocol, this program version {};", wire::VERSION + 1, wire::VERSION);
    assert!(sentence.contains(&versions) && sentence.contains("flash"), "{sentence}");
}

#[test]
fn a_board_that_falls_silent_in_a_run_ends_it() {
    let (sentence, seconds, recording) = ends_early(Quirks { silent_from: Some(150), ..Quirks::default() });
    assert!(
        sentence.starts_with("the board has not answered for 3.0 s") && sentence.ends_with(NOT_STOPPED),
        "{sentence}"
    );
    // Bytes on the line went with the cable.
    assert!((50..=150).contains(&recording.len()), "{}", recording.len());
    // Three more seconds go into stopping it.
    assert!(seconds < 9.0, "{seconds} s");
}

#[test]
fn a_board_that_starts_anew_in_a_run_ends_it() {
    let (sentence, _, recording) = ends_early(Quirks { restarts_at: Some(350), ..Quirks::default() });
    assert_eq!(
        sentence,
        "the board has started anew in the middle of the run, heaters low; it says that a task of its firmware hung"
    );
    assert_eq!(recording.len(), 350);
}

#[test]
fn a_board_that_is_unplugged_in_a_run_ends_it() {
    let (sentence, _, recording) = ends_early(Quirks { unplugged_at: Some(150), ..Quirks::default() });
    assert!(
        sentence.starts_with("the link to the board broke: ")
            && sentence.ends_with(&format!("has it been unplugged?{NOT_STOPPED}")),
        "{sentence}"
    );
    assert_eq!(recording.len(), 150);
}

#[test]
fn a_port_that_is_not_there_is_answered_with_those_that_are() {
    let desk = desk();
    let (code, sentence) = desk.refused(&["run", "e.toml", "--on", "serial:/dev/no-such-port", "-o", "r.csv"], &[]);
    assert_eq!(code, 1);
    assert!(sentence.starts_with("the port /dev/no-such-port cannot be opened: "), "{sentence}");
    assert!(
        sentence.contains("; there are /") || sentence.ends_with("; this computer has no serial port"),
        "{sentence}"
    );
    // A file is no port either.
    let (code, sentence) = desk.refused(&["run", "e.toml", "--on", "serial:e.toml"], &[]);
    assert_eq!(code, 1);
    assert!(sentence.starts_with("the port e.toml cannot be opened: "), "{sentence}");
}
