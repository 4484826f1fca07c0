//! Long runs on the emulated board: host and board the same to the bit at every tick, no deadline
//! missed, nothing lost, and as much room in its queues at the end as at the beginning.

use anemo_tests::{changed, firmware, readings, sensor};
use dr_core::Command;
use dr_core::control::Drive;
use host_sim::instrument::LockStepController;
use host_sim::instrument::emulated::{Emulated, EmulatorLink as Way};
use host_sim::instrument::in_process::InProcess;
use std::cell::Cell;
use wire::Status;

/// At 10 Hz.
const TICKS_AN_HOUR: u32 = 36_000;

/// The board's word on its health, a second of its own time later.
fn fresh_status(board: &mut Emulated, tick: &mut impl FnMut(&mut Emulated)) -> Status {
    let from = board.status().map_or(0, |status| status.uptime_s);
    loop {
        if let Some(status) = board.status().filter(|status| status.uptime_s >= from + 2) {
            return status.clone();
        }
        tick(board);
    }
}

#[test]
fn two_hours() {
    hours(2);
}

#[test]
#[ignore = "nightly: two minutes"]
fn a_day_and_a_night() {
    hours(24);
}

fn hours(count: u32) {
    // Ten times the gusts' tick; the wind comes around again and again in its last gust.
    let experiment = changed("gusts.toml", &[("sample_period_s = 0.01", "sample_period_s = 0.1")]);
    let board = Emulated::start(&firmware(), Way::Fifo).unwrap();
    let (mut board, mut host) =
        (anemo_tests::started(&experiment, board), anemo_tests::started(&experiment, InProcess::new()));
    let (board, host) = (board.body_mut(), host.body_mut());
    board.without_samples().unwrap();
    let mut sensor = sensor(&experiment);
    let elements = experiment.head.elements.len() as u8;
    let ticks = Cell::new(0_u32);
    let mut tick = |board: &mut Emulated| {
        let n = ticks.replace(ticks.get() + 1);
        // Every hour another set-point, as a host would ask for it.
        if n % TICKS_AN_HOUR == TICKS_AN_HOUR - 1 {
            let drive = Drive::Temperature { target_c: -23.0 - (n / TICKS_AN_HOUR % 3) as f32 };
            let drives = (0..elements).map(|element| Command::Drive { element, drive });
            for command in std::iter::once(Command::Arm { window_s: 1.0 }).chain(drives) {
                assert_eq!(board.command(command).unwrap(), host.command(command).unwrap());
            }
        }
        let given = readings(&sensor);
        let levels = host.exchange(&given).unwrap().sample.heaters;
        let answer = board.exchange_levels(&given).unwrap();
        assert_eq!((answer.heaters, board.digests()), (levels, host.digests()), "tick {n}");
        sensor.advance(levels.0);
    };
    for _ in 0..count * TICKS_AN_HOUR {
        tick(board);
    }
    let status = fresh_status(board, &mut tick);
    let n = ticks.get();
    println!("{n} ticks, {} h, digest {:016x}: {status:?}", n / TICKS_AN_HOUR, board.digests().control.value());
    assert_eq!((status.control.late_ticks, status.deadlines, status.control.bit_flips), (0, 0, 0));
    assert_eq!((status.unsent, status.refused), (0, 0));
    let link = status.link;
    assert_eq!((link.damaged, link.oversized, link.repeated, link.lost, link.foreign), (0, 0, 0, 0, 0));
    // A place that was lost from a queue each time, or each thousandth time, would have left none
    // long ago: readings and their answers have gone through theirs at every tick, commands seven
    // times an hour, and none was refused or unsent.
}
