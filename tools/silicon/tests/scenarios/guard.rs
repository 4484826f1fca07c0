//! Causes of the guard's trips, from the pins to the report, and how long heaters stay high.
//!
//! Causes that are not here: panic, fault and watchdog (`crashes`), brown-out (`supply`). A number
//! that is none (`NonFinite`) cannot be made of codes and a head that was accepted, but by a flip
//! of a bit, which is found first.

use crate::crashes::heat;
use crate::rig::{EndOfRun, Rig, experiment};
use dr_core::control::{Cause, Drive, ElementConfig, EnergyLimit, GuardConfig, Limits, Refusal, RunState};
use dr_core::sensor::{Channel, Level, Platinum};
use dr_core::{Command, Parameter};
use host_sim::experiment::Experiment;
use host_sim::instrument::{InstrumentError, InstrumentPort, setup};
use host_sim::run::{setup_of, start};
use host_sim::sensor::{ResistorFault, TimedFault};
use silicon::adc::AdcFault;
use silicon::time::{ms, us};

/// A cold sector that is heated in every tick of 10 ms.
fn heating() -> Experiment {
    Experiment { sample_period_s: 0.01, ..experiment("held.toml", 1_000) }
}

/// Runs it for ten ticks, then has the converter fail; returns when that was, and the end.
fn with_adc_fault(fault: AdcFault, guard: Option<GuardConfig>) -> (u64, EndOfRun) {
    let experiment = heating();
    let rig = Rig::of(&experiment);
    let mut instrument = rig.instrument();
    let mut commands = setup_of(&experiment).unwrap();
    commands.extend(guard.map(Command::Guard));
    setup::start(&mut instrument, &commands).unwrap();
    Rig::observe(&mut instrument, 10, |_| {});
    rig.machine().board_mut().set_adc_fault(Some(fault));
    let at = rig.machine().now();
    let end = rig.until_trip(&mut instrument, 20);
    rig.assert_no_complaint();
    (at, end)
}

#[test]
fn a_silent_converter_lowers_the_heaters_by_the_dead_man_timer() {
    let (at, end) = with_adc_fault(AdcFault::Silent, None);
    assert_eq!(end.trip.cause, Cause::Deadline);
    // Two ticks and half a millisecond after levels were last decided, at most a tick before.
    assert!(end.low_since - at < ms(21), "{}", end.low_since - at);
    // Three ticks and the 50 ms of the health task.
    assert!(end.cycle - at < ms(80), "{}", end.cycle - at);
}

/// The store that clears the timer's flag is still on its way when a handler ends with it.
#[test]
fn the_dead_man_timer_is_handled_once_each_time_that_it_expires() {
    let rig = Rig::of(&heating());
    heat(&rig);
    let mut instrument = rig.instrument();
    rig.machine().board_mut().set_adc_fault(Some(AdcFault::Silent));
    rig.machine().run_for(ms(100)).unwrap();
    assert_eq!(instrument.status().unwrap().deadlines, 1);
    rig.assert_no_complaint();
}

/// The health task looks twenty times a second, and may find a tick just over whose last
/// conversions never came.
#[test]
fn a_converter_that_falls_silent_at_any_moment_leaves_no_heater_high_for_two_ticks() {
    let rig = Rig::of(&heating());
    heat(&rig);
    let heated = rig.machine().snapshot().unwrap();
    for moment in 0..60 {
        rig.machine().restore(&heated).unwrap();
        rig.machine().run_for(us(870) * moment).unwrap();
        rig.machine().board_mut().set_adc_fault(Some(AdcFault::Silent));
        rig.machine().run_for(ms(100)).unwrap();
        assert_eq!(rig.machine().board().heaters(), 0, "moment {moment}");
        rig.assert_no_complaint();
    }
}

/// A conversion or two that nobody reads make a mean of fewer; what lasts a tick trips.
#[test]
fn a_silence_of_half_a_millisecond_is_borne_and_one_of_thirty_is_not() {
    let rig = Rig::of(&heating());
    heat(&rig);
    let heated = rig.machine().snapshot().unwrap();
    for (silence, expected) in [(us(500), None), (ms(30), Some(Cause::Deadline))] {
        rig.machine().restore(&heated).unwrap();
        rig.machine().board_mut().set_adc_fault(Some(AdcFault::Silent));
        rig.machine().run_for(silence).unwrap();
        rig.machine().board_mut().set_adc_fault(None);
        rig.machine().run_for(ms(100)).unwrap();
        let state = rig.machine().board().witness.state();
        let cause = if let Some(RunState::Tripped(trip)) = state { Some(trip.cause) } else { None };
        assert_eq!(cause, expected, "{state:?}");
        rig.assert_no_complaint();
    }
}

