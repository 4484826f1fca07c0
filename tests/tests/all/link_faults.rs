//! A bad line: garbage, truncated and duplicated frames are dropped and counted, and the loop never
//! stops.

use anemo_tests::{emulated, experiment, firmware, foreign_frame, in_process, readings, sensor, start};
use dr_core::Command;
use dr_core::control::Heaters;
use dr_core::sensor::Reading;
use dr_core::signal::Prbs;
use host_sim::instrument::emulated::{Emulated, EmulatorLink as Way};
use host_sim::instrument::{InstrumentPort, LockStep, LockStepController};
use wire::{LinkCounters, MAX_FRAME, ToBoard, encode};

fn frame(sequence: u16, message: &ToBoard) -> Vec<u8> {
    encode(sequence, message, &mut [0; MAX_FRAME]).unwrap().to_vec()
}

/// Injects bytes into the host link of a running board, a burst every few ticks, and compares the
/// run with that of a controller that hears nothing of it. Gives what the board has counted.
fn disturbed(bursts: &[Vec<u8>]) -> LinkCounters {
    let experiment = experiment("gusts.toml");
    let mut host = in_process(&experiment);
    start(&experiment, &mut *host);
    let mut board = anemo_tests::started(&experiment, Emulated::start(&firmware(), Way::Usart).unwrap());
    let quiet = settled(&mut board, &mut host);
    for burst in bursts {
        board.body_mut().inject(burst).unwrap();
        for _ in 0..3 {
            assert_eq!(board.observe().unwrap(), host.observe().unwrap(), "the line has reached into the loop");
        }
    }
    let counted = settled(&mut board, &mut host);
    InstrumentPort::finish(Box::new(board)).unwrap();
    LinkCounters {
        messages: counted.messages - quiet.messages,
        damaged: counted.damaged - quiet.damaged,
        oversized: counted.oversized - quiet.oversized,
        repeated: counted.repeated - quiet.repeated,
        lost: counted.lost - quiet.lost,
        foreign: counted.foreign - quiet.foreign,
    }
}

/// Runs on until two more status messages have come: the second one has seen all that was sent
/// before.
fn settled(board: &mut LockStep<Emulated>, host: &mut LockStep<impl LockStepController>) -> LinkCounters {
    let uptime_s = |board: &LockStep<Emulated>| board.body().status().map_or(0, |status| status.uptime_s);
    let from = uptime_s(board);
    while uptime_s(board) < from + 2 {
        assert_eq!(board.observe().unwrap(), host.observe().unwrap());
    }
    board.body().status().unwrap().link
}

#[test]
fn garbage_is_dropped_and_counted() {
    let mut noise = Prbs::new(29, 4711).unwrap();
    let mut bytes = |count: usize| -> Vec<u8> {
        let mut garbage: Vec<u8> =
            (0..count).map(|_| (0..8).fold(0_u8, |byte, _| byte << 1 | u8::from(noise.step())).max(1)).collect();
        garbage.push(0);
        garbage
    };
    let bursts = [bytes(5), bytes(40), bytes(100), bytes(400), bytes(1), bytes(700)];
    let counted = disturbed(&bursts);
    println!("garbage of 5, 40, 100, 400, 1 and 700 bytes: {counted:?}");
    assert_eq!((counted.damaged, counted.oversized, counted.messages), (4, 2, 0));
}

#[test]
fn truncated_frames_are_dropped_and_the_next_one_is_heard() {
    let command = frame(900, &ToBoard::Command(Command::Stop));
    let mut cut: Vec<Vec<u8>> = (1..command.len() - 1).map(|length| [&command[..length], &[0]].concat()).collect();
    let pieces = cut.len() as u32;
    cut.push(frame(901, &ToBoard::Telemetry { every: 1 }));
    let counted = disturbed(&cut);
    println!("{pieces} truncated frames, then a whole one: {counted:?}");
    assert_eq!((counted.damaged, counted.messages), (pieces, 1));
}

#[test]
fn a_duplicated_command_is_carried_out_once() {
    let telemetry = frame(700, &ToBoard::Telemetry { every: 1 });
    let counted = disturbed(&[telemetry.clone(), telemetry.clone(), telemetry]);
    assert_eq!((counted.messages, counted.repeated), (3, 2));
}

#[test]
fn another_protocol_version_is_not_obeyed() {
    // A whole frame whose version and checksum say 2: stop.
    let counted = disturbed(&[foreign_frame(&[1, 7])]);
    assert_eq!((counted.foreign, counted.messages), (1, 0));
}

#[test]
fn readings_that_are_missing_are_borne_once_and_then_trip() {
    let experiment = experiment("gusts.toml");
    let mut board = anemo_tests::started(&experiment, Emulated::start(&firmware(), Way::Fifo).unwrap());
    let mut sensor = sensor(&experiment);
    let heaters = board.body_mut().exchange(&readings(&sensor)).unwrap().sample.heaters;
    // The others must read as their level makes them, or they would trip for another reason.
    let mut without_one = |heaters: Heaters| {
        sensor.advance(heaters.0);
        let mut readings = readings(&sensor);
        readings[1] = Reading::Missing;
        board.body_mut().exchange(&readings).unwrap()
    };
    let gap = without_one(heaters);
    assert_eq!((gap.sample.valid & 2, gap.sample.heaters.is_high(1)), (0, false));
    assert!(matches!(gap.sample.state, dr_core::control::RunState::Running));
    let trip = without_one(gap.sample.heaters);
    assert!(matches!(trip.sample.state, dr_core::control::RunState::Tripped(_)));
    assert_eq!(trip.sample.heaters.0, 0);
}

#[test]
fn the_emulated_boards_log_can_be_read() {
    let experiment = experiment("gusts.toml");
    let mut board = emulated(&experiment, Way::Fifo);
    start(&experiment, &mut *board);
    board.observe().unwrap();
    let log = InstrumentPort::finish(board).unwrap().log;
    assert!(log.iter().any(|line| line.contains("running from tick 0")), "{log:?}");
}
