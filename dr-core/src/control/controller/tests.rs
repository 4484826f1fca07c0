extern crate std;

use super::*;
use crate::control::Refusal;
use crate::control::energy::EnergyLimit;
use crate::control::guard::Limits;
use crate::control::state::ElementConfig;
use crate::error::Parameter;
use crate::model::SelfHeatingConfig;
use crate::model::mesh;
use crate::sensor::Platinum;
use crate::{Command, Digest, Reply};
use std::vec::Vec;

mod arming;
mod bit_flips;
mod capacitor;
mod elements;
mod hardware;
mod lock_out;
mod messages;
mod observing;
mod other_head;
mod powers;
mod probes;

const VOLT_PER_CODE: f32 = 4.0 / 8_388_608.0;

fn element() -> ElementConfig {
    ElementConfig {
        channel: Channel::new(Platinum::linear(175.0, 0.0031).unwrap(), VOLT_PER_CODE, 3e-3, 16e-3).unwrap(),
        limits: Limits { energy: Some(EnergyLimit { sustained_power_w: 0.05, energy_j: 12.0 }), ..Limits::SPHERE_B },
    }
}

fn model() -> SelfHeatingConfig {
    SelfHeatingConfig {
        mesh_rad_s: mesh::geometric(0.003, 30.0).unwrap(),
        r_k_per_w: [600.0, 20.0, 5.0, 2.0, 1.0, 0.0, 0.0, 0.0],
        reference_c: -50.0,
    }
}

/// The code of a resistor at a temperature while the given level is on.
fn code(temperature_c: f32, high: bool) -> Reading {
    let volt = 175.0 * (1.0 + 0.0031 * f64::from(temperature_c)) * if high { 16e-3 } else { 3e-3 };
    Reading::Code((volt / f64::from(VOLT_PER_CODE)) as i32)
}

/// Arms and starts.
fn start<const N: usize>(controller: &mut Controller<N>) -> Result<Reply, Refusal> {
    controller.handle(Command::Arm { window_s: 1.0 })?;
    controller.handle(Command::Start)
}

/// A controller of two elements with these drives, running.
fn running(drives: [Drive; 2]) -> Controller<2> {
    let mut controller = Controller::new(&HardwareLimits::SIMULATED);
    controller.handle(Command::SamplePeriod { sample_period_s: 0.01 }).unwrap();
    for (element_index, drive) in drives.into_iter().enumerate() {
        let element_index = element_index as u8;
        controller.handle(Command::Element { element: element_index, config: element() }).unwrap();
        controller.handle(Command::Model { element: element_index, model: model() }).unwrap();
        controller.handle(Command::Drive { element: element_index, drive }).unwrap();
    }
    start(&mut controller).unwrap();
    controller
}

/// A first-order body per element: 600 K/W, 2 s.
#[derive(Clone)]
struct TestBody {
    temperature_c: [f32; 2],
    heaters: Heaters,
}

impl TestBody {
    fn readings(&self) -> [Reading; 2] {
        [0, 1].map(|i| code(self.temperature_c[i], self.heaters.is_high(i)))
    }

    fn live(&mut self, tick: &Tick<2>) {
        self.heaters = tick.heaters;
        for (temperature, power_w) in self.temperature_c.iter_mut().zip(tick.power_w) {
            *temperature += 0.005 * (-50.0 + 600.0 * power_w - *temperature);
        }
    }
}

#[test]
fn holds_a_temperature_and_reports_the_power_it_takes() {
    let mut controller = running([Drive::Temperature { target_c: -30.0 }, Drive::Passive]);
    let mut body = TestBody { temperature_c: [-50.0; 2], heaters: Heaters::default() };
    let (mut energy, mut heat) = (0.0, 0.0);
    for n in 0..20_000 {
        let tick = controller.tick(&body.readings());
        if n >= 10_000 {
            energy += f64::from(tick.power_w[0]);
            heat += f64::from(tick.temperature_c[0]);
        }
        body.live(&tick);
    }
    // one tick at full power moves this light body by 0.12 K; the mean lies well inside
    assert!((heat / 10_000.0 + 30.0).abs() < 0.06, "{}", heat / 10_000.0);
    // 20 K over 600 K/W, less what the mean temperature is off
    assert!((energy / 10_000.0 - 20.0 / 600.0).abs() < 1e-4);
    assert!((body.temperature_c[1] + 49.1).abs() < 0.1, "the low level warms a passive element by 0.9 K");
}

