//! A controller and its anemometer are told and ticked together.

extern crate std;

use super::*;
use crate::control::{Drive, ElementConfig, Limits, RunState, Trip};
use crate::digest::Digest;
use crate::error::Parameter;
use crate::model::{FasterGainsConfig, GainsConfig, NetworkCrossHeatingConfig, NetworkSelfHeatingConfig, mesh};
use crate::sensor::{Channel, Platinum};
use crate::wind::sphere;
use crate::wind::{HeadSurface, QualityFlags, WindCommand, WindOutputConfig};

const PERIOD_S: f32 = 1.0 / 1024.0;
const VOLT_PER_CODE: f32 = 4.0 / 8_388_608.0;
const REST_C: f32 = -53.0;
const GAS_C: f32 = -54.0;
const R_K_PER_W: f32 = 400.0;

fn own(r_k_per_w: f32) -> NetworkSelfHeatingConfig {
    let mut r = [0.0; 8];
    r[0] = r_k_per_w;
    let gains =
        GainsConfig { correction_w_per_k: [0.0; 8], convection_w_per_k: 0.2, weights: [1.0; 2], variance_w2: 1e-8 };
    let mesh_rad_s = mesh::geometric(1.0, 400.0).unwrap();
    NetworkSelfHeatingConfig { mesh_rad_s, r_k_per_w: r, surface: [1.0; 8], rest_c: REST_C, gains, alarm: None }
}

fn part(element: u8, gain: f32) -> WindCommand {
    let surface = sphere::hemispheres(0.01)[0];
    WindCommand::Surface { surface: 0, config: HeadSurface { element, surface, gain, windless_w_k: 0.0 } }
}

fn answer() -> WindCommand {
    WindCommand::Output(WindOutputConfig {
        surfaces: 1,
        diameter_m: 0.01,
        reynolds: None,
        direction_error_max_rad: 0.5,
        output_interval_ticks: 1,
        reference: None,
        smoothing_s: [0.0, 1.0 / 32.0],
        reference_gas_c: GAS_C,
    })
}

fn gas() -> WindCommand {
    WindCommand::Gas { pressure_pa: 700.0, temperature_c: Some(GAS_C) }
}

fn code(temperature_c: f32) -> Reading {
    Reading::Code((175.0 * (1.0 + 0.0031 * temperature_c) * 3e-3 / VOLT_PER_CODE).round() as i32)
}

/// Two elements of which one is a surface of a head, in standby.
fn instrument() -> Instrument<2> {
    let mut instrument = Instrument::new(&HardwareLimits::SIMULATED);
    let mut tell = |command| instrument.handle(command).unwrap();
    tell(Command::SamplePeriod { sample_period_s: PERIOD_S });
    let channel = Channel::new(Platinum::linear(175.0, 0.0031).unwrap(), VOLT_PER_CODE, 3e-3, 16e-3).unwrap();
    for element in 0..2 {
        tell(Command::Element { element, config: ElementConfig { channel, limits: Limits::SPHERE_B } });
        tell(Command::Drive { element, drive: Drive::Passive });
    }
    tell(Command::Wind(WindCommand::SelfHeating { element: 0, config: own(R_K_PER_W) }));
    for command in [part(0, 1.0), answer(), gas()] {
        tell(Command::Wind(command));
    }
    instrument
}

fn start(instrument: &mut Instrument<2>) {
    instrument.handle(Command::Arm { window_s: 1.0 }).unwrap();
    instrument.handle(Command::Start).unwrap();
}

fn sensed(instrument: &mut Instrument<2>) -> Option<WindTick> {
    let tick = instrument.tick(&[code(-50.0), code(-54.0)]);
    instrument.sense(&tick)
}

#[test]
fn an_answer_begins_with_what_the_low_level_gives() {
    let mut instrument = instrument();
    let told = sensed(&mut instrument).unwrap();
    // q = P − (T − rest)/R, with (3 mA)² of the resistance at −50 °C; over 4 K of overheat.
    let standing_w = 9e-6 * 175.0 * (1.0 - 0.0031 * 50.0);
    let truth = (standing_w - 3.0 / f64::from(R_K_PER_W)) / 4.0;
    // A code is 0.3 mK, of 3 K.
    assert!((f64::from(told.conductance_w_k[0]) / truth - 1.0).abs() < 1e-3, "{} for {truth}", told.conductance_w_k[0]);
    assert!(told.quality_flags.has(QualityFlags::NOT_RUNNING) && told.quality_flags.has(QualityFlags::UNCALIBRATED));
}

#[test]
fn a_start_begins_the_anemometer_anew() {
    let mut instrument = instrument();
    let starting =
        |instrument: &mut Instrument<2>| sensed(instrument).unwrap().quality_flags.has(QualityFlags::STARTING);
    // This head gets heat from the gas, so for three of its slowest seconds.
    assert!((0..3000).all(|_| starting(&mut instrument)));
    assert!(!(0..200).all(|_| starting(&mut instrument)) && !starting(&mut instrument));
    start(&mut instrument);
    assert!(starting(&mut instrument));
}

