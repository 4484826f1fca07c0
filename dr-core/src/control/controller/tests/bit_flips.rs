//! A bit that flips in what trips, arms or sets levels is found before it decides anything; one in
//! an element's drive or model within as many ticks as there are elements.

use super::*;
use crate::control::controller::bit_flips::FLIPPABLE;

fn limits(controller: &mut Controller<2>) -> &mut Limits {
    let of = controller.elements[0].as_mut().unwrap();
    let Transducer::Resistor(config) = &mut of.transducer else { panic!("it is a resistor") };
    &mut config.limits
}

const DRIVES: [Drive; 2] = [Drive::Temperature { target_c: -30.0 }, Drive::Power { power_w: 0.01 }];

fn warm(drives: [Drive; 2]) -> (Controller<2>, TestBody) {
    let mut controller = running(drives);
    let mut body = TestBody { temperature_c: [-50.0; 2], heaters: Heaters::default() };
    for _ in 0..37 {
        let tick = controller.tick(&body.readings());
        assert!(tick.trip.is_none());
        body.live(&tick);
    }
    (controller, body)
}

/// Detection of a flipped bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Detection {
    /// In the next tick.
    AtOnce,
    /// When it is the element's turn; at once where the drives remember different things.
    InTurn,
    /// Not at all: it decides nothing, or is a counter.
    Never,
}

/// Asserts what is promised of a value.
fn promised(name: &str, drive: &Drive) -> Detection {
    use Detection::{AtOnce, InTurn, Never};
    match name {
        "set-point" | "wanted power" | "seed" | "length of a half" | "which drive" | "model" => InTurn,
        "modulator" if matches!(drive, Drive::Power { .. }) => AtOnce,
        "set-point in force" if matches!(drive, Drive::Setpoints { .. } | Drive::Alternation { .. }) => AtOnce,
        "ticks left" if matches!(drive, Drive::Prbs { .. } | Drive::Setpoints { .. } | Drive::Alternation { .. }) => {
            AtOnce
        }
        "modulator" | "set-point in force" | "ticks left" | "ticks without a reading" | "ticks saturated" => Never,
        _ => AtOnce,
    }
}

#[test]
fn whatever_bit_flips_of_what_decides_is_found_at_once_or_in_turn() {
    let setpoints = Drive::Setpoints { low_c: -40.0, high_c: -35.0, dwell_ticks: 7, seed: 11 };
    let mut flipped = std::collections::BTreeSet::new();
    let alternation = Drive::Alternation { low_c: -40.0, high_c: -35.0, half_ticks: 900 };
    let prbs = Drive::Prbs { order: 9, seed: 5, ticks_per_bit: 3 };
    for drives in [DRIVES, [prbs, setpoints], [alternation, prbs]] {
        let (before, body) = warm(drives);
        let all = (0..FLIPPABLE).flat_map(|w| (0..2).flat_map(move |e| (0..32).map(move |b| (w, e, b))));
        for (which, element, bit) in all {
            let (mut controller, mut body) = (before, body.clone());
            let Some(name) = controller.flip_bit(which, element, bit) else { continue };
            let detection = promised(name, &drives[element]);
            flipped.insert((detection, name));
            let first = controller.tick(&body.readings());
            body.live(&first);
            let mut trips = [first, controller.tick(&body.readings())].into_iter().filter_map(|tick| tick.trip);
            let (trip, whole, in_turn) = (trips.next(), Trip::whole(Cause::BitFlip), Trip::of(element, Cause::BitFlip));
            let what = std::format!("{name} of {element}, {:?}, bit {bit}: {trip:?}", drives[element]);
            match detection {
                Detection::AtOnce => {
                    assert_eq!(
                        (first.trip, first.heaters, controller.bit_flips()),
                        (Some(whole), Heaters(0), 1),
                        "{what}"
                    );
                }
                Detection::InTurn => {
                    assert!(trip == Some(in_turn) || name == "which drive" && first.trip == Some(whole), "{what}");
                }
                Detection::Never => assert_eq!(controller.bit_flips(), 0, "{what}"),
            }
        }
    }
    let count = |of: Detection| flipped.iter().filter(|(detection, _)| *detection == of).count();
    let counts = [Detection::AtOnce, Detection::InTurn, Detection::Never].map(count);
    assert_eq!(counts, [19, 6, 5], "{flipped:?}");
}

