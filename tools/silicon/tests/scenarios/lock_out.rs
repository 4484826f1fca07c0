//! Trips that lock, a host that is gone, and another head on the plug.

use crate::crashes_in_tasks::fault;
use crate::rig::{Rig, experiment};
use dr_core::Command;
use dr_core::control::{Cause, Refusal, RunState};
use host_sim::experiment::Experiment;
use host_sim::instrument::serial::Serial;
use host_sim::instrument::{InstrumentError, InstrumentPort};
use host_sim::run::start;
use host_sim::settings::{self, Settings};
use silicon::adc::AdcFault;
use silicon::plant::SensorPlant;
use silicon::soc::rcc::ResetSource;
use silicon::stream::MachineStream;
use silicon::time::ms;
use wire::TestRecord;

/// A cold sector that is heated in every tick of 10 ms.
fn heating(host_timeout_s: Option<f32>) -> Experiment {
    Experiment { sample_period_s: 0.01, host_timeout_s, ..experiment("held.toml", 1_000) }
}

/// Runs until a fault of the converter trips it.
fn trip(rig: &Rig, instrument: &mut Serial<MachineStream>) {
    start(&heating(None), instrument).unwrap();
    rig.machine().board_mut().set_adc_fault(Some(AdcFault::Dead));
    assert_eq!(rig.until_trip(instrument, 30).trip.cause, Cause::Missing);
    rig.machine().board_mut().set_adc_fault(None);
}

fn is_locked(instrument: &mut Serial<MachineStream>) -> bool {
    match instrument.command(Command::Acknowledge) {
        Ok(_) | Err(InstrumentError::Refused(Refusal::NotTripped)) => false,
        Err(InstrumentError::Refused(Refusal::LockedOut)) => true,
        Err(other) => panic!("{other}"),
    }
}

#[test]
fn three_trips_in_ten_minutes_lock_until_the_supply_or_the_reset_pin() {
    let rig = Rig::of(&heating(None));
    let mut instrument = rig.instrument();
    for _ in 0..2 {
        trip(&rig, &mut instrument);
        assert!(!is_locked(&mut instrument));
    }
    trip(&rig, &mut instrument);
    assert!(is_locked(&mut instrument));
    for source in [ResetSource::Software, ResetSource::Watchdog, ResetSource::BrownOut] {
        rig.machine().reset_by(source).unwrap();
        instrument = rig.instrument();
        assert!(is_locked(&mut instrument), "{source:?}");
    }
    let status = instrument.status().unwrap();
    assert!(status.locked && status.trips >= 3, "{status:?}");
    assert_eq!(status.first_trip.map(|first| first.cause), Some("missing"));
    for source in [ResetSource::Pin, ResetSource::PowerOn] {
        rig.machine().reset_by(source).unwrap();
        instrument = rig.instrument();
        let status = instrument.status().unwrap();
        assert!(!status.locked && status.trips == 0 && status.first_trip.is_none(), "{source:?}: {status:?}");
        start(&heating(None), &mut instrument).unwrap();
        Rig::observe(&mut instrument, 10, |sample| assert_eq!(sample.state, RunState::Running));
    }
    rig.assert_no_complaint();
}

/// Programs a board as a probe does: it resets and halts the core, runs its loader in RAM, and
/// resets once more.
fn flash_by_probe(rig: &Rig) {
    let mut machine = rig.machine();
    machine.reset_by(ResetSource::Software).unwrap();
    machine.board_mut().hold_core(true);
    machine.core_mut().write_memory(0x2000_0000, &[0x5a; 16 * 1024]).unwrap();
    machine.run_for(ms(5_000)).unwrap();
    machine.reset_by(ResetSource::Software).unwrap();
}

