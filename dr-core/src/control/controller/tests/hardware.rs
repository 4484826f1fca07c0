//! Effect of a board's limits, whatever messages say.

use super::*;
use crate::control::{EnergyLimit, HardwareLimits, Lockout};

/// A board that bears 20 mW for ever and 0.5 J beyond.
const WEAK: HardwareLimits =
    HardwareLimits { energy: EnergyLimit { sustained_power_w: 0.02, energy_j: 0.5 }, ..HardwareLimits::SENSOR_BOARD };

/// The longest timeouts that a message can set.
const LAXEST: GuardConfig =
    GuardConfig { missing_limit_ticks: u32::MAX, unreachable_limit_ticks: u32::MAX, stuck_limit_ticks: 1000 };

/// An element whose head states no energy.
fn unstated() -> ElementConfig {
    let good = element();
    ElementConfig { limits: Limits { energy: None, ..good.limits }, ..good }
}

fn set_up(controller: &mut Controller<2>, drive: Drive) {
    controller.handle(Command::Clear).unwrap();
    controller.handle(Command::SamplePeriod { sample_period_s: 0.1 }).unwrap();
    controller.handle(Command::Guard(LAXEST)).unwrap();
    for i in 0..2 {
        controller.handle(Command::Element { element: i, config: unstated() }).unwrap();
    }
    controller.handle(Command::Drive { element: 0, drive }).unwrap();
}

fn of_board(hardware: &'static HardwareLimits, drive: Drive) -> Controller<2> {
    let mut controller = Controller::new(hardware);
    set_up(&mut controller, drive);
    start(&mut controller).unwrap();
    controller
}

/// One tick in which element 0 reads a temperature, a little different each time, as noise does.
fn tick(controller: &mut Controller<2>, temperature_c: f32) -> Tick<2> {
    let noise_c = 0.1 * (controller.ticks() % 3) as f32;
    let high = controller.levels.is_high(0);
    controller.tick(&[code(temperature_c + noise_c, high), code(-40.0, false)])
}

/// The tick in which a reading trips that rises by so much in a second, or stays as it is.
fn trip_at(drive: Drive, rise_k_s: f32, after_s: f32) -> Option<(u32, Trip)> {
    let mut controller = of_board(&HardwareLimits::SENSOR_BOARD, drive);
    (0..8000).find_map(|n| {
        let risen_k = rise_k_s * (0.1 * n as f32).min(after_s);
        tick(&mut controller, -50.0 + risen_k).trip.map(|trip| (n, trip))
    })
}

#[test]
fn a_reading_that_does_not_rise_ends_every_drive_that_heats() {
    let heating = [
        Drive::Temperature { target_c: 0.0 },
        Drive::Setpoints { low_c: 0.0, high_c: 1.0, dwell_ticks: 9, seed: 3 },
        Drive::Level(Level::High),
        Drive::Power { power_w: 0.06 },
    ];
    for drive in heating {
        // 22.5 s are 225 ticks, counted from the first reading at the high level, in tick 1.
        assert_eq!(trip_at(drive, 0.0, 0.0), Some((226, Trip::of(0, Cause::Unreachable))), "{drive:?}");
    }
    // Bits of 40 s: tripped within the first that is high.
    let prbs = Drive::Prbs { order: 5, seed: 3, ticks_per_bit: 400 };
    let (at, trip) = trip_at(prbs, 0.0, 0.0).unwrap();
    assert_eq!((at % 400, trip), (226, Trip::of(0, Cause::Unreachable)));
    // A drive that alternates: 23 of 38 mW, and bits of one tick.
    for drive in [Drive::Power { power_w: 0.023 }, Drive::Prbs { order: 9, seed: 3, ticks_per_bit: 1 }] {
        let (at, trip) = trip_at(drive, 0.0, 0.0).unwrap();
        assert!((400..900).contains(&at) && trip == Trip::of(0, Cause::Unreachable), "{drive:?}: {at} {trip:?}");
    }
    for drive in [Drive::Passive, Drive::Level(Level::Low), Drive::Power { power_w: 0.005 }] {
        assert_eq!(trip_at(drive, 0.0, 0.0), None);
    }
}