#[test]
fn another_period_or_another_head_is_forgotten_by_both() {
    for command in [Command::Clear, Command::SamplePeriod { sample_period_s: PERIOD_S }] {
        let mut instrument = instrument();
        assert!(sensed(&mut instrument).is_some());
        instrument.handle(command).unwrap();
        assert_eq!(instrument.estimator, Estimator::default(), "{command:?}");
        assert!(sensed(&mut instrument).is_none());
    }
    // A refused value changes nothing.
    let mut instrument = instrument();
    start(&mut instrument);
    assert_eq!(instrument.handle(Command::Clear), Err(Refusal::NotInStandby));
    assert!(sensed(&mut instrument).is_some());
}

#[test]
fn a_refusal_names_the_element_that_it_is_about() {
    let mut instrument = instrument();
    let gains = own(R_K_PER_W).gains;
    let cross = NetworkCrossHeatingConfig {
        from: 0,
        to: 1,
        mesh_rad_s: [1.0, 2.0, 3.0, 4.0],
        r_k_per_w: [0.0; 4],
        surface: [1.0; 4],
    };
    let faster = FasterGainsConfig { element: 1, set: 0, until_s: 1.0, gains };
    let pressure = WindCommand::Gas { pressure_pa: 0.0, temperature_c: None };
    for (command, named, parameter) in [
        (WindCommand::SelfHeating { element: 1, config: own(-1.0) }, Some(1), Parameter::ResistanceKPerW),
        (WindCommand::FasterGains(faster), Some(1), Parameter::PartElement),
        (WindCommand::CrossHeating(cross), Some(1), Parameter::PartElement),
        (part(1, 1.0), Some(1), Parameter::PartElement),
        (part(0, 0.0), Some(0), Parameter::PartGain),
        (pressure, None, Parameter::PressurePa),
    ] {
        match instrument.handle(Command::Wind(command)) {
            Err(Refusal::Invalid { element, error }) => assert_eq!((element, error.parameter), (named, parameter)),
            other => panic!("{command:?}: {other:?}"),
        }
    }
}

#[test]
fn a_head_is_described_in_standby_and_its_gas_at_any_time() {
    let mut instrument = instrument();
    start(&mut instrument);
    assert_eq!(instrument.handle(Command::Wind(answer())), Err(Refusal::NotInStandby));
    instrument.handle(Command::Wind(gas())).unwrap();
    instrument.trip(Cause::Deadline);
    let trip = Trip::whole(Cause::Deadline);
    assert_eq!(instrument.controller().state(), RunState::Tripped(trip));
    assert_eq!(instrument.handle(Command::Wind(answer())), Err(Refusal::Tripped(trip)));
    instrument.handle(Command::Wind(gas())).unwrap();
    assert_eq!(
        Instrument::<2>::new(&HardwareLimits::SIMULATED).handle(Command::Wind(gas())),
        Err(Refusal::NoSamplePeriod)
    );
}

#[test]
fn the_two_digests_are_of_decision_and_of_wind() {
    let mut instrument = instrument();
    let tick = instrument.tick(&[code(-50.0), code(-54.0)]);
    let told = instrument.sense(&tick);
    let (mut with, mut without) = (RunDigests::default(), RunDigests::default());
    instrument.digest(&tick, told.as_ref(), &mut with);
    instrument.digest(&tick, None, &mut without);
    assert_eq!(with.control, without.control);
    assert!(with.wind != without.wind && without.wind != Digest::default(), "the network has its share");
}

#[test]
fn ticks_that_got_lost_leave_the_estimate_starting() {
    let mut instrument = instrument();
    start(&mut instrument);
    while sensed(&mut instrument).unwrap().quality_flags.has(QualityFlags::STARTING) {}
    let tick = instrument.tick(&[code(-50.0), code(-54.0)]);
    let mut of_next = |follows_gap| {
        let estimated = instrument.estimator.take(&instrument.decider.handover(&tick, follows_gap));
        estimated.wind.unwrap().quality_flags.has(QualityFlags::STARTING)
    };
    assert!(!of_next(false) && of_next(true) && of_next(false));
}

#[test]
fn a_bit_that_flips_in_the_estimator_trips_once_and_is_counted() {
    let mut instrument = instrument();
    start(&mut instrument);
    instrument.estimator.flip_a_setting();
    let flips = |instrument: &mut Instrument<2>| {
        sensed(instrument);
        instrument.controller().bit_flips()
    };
    // Pieces are verified in turn.
    let counts: std::vec::Vec<u32> = (0..1000).map(|_| flips(&mut instrument)).collect();
    assert_eq!((counts[0], counts[999]), (0, 1));
    let trip = Trip::whole(Cause::BitFlip);
    assert_eq!(instrument.controller().state(), RunState::Tripped(trip));
    instrument.handle(Command::Acknowledge).unwrap();
    assert_eq!(instrument.estimator, Estimator::default(), "it cannot be located: all settings are void");
}

#[test]
fn a_command_does_not_cover_a_flipped_bit() {
    let mut instrument = instrument();
    instrument.estimator.flip_a_setting();
    let refusal = Refusal::Tripped(Trip::whole(Cause::BitFlip));
    assert_eq!(instrument.handle(Command::Wind(answer())), Err(refusal));
    assert_eq!((instrument.handle(Command::Start), instrument.controller().bit_flips()), (Err(refusal), 1));
}
