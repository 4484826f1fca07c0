//! The self-test from end to end: in this process, on the emulated board and over a cable; what is
//! found, what is kept, what is said.

use anemo_tests::fake_board::{FakeBoard, Quirks};
use anemo_tests::{Desk, changed, experiment, firmware, sensor};
use anemometry::head::Head;
use dr_core::Command;
use dr_core::control::{Cause, RunState, SelfTestFault, SelfTestFinding, SelfTestPlan};
use host_sim::experiment::Experiment;
use host_sim::instrument::emulated::{Emulated, EmulatorLink as Way};
use host_sim::instrument::in_process::InProcess;
use host_sim::instrument::{InstrumentPort, LockStep, LockStepController, setup};
use host_sim::run;
use host_sim::self_test;
use host_sim::settings::{self, Settings};
use serde_json::Value;
use std::path::Path;
use wire::settings::TestRecord;

const DATE_S: u32 = 1_800_000_000;
const PLAN: SelfTestPlan = SelfTestPlan { pulse_s: Some(0.5), unix_s: Some(DATE_S) };

/// The findings of a test of the experiment's head.
fn tested(experiment: &Experiment, instrument: &mut dyn InstrumentPort, plan: SelfTestPlan) -> Vec<SelfTestFinding> {
    let setup = run::setup_of(experiment).unwrap();
    setup::configure(instrument, &setup).unwrap();
    let known = Some((experiment.sample_period_s as f32, experiment.head.elements.len()));
    let mut last = (0, 0);
    let report = self_test::run(instrument, plan, known, &mut |tick, of| {
        last = (tick, of.unwrap());
        true
    });
    let findings = report.unwrap().unwrap().findings;
    // It ends early where heating would be wrong.
    if findings.iter().all(|finding| finding.cause.is_none()) {
        assert_eq!(last.0 + 1, last.1, "it takes as many ticks as it says");
    }
    findings
}

fn board(flash: Option<&Path>) -> Emulated {
    Emulated::start_with(&firmware(), Way::Fifo, flash).unwrap()
}

fn kept(board: &mut Emulated) -> Vec<TestRecord> {
    let stored = settings::read_all(board).unwrap();
    stored.test.into_iter().chain(stored.test_at_start).collect()
}

#[test]
fn host_and_board_find_the_same_bits_and_the_board_keeps_them() {
    let experiment = experiment("gusts.toml");
    let mut in_process = LockStep::new(InProcess::new(), sensor(&experiment));
    let expected = tested(&experiment, &mut in_process, PLAN);
    assert_eq!(expected.len(), 6);
    for finding in &expected {
        assert!(finding.faults.is_none(), "{finding:?}");
        let ratio = finding.response.unwrap().ratio.unwrap();
        // The models are of another day's identification.
        assert!((0.9..1.1).contains(&ratio), "{finding:?}");
    }
    // An experiment runs as ever after it.
    let digest = |instrument: &mut dyn InstrumentPort| {
        run::start(&experiment, instrument).unwrap();
        (0..200).for_each(|_| drop(instrument.observe().unwrap()));
        instrument.digests()
    };
    let folder = tempfile::tempdir().unwrap();
    let flash = folder.path().join("board.flash");
    let mut emulated = LockStep::new(board(Some(&flash)), sensor(&experiment));
    assert_eq!(tested(&experiment, &mut emulated, PLAN), expected);
    assert_eq!(digest(&mut emulated), digest(&mut in_process));
    Box::new(emulated).finish().unwrap();

    // The next start of the board is another life, with the same flash.
    let mut again = board(Some(&flash));
    let tests = kept(&mut again);
    assert_eq!(tests.len(), 1);
    assert_eq!((tests[0].unix_s, tests[0].starts), (Some(DATE_S), 1));
    assert_eq!(tests[0].firmware, LockStepController::identity(&again).firmware);
    assert_eq!(tests[0].findings[..], expected[..]);
}

#[test]
fn a_board_that_knows_its_head_tests_itself_at_each_start_without_heat() {
    let folder = tempfile::tempdir().unwrap();
    let flash = folder.path().join("board.flash");
    let experiment = experiment("gusts.toml");
    let mut first = board(Some(&flash));
    let mut values = Settings::default();
    let head = Head::read(&anemo_tests::file("heads/sphere-b.toml")).unwrap();
    values.set_head(&head, experiment.sample_period_s).unwrap();
    settings::write(&mut first, &values).unwrap();
    Box::new(first).finish().unwrap();

    let mut instrument = LockStep::new(board(Some(&flash)), sensor(&experiment));
    let mut findings = Vec::new();
    for _ in 0..300 {
        let sample = instrument.observe().unwrap().sample;
        assert_eq!((sample.state, sample.heaters.0), (RunState::Standby, 0));
        findings.extend(instrument.findings());
    }
    assert_eq!(findings.len(), 6);
    assert!(findings.iter().all(|finding| finding.faults.is_none() && finding.response.is_none()), "{findings:?}");
    let tests = kept(instrument.body_mut());
    assert_eq!((tests.len(), tests[0].unix_s, tests[0].starts), (1, None, 1));
    assert_eq!(tests[0].findings[..], findings[..]);
}

