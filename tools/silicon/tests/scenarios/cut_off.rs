//! The cut-off of the platinum's supply: what is left when pins and watchdog lower nothing.

use crate::rig::{Rig, experiment};
use crate::settings::ERASE;
use dr_core::Command;
use dr_core::control::{Cause, RunState};
use host_sim::experiment::Experiment;
use host_sim::instrument::{InstrumentPort, SettingsPort};
use host_sim::run::start;
use silicon::board::HOLDS;
use silicon::time::ms;

/// A cold sector that is heated in every tick of 10 ms.
fn heated() -> Rig {
    let experiment = Experiment { sample_period_s: 0.01, ..experiment("held.toml", 1_000) };
    let rig = Rig::of(&experiment);
    let mut instrument = rig.instrument();
    start(&experiment, &mut instrument).unwrap();
    Rig::observe(&mut instrument, 10, |_| {});
    assert_eq!(rig.machine().board().plant.heated(), 1);
    rig
}

/// Pins that are high, and heaters that have the high current.
fn heaters(rig: &Rig) -> (u8, u8) {
    let machine = rig.machine();
    (machine.board().heaters(), machine.board().plant.heated())
}

/// A switch, an op-amp, or drain and gate of a MOSFET: the pin is low, the heater is not.
#[test]
fn a_heater_that_goes_on_after_the_trip_loses_its_supply_until_a_reset() {
    let rig = heated();
    let mut instrument = rig.instrument();
    rig.machine().board_mut().plant.stick_high(1);
    // Regulation asks for the low level at last, and sees the other.
    instrument.command(Command::Stop).unwrap();
    let at = rig.machine().now();
    rig.machine().run_for(ms(200)).unwrap();
    let state = rig.machine().board().witness.state();
    assert!(matches!(state, Some(RunState::Tripped(trip)) if trip.cause == Cause::Open), "{state:?}");
    assert_eq!(heaters(&rig), (0, 1));
    // Five ticks, a beat of the health task, and what the cut-off takes.
    rig.machine().run_until(at + ms(300) + HOLDS).unwrap();
    assert_eq!(heaters(&rig), (0, 0));
    instrument.command(Command::Acknowledge).unwrap();
    rig.machine().run_for(ms(2_000)).unwrap();
    assert_eq!(heaters(&rig), (0, 0));
    assert!(rig.machine().resets().is_empty());
    rig.assert_no_complaint();
}

/// Neither the watchdog nor any interrupt works then.
#[test]
fn a_debugger_that_stops_the_watchdog_does_not_keep_a_heater_on() {
    let rig = heated();
    rig.machine().board_mut().freeze_watchdog();
    rig.machine().board_mut().hold_core(true);
    rig.machine().run_for(HOLDS).unwrap();
    assert_eq!(heaters(&rig), (1, 0));
}

/// The longest time in which nothing moves: a sector is erased for half a second.
#[test]
fn the_supply_stays_while_the_settings_are_erased() {
    let rig = heated();
    let cuts = rig.machine().board().platinum_cuts;
    let mut instrument = rig.instrument();
    instrument.command(Command::Stop).unwrap();
    rig.machine().run_for(ms(50)).unwrap();
    rig.machine().board_mut().flash.erase_time = ms(500);
    instrument.ask_settings(&ERASE).unwrap();
    rig.machine().run_for(ms(500)).unwrap();
    assert_eq!(rig.machine().board().platinum_cuts, cuts);
    assert_eq!(rig.machine().board().witness.state(), Some(RunState::Standby));
    rig.assert_no_complaint();
}
