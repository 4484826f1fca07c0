//! A bit that flips in what decides about heaters is found before it decides anything.

use super::*;

/// Flips a bit of a number.
fn flip(number: &mut f32, bit: u32) {
    *number = f32::from_bits(number.to_bits() ^ 1 << bit);
}

/// One thing that can be upset, by its name and in a way of its own.
type Upset = (&'static str, fn(&mut Controller<2>, u32));

/// All that is sealed and that changes what a tick decides.
const DECIDING: [Upset; 21] = [
    ("sample period", |c, bit| flip(c.sample_period_s.as_mut().unwrap(), bit)),
    ("patience with readings", |c, bit| c.guard.missing_limit_ticks ^= 1 << bit),
    ("patience with set-points", |c, bit| c.guard.unreachable_limit_ticks ^= 1 << bit),
    ("how many elements", |c, bit| c.configured ^= 1 << (bit % 8)),
    ("whether observers run", |c, _| c.observing = !c.observing),
    ("least resistance", |c, bit| flip(&mut limits(c).resistance_min_ohm, bit)),
    ("greatest resistance", |c, bit| flip(&mut limits(c).resistance_max_ohm, bit)),
    ("greatest temperature", |c, bit| flip(&mut limits(c).temperature_max_c, bit)),
    ("greatest code", |c, bit| limits(c).code_max ^= 1 << bit),
    ("set-point", |c, bit| match &mut c.elements[0].as_mut().unwrap().drive {
        Drive::Temperature { target_c } => flip(target_c, bit),
        drive => panic!("{drive:?}"),
    }),
    ("which drive", |c, _| c.elements[0].as_mut().unwrap().drive = Drive::Level(Level::High)),
    ("wiring", |c, bit| {
        let config = &mut c.elements[1].as_mut().unwrap().config;
        let mut current_high_a = 16e-3;
        flip(&mut current_high_a, bit % 20);
        config.channel =
            Channel::new(Platinum::linear(175.0, 0.0031).unwrap(), VOLT_PER_CODE, 3e-3, current_high_a).unwrap();
    }),
    ("resistor", |c, bit| {
        let config = &mut c.elements[1].as_mut().unwrap().config;
        let mut resistance_ohm = 175.0;
        flip(&mut resistance_ohm, bit % 20);
        let platinum = Platinum::linear(resistance_ohm, 0.0031).unwrap();
        config.channel = Channel::new(platinum, VOLT_PER_CODE, 3e-3, 16e-3).unwrap();
    }),
    ("run state", |c, _| c.state = RunState::Standby),
    ("number of the tick", |c, bit| c.tick ^= 1 << bit),
    ("time armed", |c, bit| c.armed_ticks ^= 1 << bit),
    ("level", |c, _| c.states[0].level = if c.states[0].level == Level::High { Level::Low } else { Level::High }),
    ("ticks without a reading", |c, bit| c.states[0].absent_ticks ^= 1 << bit),
    ("ticks saturated", |c, bit| c.states[0].saturated_ticks ^= 1 << bit),
    ("modulator", |c, bit| flip(&mut c.states[1].drive.modulator.accumulator, bit)),
    ("set-point in force", |c, bit| flip(&mut c.states[1].drive.target_c, bit)),
];

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
    for (name, upset) in DECIDING {
        for bit in 0..32 {
            let mut controller = before;
            upset(&mut controller, bit);
            let tick = controller.tick(&body.readings());
            assert_eq!(tick.trip, Some(Trip::whole(Cause::Upset)), "{name}, bit {bit}");
            assert_eq!((tick.heaters, controller.upsets()), (Heaters(0), 1), "{name}, bit {bit}");
        }
    }
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
        let mut config = model();
        flip(&mut config.r_k_per_w[3], 7);
        controller.elements[element].as_mut().unwrap().model = Some(SelfHeating::new(&config, 0.01).unwrap());
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
