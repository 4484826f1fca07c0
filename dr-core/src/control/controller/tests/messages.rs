//! Words and numbers about a controller.

use super::*;
use std::collections::BTreeSet;

#[test]
fn no_two_states_have_the_same_word() {
    const LAST: Cause = Cause::Energy;
    let causes = [Cause::Open, Cause::Short, Cause::Missing, Cause::Unreachable, Cause::BitFlip, Cause::Watchdog, LAST];
    let of = |cause| (0..16).map(move |element| Trip::of(element, cause)).chain([Trip::whole(cause)]);
    let tripped = causes.into_iter().flat_map(of).map(RunState::Tripped);
    let states: Vec<_> = [RunState::Standby, RunState::Running].into_iter().chain(tripped).collect();
    assert_eq!(states.iter().map(|state| state.word()).collect::<BTreeSet<_>>().len(), states.len());
}

#[test]
fn an_element_that_has_no_bit_is_not_high() {
    for i in 0..MOST_ELEMENTS {
        assert!(Heaters(1 << i).is_high(i) && !Heaters(!(1 << i)).is_high(i));
    }
    assert!(Heaters(usize::MAX).is_high(MOST_ELEMENTS - 1));
    assert!(!Heaters(usize::MAX).is_high(MOST_ELEMENTS) && !Heaters(usize::MAX).is_high(usize::MAX));
}

#[test]
fn ticks_are_counted_from_each_start() {
    let mut controller = running([Drive::Passive, Drive::Passive]);
    for n in 0..5 {
        assert_eq!(controller.ticks(), n);
        assert_eq!(controller.tick(&[code(-50.0, false); 2]).tick, n);
    }
    controller.handle(Command::Stop).unwrap();
    start(&mut controller).unwrap();
    assert_eq!(controller.ticks(), 0);
    assert_eq!(Controller::<2>::new(&HardwareLimits::SIMULATED).bit_flips(), 0);
}

#[test]
fn standing_power_is_that_of_the_low_level() {
    let controller = running([Drive::Passive, Drive::Passive]);
    // (3 mA)² of 175 Ω (1 + 0.0031 /°C T)
    for temperature_c in [-80.0_f32, 0.0, 60.0] {
        let truth = 9e-6 * 175.0 * (1.0 + 0.0031 * f64::from(temperature_c));
        let found = controller.standing_power_w(1, temperature_c);
        assert!((f64::from(found) / truth - 1.0).abs() < 1e-6, "{temperature_c} °C: {found}");
    }
    assert_eq!(controller.standing_power_w(2, 0.0), 0.0);
    assert_eq!(Controller::<2>::new(&HardwareLimits::SIMULATED).standing_power_w(0, 0.0), 0.0);
}

#[test]
fn a_start_keeps_what_was_read_last() {
    let mut controller = running([Drive::Level(Level::High), Drive::Passive]);
    controller.handle(Command::Stop).unwrap();
    controller.tick(&[code(-41.0, false), code(-52.0, false)]);
    start(&mut controller).unwrap();
    // Not read in the first tick: low, at the resistance of the last one.
    let tick = controller.tick(&[Reading::Missing; 2]);
    for (i, celsius) in [-41.0_f32, -52.0].into_iter().enumerate() {
        // A code is 0.3 mK at the low level.
        assert!((tick.temperature_c[i] - celsius).abs() < 1e-3, "{tick:?}");
        let power_w = 9e-6 * 175.0 * (1.0 + 0.0031 * celsius);
        assert!((tick.power_w[i] / power_w - 1.0).abs() < 1e-5, "{tick:?}");
    }
}

#[test]
fn what_cannot_be_done_in_a_state_is_refused_and_says_so() {
    let mut controller = running([Drive::Passive, Drive::Passive]);
    assert_eq!(controller.handle(Command::Acknowledge), Err(Refusal::NotTripped));
    controller.trip(Cause::Heater);
    let trip = Trip::whole(Cause::Heater);
    let drive = Command::Drive { element: 0, drive: Drive::Passive };
    for command in [Command::Stop, Command::Arm { window_s: 1.0 }, drive, Command::Start, Command::Clear] {
        assert_eq!(controller.handle(command), Err(Refusal::Tripped(trip)), "{command:?}");
    }
    controller.handle(Command::Acknowledge).unwrap();
    assert_eq!(controller.handle(Command::Acknowledge), Err(Refusal::NotTripped));
    let gas = crate::wind::WindCommand::Gas { pressure_pa: 700.0, temperature_c: None };
    assert_eq!(controller.handle(Command::Wind(gas)), Err(Refusal::NoAnemometer));
}

#[test]
fn a_second_trip_does_not_hide_the_first() {
    let mut controller = running([Drive::Passive, Drive::Passive]);
    controller.trip(Cause::Heater);
    controller.trip(Cause::Deadline);
    assert_eq!(controller.state(), RunState::Tripped(Trip::whole(Cause::Heater)));
}
