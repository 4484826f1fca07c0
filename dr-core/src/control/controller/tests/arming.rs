//! Commands that can heat have to be asked for by one who has armed the instrument, not long ago.

use super::*;

fn idle() -> Controller<2> {
    let mut controller = Controller::new(&HardwareLimits::SIMULATED);
    controller.handle(Command::SamplePeriod { sample_period_s: 0.01 }).unwrap();
    controller.handle(Command::Element { element: 0, config: element() }).unwrap();
    controller.handle(Command::Drive { element: 0, drive: Drive::Level(Level::High) }).unwrap();
    controller
}

fn pass(controller: &mut Controller<2>, ticks: usize) {
    for _ in 0..ticks {
        let read_high = controller.levels.is_high(0);
        assert!(controller.tick(&[code(0.0, read_high), Reading::Missing]).trip.is_none());
    }
}

#[test]
fn it_starts_within_the_window_and_not_after_it() {
    let mut controller = idle();
    assert_eq!(controller.handle(Command::Start), Err(Refusal::NotArmed));
    // 0.3 s are 30 ticks.
    for (ticks, started) in [(0, true), (29, true), (30, false), (1000, false)] {
        controller.handle(Command::Stop).unwrap();
        controller.handle(Command::Arm { window_s: 0.3 }).unwrap();
        pass(&mut controller, ticks);
        assert_eq!(controller.handle(Command::Start).is_ok(), started, "after {ticks} ticks");
    }
}

#[test]
fn what_ends_it_ends_it_at_once() {
    let ends = [Command::Stop, Command::Disarm, Command::Clear, Command::SamplePeriod { sample_period_s: 0.01 }];
    for end in ends {
        let mut controller = idle();
        controller.handle(Command::Arm { window_s: 600.0 }).unwrap();
        assert!(controller.is_armed());
        controller.handle(end).unwrap();
        assert!(!controller.is_armed(), "{end:?}");
    }
    let mut controller = idle();
    controller.handle(Command::Arm { window_s: 600.0 }).unwrap();
    controller.trip(Cause::Deadline);
    controller.handle(Command::Acknowledge).unwrap();
    assert_eq!(controller.handle(Command::Start), Err(Refusal::NotArmed));
}

#[test]
fn a_running_instrument_takes_a_drive_that_heats_only_while_armed() {
    let mut controller = idle();
    start(&mut controller).unwrap();
    pass(&mut controller, 200);
    let hot = Command::Drive { element: 0, drive: Drive::Temperature { target_c: 20.0 } };
    assert_eq!(controller.handle(hot), Err(Refusal::NotArmed));
    // To heat no more needs nobody's leave.
    controller.handle(Command::Drive { element: 0, drive: Drive::Passive }).unwrap();
    controller.handle(Command::Arm { window_s: 1.0 }).unwrap();
    controller.handle(hot).unwrap();
}

#[test]
fn a_window_without_an_end_is_refused() {
    let mut controller = idle();
    for window_s in [0.0, -1.0, f32::NAN, f32::INFINITY, 600.1] {
        let refusal = controller.handle(Command::Arm { window_s }).unwrap_err();
        assert!(
            matches!(refusal, Refusal::Invalid { error, .. } if error.parameter == Parameter::WindowS),
            "{window_s}"
        );
        assert!(!controller.is_armed());
    }
    assert_eq!(
        Controller::<2>::new(&HardwareLimits::SIMULATED).handle(Command::Arm { window_s: 1.0 }),
        Err(Refusal::NoSamplePeriod)
    );
}