/// A crash of the firmware in between counts, and only that.
#[test]
fn a_probes_resets_trip_and_never_lock() {
    let rig = Rig::of(&heating(None));
    start(&heating(None), &mut rig.instrument()).unwrap();
    for flash in 0..10 {
        // Some of them while it heats.
        match flash {
            5 => fault(&mut rig.machine()),
            7 | 8 => rig.machine().reset_by(ResetSource::Software).unwrap(),
            _ => flash_by_probe(&rig),
        }
        rig.machine().run_for(ms(20)).unwrap();
        assert_eq!(rig.machine().board().heaters(), 0);
        let mut instrument = rig.instrument();
        let state = instrument.observe().unwrap().sample.state;
        let cause = if let RunState::Tripped(trip) = state { Some(trip.cause) } else { None };
        assert_eq!(cause, Some(if flash == 5 { Cause::Fault } else { Cause::Restart }), "flash {flash}");
        assert!(!is_locked(&mut instrument), "flash {flash}");
        start(&heating(None), &mut instrument).unwrap();
        Rig::observe(&mut instrument, 5, |sample| assert_eq!(sample.state, RunState::Running));
    }
    // The one crash has counted: two more lock.
    for is_last in [false, true] {
        fault(&mut rig.machine());
        let mut instrument = rig.instrument();
        assert_eq!(is_locked(&mut instrument), is_last);
    }
    rig.assert_no_complaint();
}

#[test]
fn without_a_host_the_heaters_are_low_after_its_timeout_unless_it_is_for_ever() {
    for (host_timeout_s, is_tripped) in [(Some(2.0), true), (Some(0.0), false)] {
        let rig = Rig::of(&heating(host_timeout_s));
        let mut instrument = rig.instrument();
        start(&heating(host_timeout_s), &mut instrument).unwrap();
        // A host that only listens shows once a second that it is there.
        Rig::observe(&mut instrument, 350, |sample| assert_eq!(sample.state, RunState::Running));
        let gone = rig.machine().now();
        rig.machine().run_for(ms(950)).unwrap();
        assert_eq!(rig.machine().board().witness.state(), Some(RunState::Running));
        rig.machine().run_for(ms(1_300)).unwrap();
        let tripped = match rig.machine().board().witness.state() {
            Some(RunState::Tripped(trip)) => Some(trip.cause),
            _ => None,
        };
        assert_eq!(tripped, is_tripped.then_some(Cause::HostTimeout));
        if is_tripped {
            let last = *rig.machine().pins().last().unwrap();
            // At the latest two ticks after the timeout, which began a second ago at most.
            assert!(last.levels == 0 && last.cycle - gone < ms(2_020), "{last:?} after {gone}");
        }
        rig.assert_no_complaint();
    }
}

fn keep(instrument: &mut Serial<MachineStream>, edit: impl FnOnce(&mut Settings, Option<&TestRecord>)) {
    let stored = settings::read_all(instrument).unwrap();
    let mut new = stored.settings.unwrap();
    edit(&mut new, stored.test_at_start.as_ref());
    settings::write(instrument, &new).unwrap();
}

/// Puts a head on the plug, and switches the board on. It sets itself up and tests itself.
fn plug_in(rig: &Rig, experiment: &Experiment) -> Serial<MachineStream> {
    rig.machine().board_mut().connect(SensorPlant::new(&experiment.sensor_config().unwrap()).unwrap());
    rig.machine().reset_by(ResetSource::PowerOn).unwrap();
    let instrument = rig.instrument();
    rig.machine().run_for(ms(3_000)).unwrap();
    instrument
}

#[test]
fn another_head_on_the_plug_is_refused_until_the_kept_one_is_back() {
    let own = heating(None);
    let mut other = heating(None);
    other.imperfections.resistance_error_percent = 5.0;
    let mut warmer = heating(None);
    (warmer.gas_temperature_c, warmer.support_temperature_c) = (-13.15, -3.15);
    let rig = Rig::of(&own);
    keep(&mut rig.instrument(), |new, _| new.set_head(&own.head, own.sample_period_s).unwrap());
    let mut instrument = plug_in(&rig, &own);
    keep(&mut instrument, |new, test| new.set("fingerprint", "measured", test).unwrap());
    for (on_the_plug, is_own) in [(&own, true), (&other, false), (&warmer, true)] {
        instrument = plug_in(&rig, on_the_plug);
        let at = rig.machine().now();
        let started = start(&own, &mut instrument);
        assert_eq!(started.is_ok(), is_own, "{started:?}");
        let is_high = rig.machine().pins().iter().any(|change| change.levels != 0 && change.cycle > at);
        if let Err(refused) = started {
            assert!(refused.to_string().contains("fingerprint"), "{refused}");
            assert!(!is_high, "no heater was ever high");
        }
    }
    rig.assert_no_complaint();
}
