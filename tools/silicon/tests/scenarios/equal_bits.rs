//! The board decides and reports what a controller in this process makes of the same readings, to
//! the bit; noise on the line does not reach into that.
//!
//! Readings of a board that samples a sensor in its own time are not those of a simulation in
//! lock-step. So those that this board has read are taken from its converter's bus, put together to
//! ticks as the board does, and handed to a controller in this process.

use crate::rig::{Rig, experiment};
use dr_core::Command;
use dr_core::sensor::Reading;
use firmware::drivers::settled_mean::SettledMean;
use firmware::drivers::tick_plan::TickPlan;
use host_sim::experiment::Experiment;
use host_sim::instrument::in_process::InProcess;
use host_sim::instrument::setup::ARM;
use host_sim::instrument::{InstrumentPort, LinkReport, LockStepController, TickReport};
use host_sim::run::{setup_of, start};
use silicon::adc::{CHANNELS, FRAME_BYTES, OFFSET_CODES};
use wire::{LinkCounters, MAX_FRAME, ToBoard, encode};

const TICKS: u32 = 300;

/// Codes of a frame, less the offsets that the board has found at its start.
fn codes(frame: &[u8; FRAME_BYTES]) -> [i32; CHANNELS] {
    let code = |of: usize| {
        let at = 3 + 3 * of;
        i32::from_be_bytes([frame[at], frame[at + 1], frame[at + 2], 0]) >> 8
    };
    std::array::from_fn(|channel| code(channel) - OFFSET_CODES[channel])
}

/// Reports of a controller in this process of these conversions, tick by tick.
fn replayed(experiment: &Experiment, frames: &[[u8; FRAME_BYTES]]) -> impl Iterator<Item = TickReport> {
    let plan = TickPlan::from_seconds(experiment.sample_period_s as f32).unwrap();
    let mut mean = SettledMean::<CHANNELS>::new(plan);
    let mut controller = InProcess::new();
    let setup = setup_of(experiment).unwrap();
    for command in [Command::Clear].into_iter().chain(setup).chain([ARM, Command::Start]) {
        controller.command(command).unwrap();
    }
    let ticks: Vec<[Reading; CHANNELS]> =
        frames.iter().filter_map(|frame| mean.conversion(Some(&codes(frame)))).collect();
    ticks.into_iter().map(move |readings| controller.exchange(&readings).unwrap())
}

/// Runs an experiment, and holds every tick against a controller in this process. `disturb` may do
/// something before a tick.
fn compare(experiment: &Experiment, mut disturb: impl FnMut(u32, &Rig)) -> LinkReport {
    let rig = Rig::of(experiment);
    let mut instrument = rig.instrument();
    rig.machine().board_mut().adc.record = Some(Vec::new());
    start(experiment, &mut instrument).unwrap();
    let mut reports = Vec::new();
    for tick in 0..TICKS {
        disturb(tick, &rig);
        let seen = instrument.observe().unwrap();
        reports.push(TickReport { sample: seen.sample, equivalent_power_w: seen.equivalent_power_w, wind: seen.wind });
    }
    let frames = rig.machine().board_mut().adc.record.take().unwrap();
    let conversions = TickPlan::from_seconds(experiment.sample_period_s as f32).unwrap().conversions();
    // The run has begun with one of the conversions of before: from that one on all is equal.
    let begins = frames.len() - (conversions * TICKS) as usize;
    let equal =
        (0..=begins).filter(|&first| replayed(experiment, &frames[first..]).zip(&reports).all(|(a, b)| a == *b));
    assert_eq!(equal.count(), 1, "of {begins} conversions with which the run may have begun");
    rig.assert_no_complaint();
    Box::new(instrument).finish().unwrap()
}

#[test]
fn a_controller_in_this_process_does_the_same_with_the_boards_readings_to_the_bit() {
    // A temperature is held, without a model and with six, estimates and all.
    compare(&Experiment { sample_period_s: 0.01, ..experiment("held.toml", TICKS) }, |_, _| {});
    compare(&experiment("gusts.toml", TICKS), |_, _| {});
}

#[test]
fn what_the_line_does_to_frames_is_counted_and_does_not_reach_the_loop() {
    let frame = |number: u16, message: &ToBoard| encode(number, message, &mut [0; MAX_FRAME]).unwrap().to_vec();
    let stop = frame(900, &ToBoard::Command(Command::Stop));
    let telemetry = frame(950, &ToBoard::Telemetry { every: 1 });
    let mut flipped = stop.clone();
    flipped[3] ^= 0x10;
    let endless = [vec![0x5a; 700], vec![0]].concat();
    let garbage = [vec![0x93, 0x17, 0xc5, 0x2a, 0x71], vec![0]].concat();
    let truncated = [&stop[..stop.len() - 3], &[0]].concat();
    let bursts = [truncated, flipped, garbage, endless, telemetry.clone(), telemetry];
    let report = compare(&experiment("gusts.toml", TICKS), |tick, rig| {
        if let Some(burst) =
            tick.checked_sub(20).and_then(|after| bursts.get(after as usize / 5)).filter(|_| tick % 5 == 0)
        {
            rig.machine().board_mut().receive(burst);
        }
    });
    let LinkCounters { damaged, oversized, repeated, foreign, .. } = report.status.unwrap().link;
    assert_eq!((damaged, oversized, repeated, foreign), (3, 1, 1, 0));
}