#[test]
fn one_rise_suffices_where_a_steady_state_is_wanted_and_not_where_a_set_point_is() {
    // 2 K in 20 s, then nothing.
    assert_eq!(trip_at(Drive::Level(Level::High), 0.1, 20.0), None);
    let (at, trip) = trip_at(Drive::Temperature { target_c: 0.0 }, 0.1, 20.0).unwrap();
    assert_eq!(trip, Trip::of(0, Cause::Unreachable));
    // The second kelvin is seen by tick 200, noise included; 226 ticks later it is missing.
    assert!((326..=426).contains(&at), "{at}");
    // 1.0 K in 20 s, again and again.
    assert_eq!(trip_at(Drive::Temperature { target_c: 0.0 }, 0.05, 1e3), None);
}

#[test]
fn the_mean_power_is_bounded_whatever_is_repeated_for_ever() {
    type Rest = fn(&mut Controller<2>);
    let rests: [Rest; 3] = [
        |controller| _ = controller.handle(Command::Stop),
        |controller| {
            controller.trip(Cause::Deadline);
            controller.handle(Command::Acknowledge).unwrap();
        },
        |controller| {
            controller.handle(Command::Stop).unwrap();
            set_up(controller, Drive::Level(Level::High));
        },
    ];
    for (which, rest) in rests.into_iter().enumerate() {
        let mut controller = of_board(&WEAK, Drive::Level(Level::High));
        let (mut energy_j, mut spent) = (0.0, 0);
        const TICKS: usize = 20_000;
        for n in 0..TICKS {
            let tick = tick(&mut controller, if n % 50 < 25 { -50.0 } else { -48.0 });
            energy_j += 0.1 * f64::from(tick.power_w[0]);
            spent += usize::from(tick.trip == Some(Trip::of(0, Cause::Energy)));
            // The budget holds without the lock-out, too.
            controller.restore_lockout(Lockout::new());
            if let RunState::Tripped(_) = controller.state() {
                controller.handle(Command::Acknowledge).unwrap();
            } else if n % 100 == 99 {
                rest(&mut controller);
            }
            if controller.state() == RunState::Standby {
                start(&mut controller).unwrap();
            }
        }
        let mean_w = energy_j / (0.1 * TICKS as f64);
        // 0.5 J in 2000 s beyond 20 mW; the high level has 38 mW.
        assert!(mean_w < 0.02 + 0.5 / 2000.0 + 1e-5, "{which}: {mean_w}");
        assert!(mean_w > 0.019 && spent > 100, "{which}: {mean_w}, {spent}");
    }
}

#[test]
fn a_message_beyond_the_board_is_refused_by_name_and_changes_nothing() {
    let mut controller = Controller::<2>::new(&HardwareLimits::SENSOR_BOARD);
    let good = element();
    let config = ElementConfig { limits: Limits { temperature_max_c: 100.0, ..good.limits }, ..good };
    let refused = controller.handle(Command::Element { element: 0, config }).unwrap_err();
    assert!(
        matches!(refused, Refusal::Invalid { element: Some(0), error } if error.parameter == Parameter::TemperatureMaxC)
    );
    let guard = GuardConfig { stuck_limit_ticks: 0, ..LAXEST };
    let refused = controller.handle(Command::Guard(guard)).unwrap_err();
    assert!(
        matches!(refused, Refusal::Invalid { element: None, error } if error.parameter == Parameter::StuckLimitTicks)
    );
    let refused = controller.handle(Command::SamplePeriod { sample_period_s: 2.0 }).unwrap_err();
    assert!(
        matches!(refused, Refusal::Invalid { element: None, error } if error.parameter == Parameter::SamplePeriodS)
    );
    assert_eq!(controller, Controller::new(&HardwareLimits::SENSOR_BOARD));
}

#[test]
fn what_the_head_bears_is_judged_instead_of_what_the_board_grants() {
    let mut controller = Controller::<2>::new(&HardwareLimits::SENSOR_BOARD);
    set_up(&mut controller, Drive::Level(Level::High));
    let energy = Some(EnergyLimit { sustained_power_w: 0.02, energy_j: 0.5 });
    let good = element();
    let config = ElementConfig { limits: Limits { energy, ..good.limits }, ..good };
    controller.handle(Command::Element { element: 0, config }).unwrap();
    controller.handle(Command::Drive { element: 0, drive: Drive::Level(Level::High) }).unwrap();
    start(&mut controller).unwrap();
    let warming = |n: u32| -50.0 + 0.01 * n as f32;
    let trip = (0..8000).find_map(|n| tick(&mut controller, warming(n)).trip.map(|trip| (n, trip)));
    // 0.5 J beyond 20 mW, of which the high level has 37 to 38 mW: 28 s.
    assert!(matches!(trip, Some((270..=300, Trip { cause: Cause::Energy, element: Some(0) }))), "{trip:?}");
}
