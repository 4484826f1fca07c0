//! The processor goes astray while a heater is high.

use crate::rig::{Rig, experiment};
use dr_core::control::{Cause, RunState};
use host_sim::experiment::Experiment;
use host_sim::instrument::InstrumentPort;
use host_sim::run::start;
use silicon::machine::MachineConfig;
use silicon::soc::rcc::ResetSource;
use silicon::time::{ms, us};
use wire::{CrashKind, ResetCause};

pub fn heating() -> Experiment {
    Experiment { sample_period_s: 0.01, ..experiment("held.toml", 1_000) }
}

/// Starts heating; a heater is high then.
pub fn heat(rig: &Rig) {
    let experiment = heating();
    let mut instrument = rig.instrument();
    start(&experiment, &mut instrument).unwrap();
    Rig::observe(&mut instrument, 10, |_| {});
    assert_eq!(rig.machine().board().heaters(), 1);
}

/// Messages of the board after a reset: why it has started, and why it keeps its heaters low.
pub fn after_reset(rig: &Rig) -> (wire::Identity, Option<Cause>) {
    let mut instrument = rig.instrument();
    let identity = instrument.identity().clone();
    let state = instrument.observe().unwrap().sample.state;
    let cause = if let RunState::Tripped(trip) = state { Some(trip.cause) } else { None };
    (identity, cause)
}

#[test]
fn a_core_that_stops_is_reset_by_the_watchdog_at_any_of_its_speeds() {
    for oscillator_hz in [17_000, 32_000, 47_000] {
        let rig =
            Rig::new(&MachineConfig { sensor: heating().sensor_config().unwrap(), oscillator_hz: Some(oscillator_hz) });
        heat(&rig);
        let at = rig.machine().now();
        rig.machine().mask_interrupts().unwrap();
        rig.machine().run_for(ms(2_000)).unwrap();
        let resets = rig.machine().resets().to_vec();
        assert_eq!(resets.len(), 1);
        assert_eq!(resets[0].source, ResetSource::Watchdog);
        // Half a second at 32 kHz, of which up to 50 ms were over; pins fall with the reset.
        let period = ms(500) * 32_000 / oscillator_hz;
        let took = resets[0].cycle - at;
        assert!((period - ms(60)..period + ms(20)).contains(&took), "{oscillator_hz} Hz: {took}");
        let last = *rig.machine().pins().last().unwrap();
        assert_eq!((last.levels, last.cycle), (0, resets[0].cycle));
        let (identity, cause) = after_reset(&rig);
        assert_eq!((identity.reset, identity.starts), (ResetCause::Watchdog, 2));
        assert_eq!(cause, Some(Cause::Watchdog));
        rig.assert_no_complaint();
    }
}

#[test]
fn a_stack_that_has_run_over_ends_as_a_fault_with_the_heaters_low() {
    let rig = Rig::of(&heating());
    heat(&rig);
    let at = rig.machine().now();
    rig.machine().core_mut().set_stack_pointer(0x2000_0010).unwrap();
    rig.machine().run_for(ms(1_000)).unwrap();
    let low = *rig.machine().pins().last().unwrap();
    assert_eq!(low.levels, 0);
    // At the next exception, which is the next conversion at the latest.
    assert!(low.cycle - at < us(300), "{}", low.cycle - at);
    assert_eq!(rig.machine().resets()[0].source, ResetSource::Software);
    let (identity, cause) = after_reset(&rig);
    assert_eq!(identity.reset, ResetCause::Software);
    assert_eq!(identity.crash.map(|crash| crash.kind), Some(CrashKind::Fault));
    assert_eq!(cause, Some(Cause::Fault));
    rig.assert_no_complaint();
}

#[test]
fn the_reset_pin_lowers_the_heaters_at_once() {
    let rig = Rig::of(&heating());
    heat(&rig);
    let at = rig.machine().now();
    rig.machine().reset_by(ResetSource::Pin).unwrap();
    let last = *rig.machine().pins().last().unwrap();
    assert_eq!((last.levels, last.cycle), (0, at));
    let (identity, cause) = after_reset(&rig);
    assert_eq!((identity.reset, cause), (ResetCause::Pin, None));
    rig.assert_no_complaint();
}

/// An endless loop in RAM, which all interrupts would go on around: without the memory protection
/// the instrument would heat on.
#[test]
fn a_jump_into_ram_ends_as_a_fault_with_the_heaters_low() {
    const STACK_END: u32 = 0x2000_0000;
    let rig = Rig::of(&heating());
    heat(&rig);
    let at = rig.machine().now();
    rig.machine().core_mut().write_memory(STACK_END, &[0xfe, 0xe7]).unwrap();
    rig.machine().core_mut().jump(STACK_END, 0).unwrap();
    rig.machine().run_for(ms(1_000)).unwrap();
    let low = *rig.machine().pins().last().unwrap();
    assert_eq!(low.levels, 0);
    assert!(low.cycle - at < us(300), "{}", low.cycle - at);
    let (identity, cause) = after_reset(&rig);
    assert_eq!(identity.crash.map(|crash| (crash.kind, crash.at)), Some((CrashKind::Fault, STACK_END)));
    assert_eq!(cause, Some(Cause::Fault));
    rig.assert_no_complaint();
}