#[test]
fn power_is_that_of_the_level_just_decided() {
    let mut controller = running([Drive::Level(Level::High), Drive::Passive]);
    let tick = controller.tick(&[code(0.0, false), code(0.0, false)]);
    assert_eq!(tick.heaters, Heaters(0b01));
    // codes are truncated: up to one in 10⁶ of the resistance at the low level
    assert!((tick.power_w[0] - 0.0448).abs() < 1e-7 && (tick.power_w[1] - 0.001575).abs() < 1e-8);
}

#[test]
fn every_fault_trips_within_its_tick_and_stays() {
    for (bad, cause) in [
        (Reading::Code(8_388_607), Cause::Open),
        (Reading::Code(3), Cause::Short),
        (Reading::Code(-8_388_608), Cause::OutOfRange),
        (code(80.0, true), Cause::OverTemperature),
    ] {
        let mut controller = running([Drive::Level(Level::High), Drive::Level(Level::High)]);
        assert_eq!(controller.tick(&[code(0.0, false); 2]).heaters, Heaters(0b11));
        let tick = controller.tick(&[code(0.0, true), bad]);
        assert_eq!(tick.heaters, Heaters(0), "{cause:?}");
        assert_eq!(tick.trip, Some(Trip::of(1, cause)));
        let later = controller.tick(&[code(0.0, false); 2]);
        assert_eq!((later.heaters, later.trip), (Heaters(0), None));
        assert_eq!(later.state, RunState::Tripped(Trip::of(1, cause)));
        assert_eq!(start(&mut controller), Err(Refusal::Tripped(Trip::of(1, cause))));
        controller.handle(Command::Acknowledge).unwrap();
        start(&mut controller).unwrap();
        assert_eq!(controller.tick(&[code(0.0, false); 2]).heaters, Heaters(0b11));
    }
}

#[test]
fn a_fault_in_standby_trips_too() {
    let mut controller = running([Drive::Passive, Drive::Passive]);
    controller.handle(Command::Stop).unwrap();
    assert!(matches!(controller.tick(&[Reading::Code(0), code(0.0, false)]).state, RunState::Tripped(_)));
}

#[test]
fn a_missing_reading_is_borne_at_the_low_level_only_so_long() {
    for (absent, cause) in [(Reading::Missing, Cause::Missing), (Reading::Stale, Cause::Stale)] {
        let mut controller = running([Drive::Level(Level::High), Drive::Level(Level::High)]);
        let first = controller.tick(&[code(5.0, false); 2]);
        let gap = controller.tick(&[absent, code(5.0, true)]);
        assert_eq!((gap.heaters, gap.valid, gap.state), (Heaters(0b10), 0b10, RunState::Running));
        assert_eq!(gap.temperature_c[0], first.temperature_c[0]);
        let back = controller.tick(&[code(5.0, false), code(5.0, true)]);
        assert_eq!(back.heaters, Heaters(0b11));
        controller.tick(&[absent, code(5.0, true)]);
        assert_eq!(controller.tick(&[absent, code(5.0, true)]).trip, Some(Trip::of(0, cause)));
    }
}

#[test]
fn a_set_point_that_is_never_met_trips_in_the_end() {
    let mut controller = running([Drive::Temperature { target_c: -30.0 }, Drive::Passive]);
    controller.handle(Command::Stop).unwrap();
    controller.handle(Command::Guard(GuardConfig { unreachable_limit_ticks: 50, ..GuardConfig::default() })).unwrap();
    start(&mut controller).unwrap();
    let mut ticks = 0;
    let trip = loop {
        let high = ticks > 0;
        let tick = controller.tick(&[code(-40.0, high), code(-40.0, false)]);
        ticks += 1;
        if tick.trip.is_some() {
            break tick.trip;
        }
        assert!(ticks < 100);
    };
    assert_eq!(trip, Some(Trip::of(0, Cause::Unreachable)));
    // the first tick changes the level, then 50 are borne
    assert_eq!(ticks, 52);
}

