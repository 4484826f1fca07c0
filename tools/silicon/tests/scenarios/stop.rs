//! `Stop`: at once, and ahead of everything that waits.

use crate::rig::{Rig, experiment};
use crate::settings::ERASE;
use dr_core::control::{Refusal, RunState};
use dr_core::{Command, Reply};
use host_sim::experiment::Experiment;
use host_sim::instrument::InstrumentPort;
use host_sim::run::start;
use silicon::machine::MachineConfig;
use silicon::time::{ms, us};
use wire::{FromBoard, Receiver, ToBoard};

/// Pins fall before the reply, at whatever moment of a tick, and the readings of the tick that was
/// cut short are none: they trip nothing.
#[test]
fn a_stop_lowers_the_pins_at_once_at_any_moment_of_a_tick() {
    for (sample_period_s, step_us) in [(0.05, 4_877), (0.001, 97)] {
        let experiment = Experiment { sample_period_s, ..experiment("held.toml", 10) };
        for moment in 0..10 {
            let rig = Rig::of(&experiment);
            let mut instrument = rig.instrument();
            start(&experiment, &mut instrument).unwrap();
            // A cold sector is heated in every tick.
            Rig::observe(&mut instrument, 5, |_| {});
            rig.machine().run_for(us(step_us * moment)).unwrap();
            assert_eq!(rig.machine().board().heaters(), 1);
            let at = rig.machine().now();
            instrument.command(Command::Stop).unwrap();
            let last = *rig.machine().pins().last().unwrap();
            assert_eq!(last.levels, 0);
            // The line takes 0.1 ms, and notices its end after a byte's time.
            assert!(last.cycle - at < us(400), "{}", last.cycle - at);
            rig.machine().run_for(ms(200)).unwrap();
            assert_eq!(rig.machine().board().witness.state(), Some(RunState::Standby));
            assert_eq!(*rig.machine().pins().last().unwrap(), last);
            rig.assert_no_complaint();
        }
    }
}

/// The flash is being erased, all places for commands are taken, and among them is a run.
#[test]
fn a_stop_goes_ahead_of_commands_that_wait_and_voids_them() {
    let experiment = experiment("held.toml", 10);
    let rig = Rig::new(&MachineConfig { sensor: experiment.sensor_config().unwrap(), oscillator_hz: None });
    rig.machine().board_mut().flash.erase_time = ms(60);
    let mut instrument = rig.instrument();
    start(&experiment, &mut instrument).unwrap();
    instrument.command(Command::Stop).unwrap();
    let pins = rig.machine().pins().len();
    let arm = ToBoard::Command(Command::Arm { window_s: 5.0 });
    let mut messages = vec![ToBoard::Settings(ERASE), arm.clone()];
    messages.push(ToBoard::Command(Command::Start));
    messages.extend(vec![arm; 6]);
    messages.push(ToBoard::Command(Command::Stop));
    for (number, message) in messages.iter().enumerate() {
        let mut buffer = [0; wire::MAX_FRAME];
        let frame = wire::encode(1_000 + number as u16, message, &mut buffer).unwrap();
        rig.machine().board_mut().receive(frame);
        rig.machine().run_for(ms(1)).unwrap();
    }
    rig.machine().run_for(ms(1_500)).unwrap();
    assert_eq!(rig.machine().board().flash.erases, 1);
    let (mut receiver, mut results) = (Receiver::new(), Vec::new());
    for (_, frame) in rig.machine().board_mut().host.frames() {
        for received in frame.iter().filter_map(|&byte| receiver.push::<FromBoard>(byte)) {
            if let FromBoard::Reply { to: 1_001.., result } = received.message {
                results.push(result);
            }
        }
    }
    // Seven find room in the queue.
    assert_eq!(results, [vec![Err(Refusal::Stopped); 7], vec![Ok(Reply::Done)]].concat());
    assert_eq!(rig.machine().board().witness.state(), Some(RunState::Standby));
    assert_eq!(rig.machine().pins().len(), pins, "a heater was high behind the stop");
    rig.assert_no_complaint();
}