#[test]
fn a_random_sequence_that_goes_on_elsewhere_is_found() {
    let (before, body) = warm([Drive::Prbs { order: 9, seed: 5, ticks_per_bit: 3 }, Drive::Passive]);
    let mut controller = before;
    controller.states[0].drive.register = Some(crate::signal::Prbs::new(9, 77).unwrap());
    assert_eq!(controller.tick(&body.readings()).trip, Some(Trip::whole(Cause::BitFlip)));
}

#[test]
fn a_bit_flip_in_standby_does_not_start_a_run() {
    let (mut controller, body) = warm(DRIVES);
    controller.handle(Command::Stop).unwrap();
    controller.tick(&body.readings());
    controller.state = RunState::Running;
    let tick = controller.tick(&body.readings());
    assert_eq!((tick.heaters, tick.trip), (Heaters(0), Some(Trip::whole(Cause::BitFlip))));
}

#[test]
fn a_bit_flip_in_a_model_is_found_when_its_turn_comes() {
    let (before, body) = warm(DRIVES);
    for element in 0..2 {
        let mut controller = before;
        assert_eq!(controller.flip_bit(21, element, 7), Some("model"));
        let tripped = (0..2).find_map(|_| controller.tick(&body.readings()).trip);
        assert_eq!(tripped, Some(Trip::of(element, Cause::BitFlip)));
    }
}

#[test]
fn a_command_does_not_hide_a_bit_flip_before_it() {
    let (mut controller, _) = warm(DRIVES);
    limits(&mut controller).temperature_max_c = 500.0;
    let refused = controller.handle(Command::Drive { element: 1, drive: Drive::Passive });
    assert_eq!(refused, Err(Refusal::Tripped(Trip::whole(Cause::BitFlip))));
}

#[test]
fn acknowledged_it_has_forgotten_everything_but_the_count() {
    let (mut controller, body) = warm(DRIVES);
    limits(&mut controller).temperature_max_c = 500.0;
    for _ in 0..5 {
        assert_eq!(controller.tick(&body.readings()).state, RunState::Tripped(Trip::whole(Cause::BitFlip)));
    }
    assert_eq!(controller.bit_flips(), 1);
    controller.handle(Command::Acknowledge).unwrap();
    assert_eq!((controller.elements(), controller.sample_period_s(), controller.bit_flips()), (0, None, 1));
    controller.handle(Command::Clear).unwrap();
    assert_eq!(controller.bit_flips(), 1);
}

#[test]
fn an_untouched_controller_is_intact_after_any_command() {
    let (mut controller, mut body) = warm(DRIVES);
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
    let (mut before, body) = warm(DRIVES);
    if before.ticks() % 2 == 1 {
        before.tick(&body.readings());
    }
    for element in 0..2 {
        let mut controller = before;
        controller.flip_bit(21, element, 7);
        let trips = [0, 1].map(|_| controller.tick(&body.readings()).trip.is_some());
        assert_eq!(trips, [element == 0, element == 1]);
    }
}

#[test]
fn a_flipped_seed_is_found_and_a_value_that_is_not_there_is_not_flipped() {
    let setpoints = Drive::Setpoints { low_c: -40.0, high_c: -35.0, dwell_ticks: 7, seed: 11 };
    let before = running([Drive::Prbs { order: 9, seed: 5, ticks_per_bit: 3 }, setpoints]);
    for (element, bit) in (0..2).flat_map(|element| (0..32).map(move |bit| (element, bit))) {
        let mut controller = before;
        assert_eq!(controller.flip_bit(9, element, bit), Some("seed"));
        let trips = [0, 1].map(|_| controller.tick(&[code(-40.0, controller.levels.is_high(0)); 2]).trip);
        assert!(trips.contains(&Some(Trip::of(element, Cause::BitFlip))), "{element}, bit {bit}: {trips:?}");
    }
    let before = running([Drive::Passive, Drive::Level(Level::High)]);
    let mut controller = before;
    for (which, element) in [(9, 0), (9, 1), (10, 1), (FLIPPABLE, 0), (0, 2)] {
        assert_eq!(controller.flip_bit(which, element, 3), None, "{which} of {element}");
    }
    assert_eq!(controller, before);
}