/// A support warms it, or another element does: nothing is in danger, and the run has a use for it.
#[test]
fn an_element_that_is_too_warm_without_its_heater_does_not_trip() {
    let mut controller = running([Drive::Temperature { target_c: -30.0 }, Drive::Passive]);
    controller.handle(Command::Stop).unwrap();
    controller.handle(Command::Guard(GuardConfig { unreachable_limit_ticks: 50, ..GuardConfig::default() })).unwrap();
    start(&mut controller).unwrap();
    for _ in 0..200 {
        let tick = controller.tick(&[code(-20.0, false), code(-40.0, false)]);
        assert_eq!((tick.trip, tick.heaters), (None, Heaters(0)));
    }
    // From where it is too cold on, the whole time is borne again.
    let borne = (0..100).take_while(|&n| controller.tick(&[code(-40.0, n > 0), code(-40.0, false)]).trip.is_none());
    assert_eq!(borne.count(), 51);
}

#[test]
fn unreachable_set_points_are_refused_by_the_model() {
    let mut controller = running([Drive::Passive, Drive::Passive]);
    controller.handle(Command::Arm { window_s: 1.0 }).unwrap();
    for target_c in [-49.9, 20.0] {
        let refusal =
            controller.handle(Command::Drive { element: 0, drive: Drive::Temperature { target_c } }).unwrap_err();
        assert!(matches!(refusal, Refusal::Unreachable { element: 0, .. }), "{refusal}");
    }
    controller.handle(Command::Drive { element: 0, drive: Drive::Temperature { target_c: -30.0 } }).unwrap();
}

#[test]
fn a_model_loaded_after_the_drive_is_checked_at_the_start() {
    let mut controller = Controller::<1>::new(&HardwareLimits::SIMULATED);
    controller.handle(Command::SamplePeriod { sample_period_s: 0.01 }).unwrap();
    controller.handle(Command::Element { element: 0, config: element() }).unwrap();
    controller.handle(Command::Drive { element: 0, drive: Drive::Temperature { target_c: 20.0 } }).unwrap();
    controller.handle(Command::Model { element: 0, model: model() }).unwrap();
    assert!(matches!(start(&mut controller), Err(Refusal::Unreachable { .. })));
    assert_eq!(controller.state(), RunState::Standby);
}

#[test]
fn a_refused_command_changes_nothing() {
    let controller = running([Drive::Passive, Drive::Passive]);
    let bad = [
        Command::Clear,
        Command::SamplePeriod { sample_period_s: 0.1 },
        Command::Guard(GuardConfig::default()),
        Command::Element { element: 0, config: element() },
        Command::Model { element: 0, model: model() },
        Command::Drive { element: 2, drive: Drive::Passive },
        Command::Drive { element: 0, drive: Drive::Power { power_w: 5.0 } },
        Command::Drive { element: 0, drive: Drive::Temperature { target_c: f32::NAN } },
        Command::Start,
        Command::Acknowledge,
    ];
    for command in bad {
        let mut asked = controller;
        let refusal = asked.handle(command).unwrap_err();
        assert_eq!(asked, controller, "{command:?}: {refusal}");
    }
}

#[test]
fn names_what_has_to_come_first() {
    let mut controller = Controller::<1>::new(&HardwareLimits::SIMULATED);
    assert_eq!(start(&mut controller), Err(Refusal::NoSamplePeriod));
    assert_eq!(
        controller.handle(Command::Drive { element: 0, drive: Drive::Passive }),
        Err(Refusal::NotConfigured { element: 0 })
    );
    assert_eq!(controller.handle(Command::Model { element: 0, model: model() }), Err(Refusal::NoSamplePeriod));
    assert_eq!(
        controller.handle(Command::Element { element: 1, config: element() }),
        Err(Refusal::NoSuchElement { element: 1 })
    );
}

