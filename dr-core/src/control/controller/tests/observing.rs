//! Observers of the models, and margins.

use super::*;

/// A controller of two elements with these drives, observing.
fn observing(drives: [Drive; 2]) -> Controller<2> {
    let mut controller = running(drives);
    controller.handle(Command::Stop).unwrap();
    controller.handle(Command::Observe { on: true }).unwrap();
    start(&mut controller).unwrap();
    controller
}

#[test]
fn observing_holds_the_model_on_what_is_measured_and_reports_the_equivalent_control() {
    let mut controller = observing([Drive::Temperature { target_c: -30.0 }, Drive::Passive]);
    let mut body = TestBody { temperature_c: [-50.0; 2], heaters: Heaters::default() };
    let (mut equivalent, mut measured, mut held) = (0.0, 0.0, 0.0);
    for n in 0..400_000 {
        let tick = controller.tick(&body.readings());
        if n >= 200_000 {
            equivalent += f64::from(tick.equivalent_power_w.unwrap()[0]) / 200_000.0;
            measured += f64::from(tick.temperature_c[0]) / 200_000.0;
            held += f64::from(controller.model_temperature_c(0).unwrap()) / 200_000.0;
        }
        body.live(&tick);
    }
    // In 4000 s every pole has come to rest: u_Q of the model, 628 K/W, although the body has 600
    // K/W.
    assert!((held - measured).abs() < 1e-3, "{held} {measured}");
    assert!((equivalent / ((measured + 50.0) / 628.0) - 1.0).abs() < 1e-3, "{equivalent}");
}

#[test]
fn observing_changes_no_decision_and_costs_no_word_when_off() {
    let drives = [Drive::Temperature { target_c: -30.0 }, Drive::Prbs { order: 9, seed: 5, ticks_per_bit: 3 }];
    let (mut plain, mut observed) = (running(drives), observing(drives));
    let mut body = TestBody { temperature_c: [-50.0; 2], heaters: Heaters::default() };
    for _ in 0..1000 {
        let (tick, other) = (plain.tick(&body.readings()), observed.tick(&body.readings()));
        assert_eq!(tick.equivalent_power_w, None);
        assert_eq!(Tick { equivalent_power_w: None, ..other }, tick);
        body.live(&tick);
    }
}

#[test]
fn only_a_passive_body_can_be_observed() {
    let mut controller = running([Drive::Passive, Drive::Passive]);
    assert_eq!(controller.handle(Command::Observe { on: true }), Err(Refusal::NotInStandby));
    controller.handle(Command::Stop).unwrap();
    let active = SelfHeatingConfig { r_k_per_w: [600.0, 20.0, -5.0, 0.0, 0.0, 0.0, 0.0, 0.0], ..model() };
    controller.handle(Command::Model { element: 1, model: active }).unwrap();
    let before = controller;
    let refused = controller.handle(Command::Observe { on: true }).unwrap_err();
    assert!(
        matches!(refused, Refusal::Invalid { element: Some(1), error } if error.parameter == Parameter::ResistanceKPerW)
    );
    assert_eq!(controller, before);
    controller.handle(Command::Model { element: 1, model: model() }).unwrap();
    controller.handle(Command::Observe { on: true }).unwrap();
    // The other order.
    assert_eq!(controller.handle(Command::Model { element: 1, model: active }), Err(refused));
}

#[test]
fn margins_are_those_of_the_power_that_holds_the_set_point() {
    let targets = Drive::Setpoints { low_c: -40.0, high_c: -30.0, dwell_ticks: 10, seed: 1 };
    let controller = running([targets, Drive::Passive]);
    let margins: Vec<_> = controller.margins().collect();
    let [margins, none] = margins[..] else { panic!("two elements") };
    let resistance_ohm = |celsius: f32| 175.0 * (1.0 + 0.0031 * celsius);
    let above_low_w = 10.0 / 628.0 - 3e-3 * 3e-3 * resistance_ohm(-40.0);
    let below_high_w = 16e-3 * 16e-3 * resistance_ohm(-30.0) - 20.0 / 628.0;
    let margins = margins.unwrap();
    // a few f32 roundings of 40 mW
    assert!((margins.above_low_w - above_low_w).abs() < 2e-8 && (margins.below_high_w - below_high_w).abs() < 2e-8);
    assert_eq!(none, None);
}

#[test]
fn a_model_is_pulled_by_readings_of_its_own_element_and_by_no_others() {
    // All stands at −45 °C for a tick; then it is read 1 K warmer, or not read.
    for absent in 0..2 {
        let mut controller = observing([Drive::Passive, Drive::Passive]);
        controller.handle(Command::Stop).unwrap();
        let lax = GuardConfig { missing_limit_ticks: 1000, ..GuardConfig::default() };
        controller.handle(Command::Guard(lax)).unwrap();
        start(&mut controller).unwrap();
        controller.tick(&[code(-45.0, false); 2]);
        let before = [0, 1].map(|element| controller.model_temperature_c(element).unwrap());
        let mut readings = [code(-44.0, false); 2];
        readings[absent] = Reading::Missing;
        for _ in 0..100 {
            controller.tick(&readings);
        }
        let rise_k = [0, 1].map(|element| controller.model_temperature_c(element).unwrap() - before[element]);
        // One that is not read cools towards what the low level holds, 1 K above −50 °C; its slow
        // rate, 0.003 rad/s, leaves most for 1 s.
        assert!((-1.0..0.0).contains(&rise_k[absent]), "{rise_k:?}");
        assert!((0.5..1.1).contains(&rise_k[1 - absent]), "{rise_k:?}");
    }
}

#[test]
fn a_set_point_out_of_reach_has_no_margins() {
    let drive = Drive::Setpoints { low_c: -40.0, high_c: -30.0, dwell_ticks: 10, seed: 1 };
    let mut controller = running([drive, drive]);
    // Into 200 K/W the high level, 41 mW, warms by 8 K: −40 °C, 10 K above the reference, is out of
    // reach, and so is −30 °C.
    let config = SelfHeatingConfig { r_k_per_w: [200.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], ..model() };
    controller.elements[1].as_mut().unwrap().model = Some(crate::model::SelfHeating::new(&config, 0.01).unwrap());
    let margins: Vec<_> = controller.margins().collect();
    assert!(margins[0].is_some() && margins[1].is_none(), "{margins:?}");
}
