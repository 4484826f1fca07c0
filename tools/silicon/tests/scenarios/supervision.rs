//! What watches over the processor itself: the watchdog, and the security of the clock.

use crate::rig::{Rig, experiment};
use host_sim::experiment::Experiment;
use host_sim::instrument::{InstrumentPort, SettingsPort};
use host_sim::run::start;
use silicon::machine::MachineConfig;
use silicon::soc::rcc::ResetSource;
use silicon::time::{ms, us};
use wire::{ResetCause, SettingsRequest};

/// Heaters have to be low so long after the crystal has failed.
const LOW_WITHIN: u64 = ms(2);

/// An erase of half a second with the slow oscillator at its fastest: the longer period is needed,
/// and a feeding at the worst moment must not take it away.
#[test]
fn no_feeding_comes_between_the_watchdogs_key_and_its_period() {
    let rig = Rig::new(&MachineConfig { oscillator_hz: Some(47_000), ..MachineConfig::default() });
    rig.machine().board_mut().flash.erase_time = ms(500);
    rig.machine().board_mut().flash.settings.fill(0x5a);
    let mut instrument = rig.instrument();
    rig.machine().board_mut().race_at_watchdog();
    instrument.ask_settings(&SettingsRequest::EraseAll).unwrap();
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
