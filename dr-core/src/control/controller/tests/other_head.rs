//! Another head on the plug.

use super::*;

const CALM: [Reading; 2] = [Reading::Missing; 2];

/// Resistances of the head of these tests at -50 °C, but for a factor for the second element.
fn fingerprint(factor: f32) -> Command {
    let taken_ohm = element().channel.platinum().resistance_ohm(-50.0);
    let mut resistance_ohm = [0.0; 16];
    resistance_ohm[..2].copy_from_slice(&[taken_ohm, taken_ohm * factor]);
    Command::Fingerprint { resistance_ohm }
}

/// In standby, with elements that heat and a fingerprint.
fn kept(factor: f32) -> Controller<2> {
    let mut controller = running([Drive::Level(Level::High); 2]);
    controller.handle(Command::Stop).unwrap();
    controller.handle(fingerprint(factor)).unwrap();
    controller
}

#[test]
fn the_same_head_runs_in_another_gas_and_after_it_was_heated() {
    let mut controller = kept(1.0);
    controller.tick(&[code(-20.0, false), code(-14.0, false)]);
    start(&mut controller).unwrap();
    assert_eq!(controller.tick(&[code(-20.0, false); 2]).heaters, Heaters(3));
    // Elements are at different temperatures now; the plug has not been pulled.
    controller.tick(&[code(60.0, true), code(-14.0, true)]);
    for command in [Command::Stop, Command::Clear] {
        controller.handle(command).unwrap();
    }
    let mut again = Controller { head: controller.head, ..kept(1.0) };
    again.update_checksums();
    again.tick(&[code(60.0, false), code(-14.0, false)]);
    start(&mut again).unwrap();
}

#[test]
fn another_head_is_refused_until_the_right_one_is_there() {
    let mut controller = kept(1.05);
    controller.tick(&[code(-50.0, false); 2]);
    assert_eq!(start(&mut controller), Err(Refusal::OtherHead { element: 1 }));
    // A host that configures it anew, with a tick in between, does not lift it.
    for command in [Command::Clear, Command::SamplePeriod { sample_period_s: 0.01 }] {
        controller.handle(command).unwrap();
        controller.tick(&[code(-50.0, false); 2]);
    }
    for element_index in 0..2 {
        controller.handle(Command::Element { element: element_index, config: element() }).unwrap();
        assert_eq!(start(&mut controller), Err(Refusal::OtherHead { element: 1 }));
    }
    controller.tick(&[code(-50.0, false); 2]);
    assert_eq!(start(&mut controller), Err(Refusal::OtherHead { element: 1 }));
    let mut controller = kept(1.05);
    controller.tick(&[code(-50.0, false); 2]);
    // Resistance that it was taken from: 5 % of the resistance are 14 K.
    controller.tick(&[code(-50.0, false), code(-36.0, false)]);
    start(&mut controller).unwrap();
}

#[test]
fn a_head_that_was_not_read_before_the_start_trips_before_it_is_heated() {
    let mut controller = kept(1.05);
    start(&mut controller).unwrap();
    // While an element has not been read, none is heated.
    let tick = controller.tick(&[code(-50.0, false), Reading::Stale]);
    assert_eq!((tick.heaters, tick.trip), (Heaters(0), None));
    let tick = controller.tick(&[code(-50.0, false); 2]);
    assert_eq!((tick.heaters, tick.trip), (Heaters(0), Some(Trip::of(1, Cause::OtherHead))));
}

#[test]
fn a_plug_that_was_pulled_is_compared_again() {
    let mut controller = kept(1.0);
    controller.tick(&[code(-50.0, false); 2]);
    assert_eq!(controller.head, HeadCheck::Same);
    controller.tick(&[Reading::Code(8_388_607); 2]);
    controller.handle(Command::Acknowledge).unwrap();
    controller.tick(&[code(-50.0, false), code(-20.0, false)]);
    assert_eq!(start(&mut controller), Err(Refusal::OtherHead { element: 1 }));
}

#[test]
fn a_resistance_that_is_none_is_refused_and_zero_compares_nothing() {
    let mut controller = kept(1.0);
    for resistance in [-1.0, f32::NAN, 2e6] {
        let refused = controller.handle(Command::Fingerprint { resistance_ohm: [resistance; 16] });
        assert!(matches!(refused, Err(Refusal::Invalid { element: Some(0), .. })), "{refused:?}");
    }
    controller.handle(Command::Fingerprint { resistance_ohm: [0.0; 16] }).unwrap();
    controller.tick(&CALM);
    assert_eq!(controller.head, HeadCheck::Same);
    start(&mut controller).unwrap();
    assert_eq!(controller.handle(fingerprint(1.0)), Err(Refusal::NotInStandby));
}