#[test]
fn its_model_follows_the_power() {
    let mut controller = running([Drive::Level(Level::High), Drive::Passive]);
    for n in 0..200_000 {
        // Its first reading is colder: one that never rises would trip.
        let temperature_c = if n == 0 { -32.0 } else { -30.0 };
        controller.tick(&[code(temperature_c, n > 0), code(-50.0, false)]);
    }
    // 2000 s of 40.6 mW into 628 K/W; six slowest time constants leave 0.25 %
    let expected_k = 628.0 * 0.016 * 0.016 * 175.0 * (1.0 - 0.0031 * 30.0);
    let rise_k = controller.model_temperature_c(0).unwrap() + 50.0;
    assert!((rise_k / expected_k - 1.0).abs() < 3e-3, "{rise_k} {expected_k}");
}

#[test]
fn two_runs_of_the_same_experiment_are_the_same_run() {
    let drives = [
        Drive::Prbs { order: 9, seed: 5, ticks_per_bit: 3 },
        Drive::Setpoints { low_c: -40.0, high_c: -35.0, dwell_ticks: 7, seed: 11 },
    ];
    let mut controller = running(drives);
    let mut digests = Vec::new();
    for _ in 0..2 {
        let mut body = TestBody { temperature_c: [-50.0; 2], heaters: Heaters::default() };
        let mut digest = Digest::default();
        for _ in 0..1000 {
            let tick = controller.tick(&body.readings());
            controller.digest(&tick, &mut digest);
            body.live(&tick);
        }
        digests.push(digest.value());
        controller.handle(Command::Stop).unwrap();
        controller.tick(&body.readings());
        start(&mut controller).unwrap();
    }
    assert_eq!(digests[0], digests[1]);
}

#[test]
fn stopping_puts_every_heater_low() {
    let mut controller = running([Drive::Level(Level::High), Drive::Level(Level::High)]);
    assert_eq!(controller.tick(&[code(0.0, false); 2]).heaters, Heaters(0b11));
    controller.handle(Command::Stop).unwrap();
    let tick = controller.tick(&[code(0.0, true); 2]);
    assert_eq!((tick.heaters, tick.state, tick.trip), (Heaters(0), RunState::Standby, None));
}

#[test]
fn clearing_forgets_elements_and_period() {
    let mut controller = running([Drive::Passive, Drive::Passive]);
    controller.handle(Command::Stop).unwrap();
    controller.handle(Command::Clear).unwrap();
    assert_eq!(controller, Controller::new(&HardwareLimits::SIMULATED));
}

#[test]
fn a_new_period_makes_models_wait_for_their_new_gains() {
    let mut controller = running([Drive::Passive, Drive::Passive]);
    controller.handle(Command::Stop).unwrap();
    assert!(controller.model_temperature_c(0).is_some());
    controller.handle(Command::SamplePeriod { sample_period_s: 0.02 }).unwrap();
    assert_eq!((controller.model_temperature_c(0), controller.sample_period_s()), (None, Some(0.02)));
    assert_eq!(start(&mut controller), Ok(Reply::Started { judged: 0, unjudged: 0 }));
}

#[test]
fn a_start_says_how_many_set_points_were_judged() {
    let mut controller = Controller::<3>::new(&HardwareLimits::SIMULATED);
    controller.handle(Command::SamplePeriod { sample_period_s: 0.01 }).unwrap();
    for index in 0..3 {
        controller.handle(Command::Element { element: index, config: element() }).unwrap();
        let drive = Drive::Temperature { target_c: -30.0 };
        controller.handle(Command::Drive { element: index, drive }).unwrap();
    }
    controller.handle(Command::Model { element: 1, model: model() }).unwrap();
    assert_eq!(start(&mut controller), Ok(Reply::Started { judged: 1, unjudged: 2 }));
}

