//! Trips that lock, and a host that is gone.

use super::*;
use crate::control::lockout::Lockout;
use crate::sensor::Level;

/// Trips in the first tick: element 1 is open.
fn trip(controller: &mut Controller<2>) {
    start(controller).unwrap();
    controller.tick(&[code(-50.0, false), Reading::Code(8_388_607)]);
    assert_eq!(controller.state(), RunState::Tripped(Trip::of(1, Cause::Open)));
}

#[test]
fn the_third_trip_cannot_be_acknowledged_whatever_is_sent() {
    let mut controller = running([Drive::Passive, Drive::Level(Level::High)]);
    controller.handle(Command::Stop).unwrap();
    for _ in 0..2 {
        trip(&mut controller);
        controller.handle(Command::Acknowledge).unwrap();
        // Neither forgets a trip.
        controller.handle(Command::Clear).unwrap();
        controller = Controller { lockout: *controller.lockout(), ..running([Drive::Passive; 2]) };
        controller.update_checksums();
        controller.handle(Command::Stop).unwrap();
    }
    trip(&mut controller);
    assert_eq!(controller.handle(Command::Acknowledge), Err(Refusal::LockedOut));
    let refused = Err(Refusal::Tripped(Trip::of(1, Cause::Open)));
    for command in [Command::Clear, Command::Start, Command::Arm { window_s: 1.0 }] {
        assert_eq!(controller.handle(command), refused);
    }
    assert_eq!(controller.handle(Command::Acknowledge), Err(Refusal::LockedOut));
    // A bit flip clears what it may have hit, but not the lock.
    controller.sample_period_s = Some(0.02);
    controller.tick(&[code(-50.0, false); 2]);
    assert_eq!(controller.state(), RunState::Tripped(Trip::whole(Cause::BitFlip)));
    assert_eq!(controller.handle(Command::Acknowledge), Err(Refusal::LockedOut));
    assert_eq!(controller.lockout().history().trips, 4);
}

#[test]
fn a_bit_flip_that_is_acknowledged_forgets_no_trip() {
    let mut controller = running([Drive::Passive; 2]);
    controller.sample_period_s = Some(0.02);
    controller.tick(&[code(-50.0, false); 2]);
    controller.handle(Command::Acknowledge).unwrap();
    assert_eq!((controller.elements(), controller.lockout().history().trips), (0, 1));
}

#[test]
fn a_locked_instrument_that_is_in_standby_does_not_heat() {
    let mut controller = running([Drive::Passive; 2]);
    controller.handle(Command::Stop).unwrap();
    controller.restore_lockout(Lockout::locked());
    controller.handle(Command::Arm { window_s: 1.0 }).unwrap();
    assert_eq!(controller.handle(Command::Start), Err(Refusal::LockedOut));
}

#[test]
fn a_host_that_is_gone_trips_after_its_timeout_while_the_instrument_heats() {
    let calm = [code(-50.0, false); 2];
    let mut controller = running([Drive::Passive; 2]);
    controller.expect_host();
    controller.handle(Command::Stop).unwrap();
    controller.handle(Command::HostTimeout { timeout_s: 0.5 }).unwrap();
    // In standby nobody is needed.
    (0..100).for_each(|_| assert_eq!(controller.tick(&calm).trip, None));
    start(&mut controller).unwrap();
    (0..50).for_each(|_| assert_eq!(controller.tick(&calm).trip, None));
    controller.host_heard();
    (0..50).for_each(|_| assert_eq!(controller.tick(&calm).trip, None));
    assert_eq!(controller.tick(&calm).trip, Some(Trip::whole(Cause::HostTimeout)));
}

#[test]
fn a_minute_is_the_timeout_unless_another_is_said_and_zero_is_for_ever() {
    let calm = [code(-50.0, false); 2];
    let ticks_to_trip = |link: bool, timeout_s: Option<f32>| {
        let mut controller = running([Drive::Passive; 2]);
        controller.handle(Command::Stop).unwrap();
        if link {
            controller.expect_host();
        }
        timeout_s.map(|timeout_s| controller.handle(Command::HostTimeout { timeout_s }).unwrap());
        start(&mut controller).unwrap();
        (0..20_000).find(|_| controller.tick(&calm).trip.is_some())
    };
    assert_eq!(ticks_to_trip(true, None), Some(6_000));
    assert_eq!([ticks_to_trip(true, Some(0.0)), ticks_to_trip(false, None)], [None; 2]);
}

#[test]
fn a_timeout_that_is_none_is_refused() {
    let mut controller = running([Drive::Passive; 2]);
    assert_eq!(controller.handle(Command::HostTimeout { timeout_s: 1.0 }), Err(Refusal::NotInStandby));
    controller.handle(Command::Stop).unwrap();
    for timeout_s in [-1.0, f32::NAN, f32::INFINITY, 86_401.0] {
        let refused = controller.handle(Command::HostTimeout { timeout_s });
        assert!(matches!(refused, Err(Refusal::Invalid { element: None, .. })), "{refused:?}");
    }
}
