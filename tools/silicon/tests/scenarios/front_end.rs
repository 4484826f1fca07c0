//! The converter and the heaters' pins: what is wrong there is noticed, named and counted.

use crate::rig::{Rig, experiment};
use dr_core::Command;
use dr_core::control::{Cause, Drive, RunState};
use dr_core::sensor::Level;
use host_sim::experiment::Experiment;
use host_sim::instrument::InstrumentPort;
use host_sim::instrument::serial::Serial;
use host_sim::run::start;
use silicon::adc::AdcFault;
use silicon::complaint::BrokenRule;
use silicon::machine::MachineConfig;
use silicon::stream::MachineStream;
use silicon::time::{ms, us};

/// The converter's threshold of its comparators, which nothing else depends on.
const FAULT_REGISTER: usize = 4;

/// A run at 10 ms a tick that has heated for five of them.
fn heating() -> (Rig, Serial<MachineStream>) {
    let experiment = Experiment { sample_period_s: 0.01, ..experiment("held.toml", 100) };
    let rig = Rig::of(&experiment);
    let mut instrument = rig.instrument();
    start(&experiment, &mut instrument).unwrap();
    Rig::observe(&mut instrument, 5, |_| {});
    assert_eq!(rig.machine().board().heaters(), 1);
    (rig, instrument)
}

/// The cause of a trip that comes within `limit_ms`.
fn trip_within(rig: &Rig, limit_ms: u64) -> Option<Cause> {
    rig.machine().run_for(ms(limit_ms)).unwrap();
    match rig.machine().board().witness.state() {
        Some(RunState::Tripped(trip)) => Some(trip.cause),
        _ => None,
    }
}

/// All heaters are low, so nothing but a clock that goes on in sleep shows the silence.
#[test]
fn a_converter_that_falls_silent_is_noticed_without_the_debuggers_clock() {
    let mut experiment = Experiment { sample_period_s: 0.01, ..experiment("held.toml", 100) };
    experiment.drives[0] = Drive::Level(Level::Low);
    let rig = Rig::of(&experiment);
    let mut instrument = rig.instrument();
    start(&experiment, &mut instrument).unwrap();
    rig.machine().board_mut().forbid_debug_sleep();
    Rig::observe(&mut instrument, 5, |_| {});
    rig.machine().board_mut().set_adc_fault(Some(AdcFault::Silent));
    assert_eq!(trip_within(&rig, 80), Some(Cause::Missing));
    rig.assert_no_complaint();
}

/// While models are taken in, the control task comes to some conversions so late that the next one
/// would be there before the frame is out: they are not read.
#[test]
fn conversions_that_are_served_too_late_are_dropped_and_counted() {
    let experiment = experiment("steady.toml", 10);
    let rig = Rig::new(&MachineConfig { sensor: experiment.sensor_config().unwrap(), oscillator_hz: None });
    let mut instrument = rig.instrument();
    start(&experiment, &mut instrument).unwrap();
    rig.machine().run_for(ms(1_200)).unwrap();
    let status = Box::new(instrument).finish().unwrap().status.unwrap();
    assert!((1..100).contains(&status.control.lost_conversions), "{}", status.control.lost_conversions);
    rig.assert_no_complaint();
}

/// A debugger holds the core in the middle of a frame for two conversions: what is left of the
/// frame is the last one's, which is not read a second time.
#[test]
fn a_frame_that_was_torn_is_dropped_with_the_conversion_that_tore_it() {
    let rig = Rig::of(&experiment("held.toml", 10));
    let instrument = rig.instrument();
    for k in 0..200 {
        rig.machine().run_for(ms(2) + us(7 * k % 250)).unwrap();
        rig.machine().board_mut().hold_core(true);
        rig.machine().run_for(us(500)).unwrap();
        rig.machine().board_mut().hold_core(false);
    }
    rig.machine().run_for(ms(1_200)).unwrap();
    let complaints = rig.complaints();
    let [torn] = complaints.as_slice() else { panic!("{complaints:?}") };
    assert!(torn.rule == BrokenRule::AdcFrameAcrossUpdate && torn.times > 5, "{torn}");
    // Two conversions for a hold that tore one, at least one for any other.
    let status = Box::new(instrument).finish().unwrap().status.unwrap();
    assert!(
        status.control.lost_conversions >= 200 + torn.times,
        "{} of {}",
        status.control.lost_conversions,
        torn.times
    );
}