#[test]
fn set_points_stay_under_the_temperature_limit() {
    let mut controller = Controller::<1>::new(&HardwareLimits::SIMULATED);
    controller.handle(Command::SamplePeriod { sample_period_s: 0.01 }).unwrap();
    controller.handle(Command::Element { element: 0, config: element() }).unwrap();
    let refused = |controller: &mut Controller<1>, drive| match controller.handle(Command::Drive { element: 0, drive })
    {
        Err(Refusal::Invalid { element: Some(0), error }) => error.parameter,
        other => panic!("{other:?}"),
    };
    assert_eq!(refused(&mut controller, Drive::Temperature { target_c: 70.5 }), Parameter::TargetC);
    let above = Drive::Setpoints { low_c: 60.0, high_c: 71.0, dwell_ticks: 5, seed: 1 };
    assert_eq!(refused(&mut controller, above), Parameter::HighC);
    let alternating = Drive::Alternation { low_c: 60.0, high_c: 71.0, half_ticks: 5 };
    assert_eq!(refused(&mut controller, alternating), Parameter::HighC);
    controller.handle(Command::Drive { element: 0, drive: Drive::Temperature { target_c: 69.5 } }).unwrap();
}

#[test]
fn set_points_that_alternate_are_moved_in_the_middle_of_a_half() {
    let alternation = |high_c: f32| Drive::Alternation { low_c: high_c - 10.0, high_c, half_ticks: 50 };
    let mut controller = running([alternation(-30.0), Drive::Passive]);
    let mut body = TestBody { temperature_c: [-50.0; 2], heaters: Heaters::default() };
    let mut targets = Vec::new();
    for n in 0..150 {
        if n == 70 {
            controller.handle(Command::Arm { window_s: 1.0 }).unwrap();
            controller.handle(Command::Drive { element: 0, drive: alternation(-31.0) }).unwrap();
        }
        let tick = controller.tick(&body.readings());
        body.live(&tick);
        targets.push(controller.states[0].drive.target_c);
    }
    targets.dedup();
    assert_eq!(targets, [-30.0, -40.0, -41.0, -31.0]);
}

#[test]
fn of_two_faults_the_first_element_is_named() {
    let mut controller = running([Drive::Passive, Drive::Passive]);
    let tick = controller.tick(&[Reading::Code(3), Reading::Code(8_388_607)]);
    assert_eq!(tick.trip, Some(Trip::of(0, Cause::Short)));
}

#[test]
fn a_new_drive_starts_afresh_and_with_the_whole_timeout() {
    let prbs = Drive::Prbs { order: 7, seed: 21, ticks_per_bit: 1 };
    let mut controller = running([prbs, Drive::Power { power_w: 0.06 }]);
    controller.handle(Command::Stop).unwrap();
    controller.handle(Command::Guard(GuardConfig { unreachable_limit_ticks: 20, ..GuardConfig::default() })).unwrap();
    start(&mut controller).unwrap();
    let mut heaters = Heaters(0);
    let bits = |controller: &mut Controller<2>, heaters: &mut Heaters| -> Vec<bool> {
        (0..15)
            .map(|_| {
                let tick = controller.tick(&[0, 1].map(|i| code(-40.0, heaters.is_high(i))));
                assert_eq!(tick.trip, None);
                *heaters = tick.heaters;
                tick.heaters.is_high(0)
            })
            .collect()
    };
    let first = bits(&mut controller, &mut heaters);
    controller.handle(Command::Arm { window_s: 1.0 }).unwrap();
    controller.handle(Command::Drive { element: 0, drive: prbs }).unwrap();
    // 60 mW is more than the high level gives: 15 ticks of it are borne, and after a new drive 15
    // more.
    controller.handle(Command::Drive { element: 1, drive: Drive::Power { power_w: 0.06 } }).unwrap();
    assert_eq!(bits(&mut controller, &mut heaters), first);
}

#[test]
fn a_mean_power_out_of_reach_trips_in_the_end() {
    let mut controller = running([Drive::Power { power_w: 0.06 }, Drive::Passive]);
    controller.handle(Command::Stop).unwrap();
    controller.handle(Command::Guard(GuardConfig { unreachable_limit_ticks: 3, ..GuardConfig::default() })).unwrap();
    start(&mut controller).unwrap();
    for tick in 0..3 {
        assert_eq!(controller.tick(&[code(-40.0, tick > 0), code(-40.0, false)]).trip, None);
    }
    let trip = controller.tick(&[code(-40.0, true), code(-40.0, false)]).trip;
    assert_eq!(trip, Some(Trip::of(0, Cause::Unreachable)));
}