/// A converter that falls silent right after its first high level: nothing decides anew, and the
/// pin falls after the timeout, to a half of what one more in the timer's prescaler makes of it.
#[test]
fn the_dead_man_timer_counts_microseconds() {
    let experiment = heating();
    let rig = Rig::of(&experiment);
    let mut instrument = rig.instrument();
    start(&experiment, &mut instrument).unwrap();
    let begin = rig.machine().now();
    while rig.machine().board().heaters() == 0 {
        rig.machine().run_for(us(50)).unwrap();
        assert!(rig.machine().now() < begin + ms(50), "nothing is heated");
    }
    rig.machine().board_mut().set_adc_fault(Some(AdcFault::Silent));
    rig.machine().run_for(ms(30)).unwrap();
    let machine = rig.machine();
    let [.., rise, fall] = machine.pins() else { panic!("no heater has moved") };
    assert_eq!((rise.levels, fall.levels), (1, 0));
    // Seven quarters of a tick of 10 ms; 84 counts a microsecond.
    let timeout = us(17_500);
    assert!((fall.cycle - rise.cycle).abs_diff(timeout) < timeout / 168, "{}", fall.cycle - rise.cycle);
}

#[test]
fn a_dead_data_line_is_a_missing_reading() {
    let (at, end) = with_adc_fault(AdcFault::Dead, None);
    assert_eq!(end.trip.cause, Cause::Missing);
    // The tick in which it fails still has readings; the next one has none, and is low.
    assert!(end.low_since - at < ms(21), "{}", end.low_since - at);
}

#[test]
fn garbage_trips_whatever_it_looks_like() {
    // One frame of 16 has its mark by chance, and any codes: a mean of them is no temperature.
    let (at, end) = with_adc_fault(AdcFault::Garbage, None);
    let looks_like =
        [Cause::Missing, Cause::Stale, Cause::Short, Cause::Open, Cause::OutOfRange, Cause::OverTemperature];
    assert!(looks_like.contains(&end.trip.cause), "{:?}", end.trip.cause);
    assert!(end.low_since - at < ms(31), "{}", end.low_since - at);
}

#[test]
fn a_converter_that_repeats_itself_is_stuck() {
    let guard = GuardConfig { stuck_limit_ticks: 5, ..GuardConfig::default() };
    let (at, end) = with_adc_fault(AdcFault::Stuck, Some(guard));
    assert_eq!(end.trip.cause, Cause::Stuck);
    assert!(end.low_since - at < ms(10 * (5 + 3)), "{}", end.low_since - at);
}

#[test]
fn a_resistor_that_breaks_trips_within_a_tick() {
    let faults = [(ResistorFault::Open, Cause::Open), (ResistorFault::Shorted, Cause::Short)];
    for (fault, cause) in faults {
        let start_s = 0.3;
        let experiment = Experiment { faults: vec![TimedFault { element: 0, fault, start_s }], ..heating() };
        let rig = Rig::of(&experiment);
        // The sensor's time begins as it is connected.
        let broke_at = rig.machine().now() + ms(300);
        let mut instrument = rig.instrument();
        start(&experiment, &mut instrument).unwrap();
        let end = rig.until_trip(&mut instrument, 60);
        assert_eq!((end.trip.cause, end.trip.element), (cause, Some(0)));
        // At the next tick: its conversions are 10 ms old at the most.
        assert!((broke_at..broke_at + ms(21)).contains(&end.low_since), "{fault:?}: {}", end.low_since);
        rig.assert_no_complaint();
    }
}

#[test]
fn an_element_above_its_limit_and_a_set_point_out_of_reach_trip() {
    let mut experiment = heating();
    experiment.drives[0] = Drive::Level(Level::High);
    let start_c = experiment.sensor().unwrap().truth().element_temperature_c[0] as f32;
    let hot = |command: &mut Command| {
        if let Command::Element { config, .. } = command {
            config.limits.temperature_max_c = start_c + 0.5;
        }
    };
    let rig = Rig::of(&experiment);
    let mut instrument = rig.instrument();
    let mut commands = setup_of(&experiment).unwrap();
    commands.iter_mut().for_each(hot);
    setup::start(&mut instrument, &commands).unwrap();
    assert_eq!(rig.until_trip(&mut instrument, 500).trip.cause, Cause::OverTemperature);
    rig.assert_no_complaint();

    let experiment = heating();
    let rig = Rig::of(&experiment);
    let mut instrument = rig.instrument();
    let mut commands = setup_of(&experiment).unwrap();
    commands.push(Command::Guard(GuardConfig {
        unreachable_limit_ticks: 20,
        stuck_limit_ticks: 200,
        ..GuardConfig::default()
    }));
    setup::start(&mut instrument, &commands).unwrap();
    assert_eq!(rig.until_trip(&mut instrument, 40).trip.cause, Cause::Unreachable);
    rig.assert_no_complaint();
}

#[test]
fn inputs_at_the_lower_end_of_their_range_are_out_of_range() {
    let (at, end) = with_adc_fault(AdcFault::LowEnd, None);
    assert_eq!(end.trip.cause, Cause::OutOfRange);
    assert!(end.low_since - at < ms(21), "{}", end.low_since - at);
}

