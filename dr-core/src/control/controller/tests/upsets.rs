//! A bit that flips in what decides about heaters is found before it decides anything.

use super::*;
use crate::control::controller::upset::UPSETS;

fn limits(controller: &mut Controller<2>) -> &mut Limits {
    &mut controller.elements[0].as_mut().unwrap().config.limits
}

fn warm() -> (Controller<2>, Body) {
    let mut controller = running([Drive::Temperature { target_c: -30.0 }, Drive::Power { power_w: 0.01 }]);
    let mut body = Body { temperature_c: [-50.0; 2], heaters: Heaters::default() };
    for _ in 0..37 {
        let tick = controller.tick(&body.readings());
        assert!(tick.trip.is_none());
        body.live(&tick);
    }
    (controller, body)
}

#[test]
fn whatever_bit_flips_of_what_decides_no_heater_is_on_after_it() {
    let (before, body) = warm();
    let mut upset = std::collections::BTreeSet::new();
    for (which, element, bit) in (0..UPSETS).flat_map(|w| (0..2).flat_map(move |e| (0..32).map(move |b| (w, e, b)))) {
        let mut controller = before;
        let Some(name) = controller.upset(which, element, bit) else { continue };
        if name == "model" {
            continue;
        }
        upset.insert(name);
        let tick = controller.tick(&body.readings());
        assert_eq!(tick.trip, Some(Trip::whole(Cause::Upset)), "{name} of {element}, bit {bit}");
        assert_eq!((tick.heaters, controller.upsets()), (Heaters(0), 1), "{name} of {element}, bit {bit}");
    }
    assert_eq!(upset.len(), 22, "{upset:?}"); // with set-point and wanted power, without the model
}

#[test]
fn an_upset_of_a_standing_instrument_does_not_start_it() {
    let (mut controller, body) = warm();
    controller.handle(Command::Stop).unwrap();
    controller.tick(&body.readings());
    controller.state = RunState::Running;
    let tick = controller.tick(&body.readings());
    assert_eq!((tick.heaters, tick.trip), (Heaters(0), Some(Trip::whole(Cause::Upset))));
}

#[test]
fn an_upset_of_a_model_is_found_when_its_turn_comes() {
    let (before, body) = warm();
    for element in 0..2 {
        let mut controller = before;
        assert_eq!(controller.upset(21, element, 7), Some("model"));
        let tripped = (0..2).find_map(|_| controller.tick(&body.readings()).trip);
        assert_eq!(tripped, Some(Trip::of(element, Cause::Upset)));
    }
}

#[test]
fn a_command_does_not_seal_what_was_upset_before_it() {
    let (mut controller, _) = warm();
    limits(&mut controller).temperature_max_c = 500.0;
    let refused = controller.handle(Command::Drive { element: 1, drive: Drive::Passive });
    assert_eq!(refused, Err(Refusal::Tripped(Trip::whole(Cause::Upset))));
}

#[test]
fn acknowledged_it_has_forgotten_everything_but_the_count() {
    let (mut controller, body) = warm();
    limits(&mut controller).temperature_max_c = 500.0;
    for _ in 0..5 {
        assert_eq!(controller.tick(&body.readings()).state, RunState::Tripped(Trip::whole(Cause::Upset)));
    }
    assert_eq!(controller.upsets(), 1);
    controller.handle(Command::Acknowledge).unwrap();
    assert_eq!((controller.elements(), controller.sample_period_s(), controller.upsets()), (0, None, 1));
    controller.handle(Command::Clear).unwrap();
    assert_eq!(controller.upsets(), 1);
}

#[test]
fn an_untouched_controller_is_sound_whatever_it_is_told() {
    let (mut controller, mut body) = warm();
    for n in 0..500 {
        let drive = if n % 3 == 0 { Drive::Passive } else { Drive::Temperature { target_c: -30.0 } };
        controller.handle(Command::Arm { window_s: 1.0 }).unwrap();
        controller.handle(Command::Drive { element: 1, drive }).unwrap();
        let tick = controller.tick(&body.readings());
        assert_eq!(tick.trip, None);
        body.live(&tick);
    }
}

#[test]
fn models_are_looked_at_one_a_tick_in_turn() {
    let (mut before, body) = warm();
    if before.ticks() % 2 == 1 {
        before.tick(&body.readings());
    }
    for element in 0..2 {
        let mut controller = before;
        controller.upset(21, element, 7);
        let trips = [0, 1].map(|_| controller.tick(&body.readings()).trip.is_some());
        assert_eq!(trips, [element == 0, element == 1]);
    }
}

#[test]
fn a_seed_is_found_whatever_is_drawn_from_it_and_what_is_not_there_is_not_upset() {
    let setpoints = Drive::Setpoints { low_c: -40.0, high_c: -35.0, dwell_ticks: 7, seed: 11 };
    let before = running([Drive::Prbs { order: 9, seed: 5, ticks_per_bit: 3 }, setpoints]);
    for (element, bit) in (0..2).flat_map(|element| (0..32).map(move |bit| (element, bit))) {
        let mut controller = before;
        assert_eq!(controller.upset(9, element, bit), Some("seed"));
        assert_eq!(controller.tick(&[code(-40.0, false); 2]).trip, Some(Trip::whole(Cause::Upset)));
    }
    let before = running([Drive::Passive, Drive::Level(Level::High)]);
    let mut controller = before;
    for (which, element) in [(9, 0), (9, 1), (10, 1), (UPSETS, 0), (0, 2)] {
        assert_eq!(controller.upset(which, element, 3), None, "{which} of {element}");
    }
    assert_eq!(controller, before);
}