#[test]
fn a_run_can_begin_in_the_middle_of_the_test_of_the_start() {
    let folder = tempfile::tempdir().unwrap();
    let flash = folder.path().join("board.flash");
    let experiment = experiment("gusts.toml");
    let mut instrument = LockStep::new(board(Some(&flash)), sensor(&experiment));
    let setup = run::setup_of(&experiment).unwrap();
    setup::configure(&mut instrument, &setup).unwrap();
    instrument.command(Command::SelfTest(SelfTestPlan { pulse_s: None, unix_s: None })).unwrap();
    (0..30).for_each(|_| drop(instrument.observe().unwrap()));
    run::start(&experiment, &mut instrument).unwrap();
    for tick in 0..100 {
        let sample = instrument.observe().unwrap().sample;
        // The first reading was still of the shorted inputs.
        assert_eq!((sample.state, sample.valid), (RunState::Running, if tick == 0 { 0 } else { 0x3f }), "{tick}");
    }
    assert_eq!(instrument.findings(), []);
}

#[test]
fn what_is_wrong_with_a_head_is_found_alike_by_host_and_board() {
    let on_both = |experiment: &Experiment| {
        let in_process = tested(experiment, &mut LockStep::new(InProcess::new(), sensor(experiment)), PLAN);
        assert_eq!(tested(experiment, &mut LockStep::new(board(None), sensor(experiment)), PLAN), in_process);
        in_process
    };
    for (kind, cause) in [("open", Cause::Open), ("shorted", Cause::Short)] {
        let fault = format!("[[faults]]\nstart_s = 0.0\nelement = \"sector3\"\nkind = \"{kind}\"\n\n[[wind]]");
        let findings = on_both(&changed("gusts.toml", &[("[[wind]]", &fault)]));
        for (i, finding) in findings.iter().enumerate() {
            assert_eq!(finding.cause, (i == 2).then_some(cause), "{finding:?}");
            assert_eq!(finding.faults.has(SelfTestFault::Continuity), i == 2, "{finding:?}");
            assert!(finding.response.is_none(), "nothing is heated: {finding:?}");
        }
    }
    // 1 mV is 0.6 K at the low level.
    let findings = on_both(&changed("gusts.toml", &[("noise_v_rms = 1.5e-6", "noise_v_rms = 1e-3")]));
    assert!(findings.iter().all(|finding| finding.faults.has(SelfTestFault::Noise)), "{findings:?}");
}

#[test]
fn the_command_says_what_it_has_found() {
    let desk = Desk::new("gusts.toml", &[]);
    let output = desk.anemo(&["self-test", "e.toml", "--on", "sim", "--json"], &[]);
    assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&report["well"], &report["pulse_s"]), (&true.into(), &1.0.into()));
    assert_eq!(report["elements"].as_array().unwrap().len(), 6);
    assert_eq!(report["elements"][2]["element"], "sector3");
    assert!(report["date"].as_str().unwrap().ends_with('Z'));

    for (arguments, right) in [
        (["self-test", "e.toml", "--on", "sim", "--pulse", "0.05"], "pulse_s"),
        (["self-test", "e.toml", "--on", "sim", "--pulse", "11"], "pulse_s"),
        (["self-test", "--on", "sim", "--no-heat", "--json", "--acknowledge"], "name one"),
        (["self-test", "e.toml", "--on", "sim", "--stored", "--json"], "keeps nothing"),
        (["self-test", "e.toml", "--on", "qemu", "--stored", "--json"], "--flash FILE"),
    ] {
        let (_, sentence) = desk.refused(&arguments, &[]);
        assert!(sentence.contains(right), "{arguments:?}: {sentence}");
    }
}

#[test]
fn over_a_cable_it_is_the_simulated_one() {
    let desk = Desk::new("gusts.toml", &[]);
    let board = FakeBoard::new(&desk.experiment(), Quirks::default());
    let on = format!("serial:{}", board.device);
    let output = desk.anemo(&["self-test", "e.toml", "--on", &on, "--no-heat", "--json"], &[]);
    assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&report["well"], &report["firmware"]), (&true.into(), &"fake board".into()));
    assert!(report["elements"][0]["response"].is_null());
    let report = board.finish();
    assert_eq!((report.state, report.obeyed.last()), (RunState::Standby, Some(&Command::Stop)));
}
