//! Ends of a firmware's life, and what the next one begins with: heaters low, tripped for the
//! cause, until it is acknowledged.
//!
//! The emulated board is really reset: its RAM stays, as on a chip, and it starts anew from the
//! vector table.

use anemo_tests::{experiment, firmware, readings, sensor, start};
use dr_core::Command;
use dr_core::control::{Cause, Heaters, Refusal, RunState, Trip};
use host_sim::instrument::emulated::{Emulated, EmulatorLink as Way};
use host_sim::instrument::{InstrumentError, InstrumentPort, LockStep, LockStepController};
use wire::{CrashKind, Identity, Provocation, ResetCause};

/// A board that has run for a second and then came to harm; what it says after its new start.
fn after(harm: Provocation) -> (LockStep<Emulated>, Identity) {
    let experiment = experiment("gusts.toml");
    let board = Emulated::start(&firmware(), Way::Fifo).unwrap();
    assert_eq!((board.identity().starts, board.identity().reset), (1, ResetCause::PowerOn));
    let mut board = anemo_tests::started(&experiment, board);
    for _ in 0..100 {
        board.observe().unwrap();
    }
    board.body_mut().provoke(harm).unwrap();
    let identity = board.body_mut().reborn().unwrap();
    assert_eq!(identity.starts, 2);
    (board, identity)
}

/// It stands with its heaters low, refuses to run, and says why; acknowledged it runs as ever.
fn is_tripped_until_acknowledged(mut board: LockStep<Emulated>, cause: Cause) {
    let experiment = experiment("gusts.toml");
    let trip = Trip::whole(cause);
    // Since the crash the heaters have been low, and the sensor has cooled down.
    let mut sensor = sensor(&experiment);
    let codes = readings(&sensor);
    for _ in 0..10 {
        let sample = board.body_mut().exchange(&codes).unwrap().sample;
        assert_eq!((sample.state, sample.heaters), (RunState::Tripped(trip), Heaters(0)));
    }
    for command in [Command::Stop, Command::Start, Command::Arm { window_s: 1.0 }, Command::Clear] {
        let refusal = board.command(command).unwrap_err();
        assert!(matches!(refusal, InstrumentError::Refused(Refusal::Tripped(why)) if why == trip), "{refusal}");
    }
    board.command(Command::Acknowledge).unwrap();
    start(&experiment, &mut board);
    let mut high = 0;
    for _ in 0..300 {
        let sample = board.body_mut().exchange(&readings(&sensor)).unwrap().sample;
        assert_eq!(sample.state, RunState::Running);
        high += sample.heaters.0.count_ones();
        sensor.advance(sample.heaters.0);
    }
    assert!(high > 100, "it heats again");
    // Acknowledged, it is forgotten: the next reset is one like any other.
    board.body_mut().provoke(Provocation::Reset).unwrap();
    let identity = board.body_mut().reborn().unwrap();
    assert_eq!((identity.starts, identity.reset, identity.crash), (3, ResetCause::Pin, None));
    assert_eq!(board.body_mut().exchange(&codes).unwrap().sample.state, RunState::Standby);
}

#[test]
fn a_panic_is_remembered_with_its_place() {
    let (board, identity) = after(Provocation::Panic);
    let crash = identity.crash.unwrap();
    assert_eq!((identity.reset, crash.kind), (ResetCause::Software, CrashKind::Panic));
    assert!(crash.file.ends_with("board/virtual_board/mod.rs") && crash.at > 0, "{crash:?}");
    is_tripped_until_acknowledged(board, Cause::Panic);
}

#[test]
fn a_fault_is_remembered_with_its_address() {
    let (board, identity) = after(Provocation::Fault);
    let crash = identity.crash.unwrap();
    assert_eq!(crash.kind, CrashKind::Fault);
    assert!((0x0800_0000..0x0810_0000).contains(&crash.at), "{:#x} is in flash", crash.at);
    is_tripped_until_acknowledged(board, Cause::Fault);
}

#[test]
fn a_reset_by_its_pin_is_no_trip() {
    let (mut board, identity) = after(Provocation::Reset);
    assert_eq!((identity.reset, &identity.crash), (ResetCause::Pin, &None));
    let sample = board.body_mut().exchange(&readings(&sensor(&experiment("gusts.toml")))).unwrap().sample;
    assert_eq!((sample.state, sample.heaters), (RunState::Standby, Heaters(0)));
}

#[test]
fn whoever_waits_for_a_sample_learns_why_there_is_none() {
    let mut board = anemo_tests::started(&experiment("gusts.toml"), Emulated::start(&firmware(), Way::Fifo).unwrap());
    board.observe().unwrap();
    board.body_mut().provoke(Provocation::Panic).unwrap();
    let error = board.observe().unwrap_err().to_string();
    assert!(
        error.contains("has started anew") && error.contains("panicked at") && error.contains("virtual_board/mod.rs:"),
        "{error}"
    );
}

#[test]
fn a_silent_front_end_has_its_heaters_low_after_two_ticks_without_the_control_task() {
    let experiment = experiment("gusts.toml");
    let mut board = anemo_tests::started(&experiment, Emulated::start(&firmware(), Way::Fifo).unwrap());
    let mut sensor = sensor(&experiment);
    let mut heaters = Heaters(0);
    for _ in 0..20 {
        heaters = board.body_mut().exchange(&readings(&sensor)).unwrap().sample.heaters;
        sensor.advance(heaters.0);
    }
    assert_ne!(heaters, Heaters(0), "all elements warm up");
    assert_eq!(board.body_mut().silence().unwrap().heaters, heaters, "one tick is borne");
    for _ in 0..3 {
        assert_eq!(board.body_mut().silence().unwrap().heaters, Heaters(0));
    }
    // When the front end speaks again, it is too late.
    let sample = board.body_mut().exchange(&readings(&sensor)).unwrap().sample;
    assert_eq!((sample.state, sample.heaters), (RunState::Tripped(Trip::whole(Cause::Deadline)), Heaters(0)));
}