#[test]
fn the_digest_sees_every_part_of_the_state() {
    let mut controller = running([Drive::Prbs { order: 9, seed: 5, ticks_per_bit: 3 }, Drive::Passive]);
    let tick = controller.tick(&[code(-40.0, false); 2]);
    let digest = |controller: &Controller<2>, tick: &Tick<2>| {
        let mut digest = Digest::default();
        controller.digest(tick, &mut digest);
        digest.value()
    };
    let plain = digest(&controller, &tick);
    let mut changed = controller;
    changed.levels = Heaters(0b10);
    assert_ne!(digest(&changed, &tick), plain, "levels");
    let changes: [fn(&mut ElementState); 10] = [
        |state| state.measured += 1e-3,
        |state| state.raw += 1e-3,
        |state| state.absent_ticks += 1,
        |state| state.saturated_ticks += 1,
        |state| state.drive.modulator.accumulator += 1e-3,
        |state| state.drive.register = Some(crate::signal::Prbs::new(9, 6).unwrap()),
        |state| state.drive.ticks_left += 1,
        |state| state.drive.target_c += 1e-3,
        |state| state.model.x[7] += 1e-9,
        |state| state.model.excess[0] += 1e-12,
    ];
    for (i, change) in changes.iter().enumerate() {
        let mut changed = controller;
        change(&mut changed.states[1]);
        assert_ne!(digest(&changed, &tick), plain, "change {i}");
    }
    // The memory of an observer counts while there is one; without, a run has the digest that it
    // always had.
    let mut changed = controller;
    changed.states[1].observer.added_w += 1e-9;
    assert_eq!(digest(&changed, &tick), plain);
    let observed = Tick { equivalent_power_w: Some([0.0; 2]), ..tick };
    assert_ne!(digest(&changed, &observed), digest(&controller, &observed));
    let other = Tick { equivalent_power_w: Some([0.0, 1.0]), ..tick };
    assert_ne!(digest(&controller, &observed), digest(&controller, &other));
    let trip = Trip::of(1, Cause::Open);
    for other in [
        Tick { heaters: Heaters(2), ..tick },
        Tick { valid: 1, ..tick },
        Tick { tick: 9, ..tick },
        Tick { power_w: [0.0, 1.0], ..tick },
        Tick { state: RunState::Tripped(trip), ..tick },
    ] {
        assert_ne!(digest(&controller, &other), plain, "{other:?}");
    }
}

#[test]
fn a_code_that_never_changes_trips_a_driven_element() {
    let mut controller = Controller::<2>::new(&HardwareLimits::SIMULATED);
    controller.handle(Command::SamplePeriod { sample_period_s: 0.01 }).unwrap();
    controller.handle(Command::Guard(GuardConfig { stuck_limit_ticks: 20, ..GuardConfig::default() })).unwrap();
    for (place, drive) in [(0, Drive::Passive), (1, Drive::Temperature { target_c: 0.0 })] {
        controller.handle(Command::Element { element: place, config: element() }).unwrap();
        controller.handle(Command::Drive { element: place, drive }).unwrap();
    }
    start(&mut controller).unwrap();
    // Both stand still; the second as it was read at the high level. A code that comes again after
    // another begins anew.
    let tick = |controller: &mut Controller<2>, second_c: f32| {
        let read_high = controller.levels.is_high(1);
        controller.tick(&[code(-40.0, false), code(second_c, read_high)])
    };
    for n in 0..60 {
        assert_eq!(tick(&mut controller, if n % 20 == 0 { -31.0 } else { -30.0 }).trip, None, "tick {n}");
    }
    let trips: Vec<_> = (0..25).filter_map(|n| tick(&mut controller, -30.0).trip.map(|trip| (n, trip))).collect();
    // Since the change at tick 40 the code has been the same from tick 41 on: 18 times at the end
    // of the loop.
    assert_eq!(trips, [(2, Trip::of(1, Cause::Stuck))]);
}
