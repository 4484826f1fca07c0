//! What is told of a controller in a word or a number.

use super::*;
use std::collections::BTreeSet;

#[test]
fn no_two_states_have_the_same_word() {
    const LAST: Cause = Cause::BrownOut;
    let causes = [Cause::Open, Cause::Short, Cause::Missing, Cause::Unreachable, Cause::Upset, Cause::Watchdog, LAST];
    let of = |cause| (0..16).map(move |element| Trip::of(element, cause)).chain([Trip::whole(cause)]);
    let tripped = causes.into_iter().flat_map(of).map(RunState::Tripped);
    let states: Vec<_> = [RunState::Standby, RunState::Running].into_iter().chain(tripped).collect();
    assert_eq!(states.iter().map(|state| state.word()).collect::<BTreeSet<_>>().len(), states.len());
}

#[test]
fn an_element_that_has_no_bit_is_not_high() {
    for i in 0..16 {
        assert!(Heaters(1 << i).is_high(i) && !Heaters(!(1 << i)).is_high(i));
    }
    assert!(!Heaters(u16::MAX).is_high(16) && !Heaters(u16::MAX).is_high(usize::MAX));
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
    assert_eq!(Controller::<2>::new().upsets(), 0);
    assert_eq!(Controller::<2>::default(), Controller::<2>::new());
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
    assert_eq!(Controller::<2>::new().standing_power_w(0, 0.0), 0.0);
}