/// The same in the middle of a read-back of the registers, where no frame is made of a conversion.
#[test]
fn a_conversion_that_came_while_registers_were_read_is_dropped() {
    let (rig, instrument) = heating();
    for phase_us in 0..40 {
        while rig.machine().board().adc.streams() {
            rig.machine().run_for(us(1)).unwrap();
        }
        rig.machine().run_for(us(phase_us)).unwrap();
        rig.machine().board_mut().hold_core(true);
        rig.machine().run_for(us(500)).unwrap();
        rig.machine().board_mut().hold_core(false);
        rig.machine().run_for(ms(1)).unwrap();
    }
    rig.machine().run_for(ms(1_200)).unwrap();
    let status = Box::new(instrument).finish().unwrap().status.unwrap();
    assert!((40..200).contains(&status.control.lost_conversions), "{}", status.control.lost_conversions);
    rig.assert_no_complaint();
}

#[test]
fn a_dead_data_line_is_counted() {
    let (rig, instrument) = heating();
    rig.machine().board_mut().set_adc_fault(Some(AdcFault::Dead));
    rig.machine().run_for(ms(2_000)).unwrap();
    // Limit of 4 000 a second, until the last status.
    let status = Box::new(instrument).finish().unwrap().status.unwrap();
    let conversions = rig.machine().board().adc.conversions;
    assert!(
        (3_900..conversions).contains(&status.control.lost_conversions.into()),
        "{}",
        status.control.lost_conversions
    );
    rig.assert_no_complaint();
}

#[test]
fn a_converter_that_never_converts_is_refused_at_the_start_by_name() {
    let rig = Rig::new(&MachineConfig::default());
    rig.machine().board_mut().set_adc_fault(Some(AdcFault::Silent));
    assert_eq!(rig.instrument().identity().starts, 1);
    let log = rig.machine().log();
    assert!(log.iter().any(|line| line.contains("the ADC did not start: NoConversion")), "{log:?}");
    rig.assert_no_complaint();
}

/// Registers are read back every 250 conversions, 62.5 ms.
#[test]
fn a_register_of_the_converter_that_changes_trips_until_it_is_right_again() {
    let (rig, mut instrument) = heating();
    let good = 0;
    rig.machine().board_mut().disturb_adc(FAULT_REGISTER, 0x40);
    let at = rig.machine().now();
    assert_eq!(trip_within(&rig, 90), Some(Cause::AdcRegister));
    let last = *rig.machine().pins().last().unwrap();
    assert!(last.levels == 0 && last.cycle - at < ms(63), "{last:?} after {at}");
    instrument.command(Command::Acknowledge).unwrap();
    assert_eq!(trip_within(&rig, 90), Some(Cause::AdcRegister));
    rig.machine().board_mut().disturb_adc(FAULT_REGISTER, good);
    rig.machine().run_for(ms(70)).unwrap();
    instrument.command(Command::Acknowledge).unwrap();
    assert_eq!(trip_within(&rig, 200), None);
    rig.assert_no_complaint();
}

#[test]
fn a_heater_pin_that_a_short_holds_is_seen_at_the_next_tick() {
    // Another one high, and the one that heats low.
    for (high, low) in [(0b10, 0), (0, 0b01)] {
        let (rig, mut instrument) = heating();
        let at = rig.machine().now();
        rig.machine().board_mut().short_heaters(high, low);
        assert_eq!(trip_within(&rig, 30), Some(Cause::Heater));
        // A pin that no short holds is low within a tick.
        let last = *rig.machine().pins().last().unwrap();
        assert!(u32::from(last.levels) == high && last.cycle - at < ms(11), "{last:?} after {at}");
        // While it is there, it trips again.
        instrument.command(Command::Acknowledge).unwrap();
        assert_eq!(trip_within(&rig, 30), (high != 0).then_some(Cause::Heater));
        rig.machine().board_mut().short_heaters(0, 0);
        instrument.command(Command::Acknowledge).ok();
        assert_eq!(trip_within(&rig, 30), None);
        rig.assert_no_complaint();
    }
}
