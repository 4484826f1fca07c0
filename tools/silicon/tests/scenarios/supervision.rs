//! Watch over the processor itself: the watchdog, and the security of the clock.

use crate::crashes::{after_reset, heat, heating};
use crate::crashes_in_tasks::enter;
use crate::rig::{Rig, experiment};
use crate::settings::ERASE;
use dr_core::control::{Cause, RunState};
use host_sim::experiment::Experiment;
use host_sim::instrument::{InstrumentPort, SettingsPort};
use host_sim::run::start;
use silicon::machine::MachineConfig;
use silicon::plant::SensorPlant;
use silicon::processor::nvic::FIRST_INTERRUPT;
use silicon::soc::rcc::ResetSource;
use silicon::time::{ms, us};
use wire::ResetCause;

/// Heaters have to be low so long after the crystal has failed.
const LOW_WITHIN: u64 = ms(2);

/// An erase of half a second with the slow oscillator at its fastest: the longer period is needed,
/// and a feeding at the worst moment must not take it away.
#[test]
fn no_feeding_comes_between_the_watchdogs_key_and_its_period() {
    let rig = Rig::new(&MachineConfig { oscillator_hz: Some(47_000), ..MachineConfig::default() });
    rig.machine().board_mut().flash.erase_time = ms(500);
    let mut instrument = rig.instrument();
    rig.machine().board_mut().race_at_watchdog();
    instrument.ask_settings(&ERASE).unwrap();
    assert!(rig.machine().resets().is_empty());
    rig.assert_no_complaint();
}

/// Core, SysTick and dead-man timer stop with the crystal. The clock security system takes the
/// internal oscillator, and its interrupt lowers the heaters, at whatever moment of a tick. The
/// board then waits for its crystal, heaters low.
#[test]
fn a_crystal_that_fails_lowers_the_heaters_within_two_milliseconds() {
    let experiment = Experiment { sample_period_s: 0.01, ..experiment("held.toml", 100) };
    for moment in 0..25 {
        let rig = Rig::of(&experiment);
        let mut instrument = rig.instrument();
        start(&experiment, &mut instrument).unwrap();
        Rig::observe(&mut instrument, 5, |_| {});
        rig.machine().run_for(us(413) * moment).unwrap();
        assert_eq!(rig.machine().board().heaters(), 1);
        let at = rig.machine().now();
        rig.machine().board_mut().fail_crystal();
        rig.machine().run_for(ms(1_000)).unwrap();
        let low = rig.machine().pins().iter().find(|change| change.cycle > at).copied().unwrap();
        assert!(low.levels == 0 && low.cycle - at <= LOW_WITHIN, "moment {moment}: {low:?} after {at}");
        assert_eq!(rig.machine().board().heaters(), 0);
    }
}

/// A breakpoint while a heater is high. The watchdog goes on, and what it resets has its pins low;
/// the board then starts, tripped.
#[test]
fn a_debugger_that_holds_the_core_is_ended_by_the_watchdog() {
    let experiment = Experiment { sample_period_s: 0.01, ..experiment("held.toml", 100) };
    for oscillator_hz in [17_000, 32_000, 47_000] {
        let sensor = experiment.sensor_config().unwrap();
        let rig = Rig::new(&MachineConfig { sensor, oscillator_hz: Some(oscillator_hz) });
        let mut instrument = rig.instrument();
        start(&experiment, &mut instrument).unwrap();
        Rig::observe(&mut instrument, 10, |_| {});
        assert_eq!(rig.machine().board().heaters(), 1);
        let at = rig.machine().now();
        rig.machine().board_mut().hold_core(true);
        rig.machine().run_for(ms(2_000)).unwrap();
        let low = rig.machine().pins().iter().find(|change| change.cycle > at).copied().unwrap();
        assert!(low.levels == 0 && low.cycle - at <= ms(950), "{oscillator_hz} Hz: {low:?} after {at}");
        assert_eq!(rig.machine().resets()[0].source, ResetSource::Watchdog);
        assert_eq!(rig.instrument().identity().reset, ResetCause::Watchdog);
        assert_eq!(rig.machine().board().heaters(), 0);
    }
}

/// Control, receiver and transmitter go on, so that nothing else shows it.
#[test]
fn a_settings_server_or_an_idle_loop_that_never_ends_is_ended_by_the_watchdog() {
    const IDLE: u16 = 0;
    const SERVE_SETTINGS: u16 = FIRST_INTERRUPT + 36;
    /// Where the image has nothing.
    const ENDLESS_LOOP: u32 = 0x080f_f000;
    let rig =
        Rig::with_flash(|flash| flash[(ENDLESS_LOOP - 0x0800_0000) as usize..][..2].copy_from_slice(&[0xfe, 0xe7]));
    rig.machine().board_mut().connect(SensorPlant::new(&heating().sensor_config().unwrap()).unwrap());
    heat(&rig);
    let heated = rig.machine().snapshot().unwrap();
    for task in [SERVE_SETTINGS, IDLE] {
        rig.machine().restore(&heated).unwrap();
        let at = {
            let mut machine = rig.machine();
            assert!(enter(&mut machine, task, 0));
            machine.core_mut().jump(ENDLESS_LOOP, 0).unwrap();
            machine.now()
        };
        rig.machine().run_for(ms(7_000)).unwrap();
        let resets = rig.machine().resets().to_vec();
        assert_eq!(resets.len(), 1, "exception {task}");
        assert_eq!(resets[0].source, ResetSource::Watchdog, "exception {task}");
        assert!(resets[0].cycle - at < ms(5_700), "exception {task}: {}", resets[0].cycle - at);
        assert_eq!(rig.machine().board().heaters(), 0);
        assert_eq!(after_reset(&rig).1, Some(Cause::Watchdog));
        rig.assert_no_complaint();
    }
}

/// The board has to be heard again; without a transmitter nobody hears of a trip.
#[test]
fn a_stream_to_the_host_that_is_stuck_is_set_up_anew_or_the_watchdog_restarts_the_board() {
    let rig = Rig::of(&heating());
    let mut instrument = rig.instrument();
    start(&heating(), &mut instrument).unwrap();
    for _ in 0..3 {
        Rig::observe(&mut instrument, 5, |sample| assert_eq!(sample.state, RunState::Running));
        rig.machine().board_mut().stick_transmitter(false);
        rig.machine().run_for(ms(120)).unwrap();
    }
    Rig::observe(&mut instrument, 5, |sample| assert_eq!(sample.state, RunState::Running));
    assert_eq!(rig.machine().resets(), []);
    rig.assert_no_complaint();
    rig.machine().board_mut().stick_transmitter(true);
    rig.machine().run_for(ms(2_000)).unwrap();
    let sources: Vec<_> = rig.machine().resets().iter().map(|reset| reset.source).collect();
    assert_eq!(sources, [ResetSource::Watchdog]);
    assert_eq!(rig.machine().board().heaters(), 0);
    let (identity, cause) = after_reset(&rig);
    assert_eq!((identity.reset, cause), (ResetCause::Watchdog, Some(Cause::Watchdog)));
    rig.assert_no_complaint();
}
