//! Wishes of a self-test beside the guard's work.

use super::*;

const MISSING: [Reading; 2] = [Reading::Missing; 2];

fn idle() -> Controller<2> {
    let mut controller = Controller::new(&HardwareLimits::SIMULATED);
    controller.handle(Command::SamplePeriod { sample_period_s: 0.01 }).unwrap();
    controller.handle(Command::Element { element: 0, config: element() }).unwrap();
    controller.handle(Command::Drive { element: 0, drive: Drive::Passive }).unwrap();
    controller
}

#[test]
fn what_was_not_read_for_a_reason_is_not_missing_afterwards() {
    let mut controller = idle();
    for _ in 0..5 {
        assert_eq!(controller.tick_with(&MISSING, Probe::Blind).trip, None);
    }
    // One may be missing, as ever, and no more.
    assert_eq!(controller.tick_with(&MISSING, Probe::None).trip, None);
    assert_eq!(controller.tick_with(&MISSING, Probe::None).trip, Some(Trip::of(0, Cause::Missing)));
}

#[test]
fn a_running_instrument_is_never_blind() {
    let mut controller = idle();
    start(&mut controller).unwrap();
    assert_eq!(controller.tick_with(&MISSING, Probe::Blind).trip, None);
    assert_eq!(controller.tick_with(&MISSING, Probe::Blind).trip, Some(Trip::of(0, Cause::Missing)));
}