#[test]
fn a_bit_that_flips_in_a_limit_trips() {
    // A limit that stands nowhere else in memory.
    const MARK_C: f32 = 61.3125;
    let experiment = heating();
    let rig = Rig::of(&experiment);
    let mut instrument = rig.instrument();
    let mut commands = setup_of(&experiment).unwrap();
    for command in &mut commands {
        if let Command::Element { config, .. } = command {
            config.limits.temperature_max_c = MARK_C;
        }
    }
    setup::start(&mut instrument, &commands).unwrap();
    Rig::observe(&mut instrument, 5, |_| {});
    let ram = rig.machine().core_mut().ram().unwrap();
    let places = ram.windows(4).enumerate().filter(|(_, bytes)| **bytes == MARK_C.to_le_bytes());
    let places: Vec<u32> = places.map(|(offset, _)| 0x2000_0000 + offset as u32).collect();
    assert!(!places.is_empty());
    for place in places {
        rig.machine().core_mut().write_memory(place, &[MARK_C.to_le_bytes()[0] ^ 1]).unwrap();
    }
    let end = rig.until_trip(&mut instrument, 10);
    assert_eq!(end.trip.cause, Cause::BitFlip);
    rig.assert_no_complaint();
}

/// A converter that repeats itself, before a guard that is as lax as the board allows.
#[test]
fn a_reading_that_the_high_level_does_not_raise_trips_within_a_quarter_of_the_process_safety_time() {
    let experiment = Experiment { sample_period_s: 0.1, ..experiment("held.toml", 1_000) };
    let rig = Rig::of(&experiment);
    let mut instrument = rig.instrument();
    let mut commands = setup_of(&experiment).unwrap();
    let lax = GuardConfig { missing_limit_ticks: u32::MAX, unreachable_limit_ticks: u32::MAX, stuck_limit_ticks: 1000 };
    commands.push(Command::Guard(lax));
    setup::start(&mut instrument, &commands).unwrap();
    Rig::observe(&mut instrument, 5, |_| {});
    rig.machine().board_mut().set_adc_fault(Some(AdcFault::Stuck));
    let at = rig.machine().now();
    let end = rig.until_trip(&mut instrument, 240);
    assert_eq!((end.trip.cause, end.trip.element), (Cause::Unreachable, Some(0)));
    assert!((ms(21_900)..ms(22_800)).contains(&(end.low_since - at)), "{}", end.low_since - at);
    rig.assert_no_complaint();
}

#[test]
fn what_is_laxer_than_the_board_is_refused_by_name() {
    let experiment = heating();
    let rig = Rig::of(&experiment);
    let mut instrument = rig.instrument();
    let commands = setup_of(&experiment).unwrap();
    let good = commands.iter().find_map(|command| match *command {
        Command::Element { element: 0, config } => Some(config),
        _ => None,
    });
    let good = good.unwrap();
    let limits = |limits: Limits| ElementConfig { limits, ..good };
    let channel = |r0_ohm: f32, volt: f32, low_a: f32, high_a: f32| {
        let platinum = Platinum::linear(r0_ohm, 0.0031).unwrap();
        ElementConfig { channel: Channel::new(platinum, volt, low_a, high_a).unwrap(), ..good }
    };
    let volt = good.channel.volt(1.0);
    let lax = [
        (limits(Limits { temperature_max_c: 250.0, ..good.limits }), Parameter::TemperatureMaxC),
        (limits(Limits { resistance_max_ohm: 330.0, ..good.limits }), Parameter::ResistanceMaxOhm),
        (
            limits(Limits { energy: Some(EnergyLimit { sustained_power_w: 0.1, energy_j: 1.0 }), ..good.limits }),
            Parameter::SustainedPowerW,
        ),
        (channel(1e6, volt, 3e-3, 16e-3), Parameter::Resistance0cOhm),
        (channel(190.0, volt, 3e-3, 16e-3), Parameter::TemperatureMaxC),
        (channel(175.0, 2.0 * volt, 3e-3, 16e-3), Parameter::VoltPerCode),
        (channel(175.0, volt, 15.9e-3, 16e-3), Parameter::CurrentLowA),
        (channel(175.0, volt, 3e-3, 20e-3), Parameter::CurrentHighA),
    ];
    for (config, parameter) in lax {
        match instrument.command(Command::Element { element: 0, config }) {
            Err(InstrumentError::Refused(Refusal::Invalid { element: Some(0), error })) => {
                assert_eq!(error.parameter, parameter)
            }
            other => panic!("{parameter:?}: {other:?}"),
        }
    }
    let never = GuardConfig { stuck_limit_ticks: 0, ..GuardConfig::default() };
    assert!(matches!(
        instrument.command(Command::Guard(never)),
        Err(InstrumentError::Refused(Refusal::Invalid { error, .. })) if error.parameter == Parameter::StuckLimitTicks
    ));
    assert!(matches!(
        instrument.command(Command::SamplePeriod { sample_period_s: 2.0 }),
        Err(InstrumentError::Refused(Refusal::Invalid { error, .. })) if error.parameter == Parameter::SamplePeriodS
    ));
    rig.assert_no_complaint();
}
