//! A log of a board at a serial port: what ends a run is an event, and the recording goes on.

use anemo_tests::fake_board::{FakeBoard, Quirks};
use anemo_tests::{Desk, file};
use dr_core::Command;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use recording::Recording;
use serde_json::Value;
use std::process::{Child, Output, Stdio};
use std::time::{Duration, Instant};

/// A board runs so fast that its host seems silent, between two of its frames, for minutes.
fn desk() -> Desk {
    let no_timeout = "sample_period_s = 0.01\nhost_timeout_s = 0.0";
    Desk::new("all-drives.toml", &[("sample_period_s = 0.01", no_timeout)])
}

fn start(desk: &Desk, board: &FakeBoard, more: &[&str]) -> Child {
    let on = format!("serial:{}", board.device);
    let arguments = [&["log", "e.toml", "--on", &on, "-o", "mast", "--segment", "1min", "--json"], more].concat();
    desk.command(&arguments, &[]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

fn wait(what: &str, mut is_so: impl FnMut() -> bool) {
    let deadline = Instant::now() + Duration::from_secs(60);
    while !is_so() {
        assert!(Instant::now() < deadline, "{what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn status(desk: &Desk) -> Value {
    let output = desk.anemo(&["board", "status", "mast", "--json"], &[]);
    serde_json::from_slice(&output.stdout).unwrap_or_default()
}

fn has_event(desk: &Desk, text: &str) -> bool {
    status(desk)["events"].as_array().is_some_and(|events| events.iter().any(|event| event.to_string().contains(text)))
}

/// Ends a log in order: its exit code, its summary, its recording.
fn end(desk: &Desk, log: Child) -> (Option<i32>, Value, Recording) {
    kill(Pid::from_raw(log.id().try_into().unwrap()), Signal::SIGTERM).unwrap();
    let Output { status, stdout, stderr } = log.wait_with_output().unwrap();
    let summary = serde_json::from_slice(&stdout).unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&stderr)));
    let recording = Recording::read(&desk.path().join("mast")).unwrap();
    recording.time_s().unwrap();
    (status.code(), summary, recording)
}

/// Rows with this text in their column `event`.
fn rows_with(recording: &Recording, text: &str) -> usize {
    recording.events().unwrap().iter().filter(|event| event.contains(text)).count()
}

#[test]
fn a_cable_that_was_out_leaves_a_gap_in_a_recording_that_goes_on() {
    let desk = desk();
    let out = Duration::from_millis(3500);
    let board = FakeBoard::new(&desk.experiment(), Quirks { cable_out: Some((500, out)), ..Quirks::default() });
    let log = start(&desk, &board, &[]);
    wait("the link is back", || has_event(&desk, "link is back"));
    let marked = desk.anemo(&["mark", "door opened", "mast"], &[]);
    assert!(marked.status.success(), "{marked:?}");
    wait("the mark is read", || has_event(&desk, "door opened"));
    let (code, summary, recording) = end(&desk, log);
    assert_eq!((code, &summary["gaps"], &summary["resets"]), (Some(0), &1.into(), &0.into()), "{summary}");
    assert_eq!(summary["rows"], recording.len());
    // The board has counted on: every tick is a row or lost.
    let last_s = *recording.time_s().unwrap().last().unwrap();
    let ticks = (last_s * 100.0).round() as u64 + 1;
    assert_eq!(summary["rows"].as_u64().unwrap() + summary["lost"].as_u64().unwrap(), ticks);
    assert_eq!(
        (rows_with(&recording, "gap: the board has not answered"), rows_with(&recording, "door opened")),
        (1, 1)
    );
    assert!(recording.words("state").unwrap().iter().all(|state| state == "running"));
    assert_eq!(recording.metadata("ended"), Some("stopped"));
    assert_eq!(board.finish().obeyed.iter().filter(|command| **command == Command::Start).count(), 1);
    let refused = desk.anemo(&["mark", "too late", "mast"], &[]);
    assert_eq!(refused.status.code(), Some(2));
}

#[test]
fn after_a_reset_the_log_only_records() {
    let desk = desk();
    let board = FakeBoard::new(&desk.experiment(), Quirks { restarts_at: Some(500), ..Quirks::default() });
    let log = start(&desk, &board, &["--auto-acknowledge"]);
    let standby = || status(&desk)["state"] == "standby";
    wait("the board is acknowledged and records", standby);
    std::thread::sleep(Duration::from_millis(500));
    let (code, summary, recording) = end(&desk, log);
    assert_eq!((code, &summary["resets"], &summary["trips"]), (Some(3), &1.into(), &1.into()), "{summary}");
    let states = recording.words("state").unwrap();
    assert_eq!(states.dictionary(), ["running", "standby"]);
    let standby: Vec<usize> = states.stretches().filter(|(.., state)| *state == "standby").map(|at| at.0).collect();
    assert_eq!(standby, [500]);
    for element in ["sector1", "core1"] {
        let heater = recording.numbers(&format!("heater_{element}")).unwrap();
        assert!(heater[500..].iter().all(|bit| *bit == 0.0));
    }
    assert!(rows_with(&recording, "board started anew") == 1 && rows_with(&recording, "tripped: watchdog") == 1);
    let report = board.finish();
    let count = |kind: fn(&Command) -> bool| report.obeyed.iter().filter(|command| kind(command)).count();
    assert_eq!(count(|command| matches!(command, Command::Start | Command::Arm { .. })), 2);
    assert_eq!(count(|command| matches!(command, Command::Acknowledge)), 1);
}

#[test]
fn a_trip_is_told_to_a_command_and_a_log_can_end_with_it() {
    let fault = "[[faults]]\nstart_s = 3.0\nelement = \"sector3\"\nkind = \"open\"\n\n[[wind]]";
    let desk = Desk::new("all-drives.toml", &[("[[wind]]", fault)]);
    let told = "echo $ANEMO_TRIP_CAUSE of $ANEMO_TRIP_ELEMENT > told";
    let log = ["log", "e.toml", "--on", "sim", "--fast", "--for", "5s", "--json"];
    let goes_on = desk.anemo(&[&log[..], &["-o", "on", "--on-trip", told, "--auto-acknowledge"]].concat(), &[]);
    assert_eq!(goes_on.status.code(), Some(3), "{goes_on:?}");
    assert!(String::from_utf8_lossy(&goes_on.stderr).contains("3.01 s: tripped: open, sector3"), "{goes_on:?}");
    wait("the command has run", || {
        std::fs::read_to_string(desk.path().join("told")).is_ok_and(|told| told == "open of sector3\n")
    });
    // Open is never acknowledged.
    let recording = Recording::read(&desk.path().join("on")).unwrap();
    assert_eq!(
        (recording.len(), recording.words("state").unwrap().dictionary()[1].as_str()),
        (500, "tripped:open:sector3")
    );
    let stops = desk.anemo(&[&log[..], &["-o", "off", "--on-trip", "stop"]].concat(), &[]);
    assert_eq!(stops.status.code(), Some(3));
    assert_eq!(Recording::read(&desk.path().join("off")).unwrap().len(), 302);
}

#[test]
fn a_log_continues_the_folder_of_the_one_before() {
    let desk = Desk::new("all-drives.toml", &[]);
    for _ in 0..2 {
        let log = ["log", "e.toml", "--on", "sim", "--fast", "--for", "5s", "-o", "mast", "--every", "1s"];
        let output = desk.anemo(&log, &[]);
        assert!(output.status.success(), "{output:?}");
    }
    let recording = Recording::read(&desk.path().join("mast")).unwrap();
    assert_eq!(recording.len(), 1000);
    let time_s = recording.time_s().unwrap();
    assert_eq!((time_s[499], time_s[500] >= 5.0), (4.99, true));
    let means = Recording::read(&desk.path().join("mast/every-1s")).unwrap();
    assert!((10..=11).contains(&means.len()) && means.has("max_temperature_c_core1"));
}

#[test]
fn a_recording_says_how_its_head_is_mounted() {
    let desk = Desk::new("steady.toml", &[("../heads/sphere-b.toml", "head.toml")]);
    let head = std::fs::read_to_string(file("heads/sphere-b.toml")).unwrap();
    let log = |heading: &str, folder: &str, options: &[&str]| {
        std::fs::write(desk.path().join("head.toml"), format!("heading_deg = {heading}\n{head}")).unwrap();
        let log = ["log", "e.toml", "--on", "sim", "--fast", "--for", "2s", "-o", folder];
        desk.anemo(&[log.as_slice(), options].concat(), &[])
    };
    for (folder, options, heading) in [("a", [].as_slice(), "90"), ("b", &["--heading", "180"], "180")] {
        let output = log("90.0", folder, options);
        assert!(output.status.success(), "{output:?}");
        let recording = Recording::read(&desk.path().join(folder)).unwrap();
        assert_eq!(recording.metadata("heading_deg"), Some(heading));
    }
    let refused = log("400.0", "c", &[]);
    let sentence = String::from_utf8(refused.stderr).unwrap();
    assert!(sentence.contains("`heading_deg` is 400 °: it must lie between 0 and 360"), "{sentence}");
}

#[test]
fn systemd_accepts_the_unit_of_a_service() {
    let desk = Desk::new("steady.toml", &[]);
    let output = desk.anemo(&["log", "e.toml", "--on", "sim", "-o", "a mast", "--service"], &[]);
    assert!(output.status.success());
    let unit = desk.path().join("anemo.service");
    std::fs::write(&unit, &output.stdout).unwrap();
    assert!(!desk.path().join("a mast").exists());
    let mut analyze = std::process::Command::new("systemd-analyze");
    let verified = match analyze.args(["verify", "--man=no"]).arg(&unit).output() {
        Ok(verified) => verified,
        Err(error) => return println!("systemd-analyze: {error}; the unit is not verified"),
    };
    let said = String::from_utf8_lossy(&verified.stderr);
    assert!(verified.status.success() && !said.contains("anemo.service"), "{said}");
}
