use super::*;
use crate::model::pair_class::PairClass;
use crate::model::testing;
use crate::predict::chatter::chatter;

const REQUIREMENTS: Requirements = Requirements {
    rise_k: (20.0, 20.0),
    power_low_w: None,
    power_high_w: None,
    margin: 0.5,
    ripple_k: 0.1,
    response_s: None,
    reach_s: None,
};

/// A sector in still gas (153.4 K/W) and in two winds on its surface.
fn winds() -> Vec<LoopModel> {
    let mut model = testing::model(&[0.02, 0.1, 1.0, 60.0], &[60.0, 90.0, 3.0, 0.4]);
    testing::add_wind(&mut model, "gust", 0.005);
    let still = PairClass::find(&model, None, Some("still")).unwrap();
    let gust = PairClass::find(&model, None, Some("gust")).unwrap();
    let breeze = PairClass { label: "breeze", wind_w_per_k: Some(0.002), ..gust };
    [still, breeze, gust].iter().map(|part| LoopModel::of(part, None).unwrap()).collect()
}

#[test]
fn levels_enclose_every_wind_and_the_trial_is_what_was_predicted() {
    let design = design(&winds(), &Requirements { reach_s: Some(60.0), ..REQUIREMENTS }).unwrap();
    // u_Q = ΔT (1/ΣR + ΔG)
    let (still_w, gust_w) = (20.0 / 153.4, 20.0 / 153.4 + 20.0 * 0.005);
    assert!((design.power_low_w / (0.5 * still_w) - 1.0).abs() < 1e-9);
    assert!(design.power_high_w >= 1.5 * gust_w * (1.0 - 1e-9));
    for wind in &design.winds {
        assert!(wind.margins_w.0 > 0.0 && wind.margins_w.1 > 0.0);
        // The loop notices at the first tick after it has arrived.
        let late_s = wind.trial.reaching_time_s.unwrap() - wind.reaching_time_s;
        assert!((-1e-9..=design.sample_period_s + 1e-9).contains(&late_s), "{}: {late_s}", wind.label);
        assert!(wind.reaching_time_s <= 60.0);
        // one bit in 45 000 ticks, and what the swing leaves in the states: some 10⁻³ of the range
        let range_w = design.power_high_w - design.power_low_w;
        assert!((wind.trial.mean_power_w - wind.steady_power_w).abs() < 2e-3 * range_w, "{wind:?}");
        assert!(wind.chatter_k <= 0.1 && wind.trial.swing_k < 1.1 * wind.chatter_k, "{wind:?}");
        assert!(wind.trial.swing_k > 0.3 * wind.chatter_k, "{wind:?}");
    }
    assert_eq!(design.settling_s, Some(0.0));
    let one_bit_w = (design.power_high_w - design.power_low_w) * design.sample_period_s;
    assert!((design.resolution_w / one_bit_w - 1.0).abs() < 1e-12);
}

#[test]
fn the_period_is_the_longest_that_keeps_the_swing() {
    let winds = winds();
    let found = design(&winds, &REQUIREMENTS).unwrap();
    let range_w = found.power_high_w - found.power_low_w;
    let mut unheard = Vec::new();
    // Twice or two and a half times as long would swing further.
    let swing_k = |period_s| chatter(&winds[0].surface, period_s, 0.0, 0.0, range_w).peak_to_peak_k();
    assert!(swing_k(found.sample_period_s) <= 0.1 && swing_k(2.5 * found.sample_period_s) > 0.1);
    let finer = period::sample_period_s(&winds, range_w, 0.02, period::LONGEST_S, &mut unheard).unwrap();
    assert!(finer < found.sample_period_s);
}

#[test]
fn a_range_gives_the_highest_set_point_that_the_given_levels_hold() {
    let wanted = Requirements { rise_k: (5.0, 40.0), power_low_w: Some(0.01), power_high_w: Some(0.4), ..REQUIREMENTS };
    let found = design(&winds(), &wanted).unwrap();
    // 1.5 ΔT (1/ΣR + ΔG) = 0.4
    let exact_k = 0.4 / 1.5 / (1.0 / 153.4 + 0.005);
    assert!((found.rise_k / exact_k - 1.0).abs() < 1e-12, "{} {exact_k}", found.rise_k);
    assert_eq!((found.power_low_w, found.power_high_w), (0.01, 0.4));
}

#[test]
fn requirements_that_cannot_be_met_are_refused_with_what_could_be() {
    let winds = winds();
    let refused = |wanted: Requirements| design(&winds, &wanted).unwrap_err().to_string();
    let too_low = refused(Requirements { power_high_w: Some(0.2), ..REQUIREMENTS });
    assert!(too_low.contains("in `gust` it takes 0.23038 W") && too_low.contains("0.34557 W or more"), "{too_low}");
    assert!(too_low.contains("the given levels hold 0.000 to 11.575 K"), "{too_low}");
    let too_high = refused(Requirements { power_low_w: Some(0.1), ..REQUIREMENTS });
    assert!(too_high.contains("in `still`") && too_high.contains("0.06519 W or less"), "{too_high}");
    let ripple = refused(Requirements { ripple_k: 1e-4, ..REQUIREMENTS });
    assert!(ripple.contains("at 0.001 s, the shortest period"), "{ripple}");
    let late = refused(Requirements { power_high_w: Some(0.4), reach_s: Some(0.5), ..REQUIREMENTS });
    assert!(late.contains("is not reached in 0.5 s") && late.contains("W or more"), "{late}");
    assert!(refused(Requirements { rise_k: (-1.0, 3.0), ..REQUIREMENTS }).contains("above zero"));
    assert!(refused(Requirements { rise_k: (-5.0, -5.0), ..REQUIREMENTS }).starts_with("the set-point -5 K must be"));
    assert!(refused(Requirements { rise_k: (f64::NAN, 3.0), ..REQUIREMENTS }).contains("above zero"));
    assert!(refused(Requirements { margin: 1.0, ..REQUIREMENTS }).contains("between 0 and 1"));
    assert!(
        refused(Requirements { power_low_w: Some(0.5), power_high_w: Some(0.4), ..REQUIREMENTS })
            .contains("must be above")
    );
    assert!(design(&[], &REQUIREMENTS).unwrap_err().to_string().contains("no wind"));
}

#[test]
fn a_tail_of_the_structure_is_said_before_anything_is_built() {
    // Symbols of their own, in which the wind changes the slow pole: mismatched.
    let of = |r: &[f64], label: &str| {
        let model = testing::model(&[0.02, 1.0], r);
        let mut loop_model = LoopModel::of(&PairClass::find(&model, None, None).unwrap(), None).unwrap();
        label.clone_into(&mut loop_model.label);
        loop_model
    };
    let winds = [of(&[60.0, 30.0], "calm"), of(&[30.0, 30.0], "storm")];
    let refused = design(&winds, &Requirements { response_s: Some(1.0), ..REQUIREMENTS }).unwrap_err().to_string();
    assert!(refused.contains("cannot be had") && refused.contains("That tail is the structure's"), "{refused}");
    assert!(
        design(&winds, &Requirements { response_s: Some(500.0), ..REQUIREMENTS }).unwrap().settling_s.unwrap() > 1.0
    );
}

#[test]
fn levels_that_stand_in_the_way_of_a_response_are_moved_or_refused() {
    // The wind takes from the fast pole: u_eq jumps to 2.5 times its value, and falls to 1.4 times.
    let of = |r: &[f64], label: &str| {
        let model = testing::model(&[0.02, 1.0], r);
        let mut loop_model = LoopModel::of(&PairClass::find(&model, None, None).unwrap(), None).unwrap();
        label.clone_into(&mut loop_model.label);
        loop_model
    };
    let winds = [of(&[50.0, 50.0], "calm"), of(&[50.0, 20.0], "storm")];
    let wanted = Requirements { ripple_k: 1.0, margin: 0.2, ..REQUIREMENTS };
    let plain = design(&winds, &wanted).unwrap();
    assert!(plain.reasons.iter().any(|reason| reason.contains("with a low level below the")), "{:?}", plain.reasons);
    let slow_s = plain.settling_s.unwrap();
    let fast = design(&winds, &Requirements { response_s: Some(slow_s), ..wanted.clone() }).unwrap();
    assert!(fast.settling_s.unwrap() < slow_s && fast.power_high_w > plain.power_high_w);
    let wished = Requirements { response_s: Some(0.98 * slow_s), power_high_w: Some(plain.power_high_w), ..wanted };
    let refused =
        design(&winds, &Requirements { power_low_w: Some(plain.power_low_w), ..wished }).unwrap_err().to_string();
    assert!(refused.contains("cannot be had between") && refused.contains("level "), "{refused}");
}

#[test]
fn a_demand_that_comes_later_is_met_by_levels_beyond_it() {
    // From 0.14 W at once to 0.17, to 0.29 after some nine seconds, and in the end to 0.18 W: heat
    // flows on into the slowest pole.
    let of = |r: &[f64], label: &str| {
        let model = testing::model(&[0.02, 0.2, 2.0], r);
        let mut loop_model = LoopModel::of(&PairClass::find(&model, None, None).unwrap(), None).unwrap();
        label.clone_into(&mut loop_model.label);
        loop_model
    };
    let winds = [of(&[10.0, 90.0, 40.0], "calm"), of(&[60.0, 10.0, 40.0], "storm")];
    let change = crate::predict::analysis::change_between(&winds[0], &winds[1], winds[0].unheated_c + 20.0).unwrap();
    let [_, (most_s, most_w)] = change.extremes_w().unwrap();
    assert!(
        (5.0..15.0).contains(&most_s) && most_w > 1.4 * change.at_once_w.max(change.finally_w),
        "{most_s} {most_w}"
    );
    let free_s = change.settled_s(0.02).unwrap();
    let back = crate::predict::analysis::change_between(&winds[1], &winds[0], winds[0].unheated_c + 20.0).unwrap();
    let worst_s = free_s.max(back.settled_s(0.02).unwrap());
    // Required is no more than the structure takes: the levels that are chosen cost nothing.
    let wanted = Requirements { response_s: Some(1.001 * worst_s), ripple_k: 1.0, margin: 0.2, ..REQUIREMENTS };
    let found = design(&winds, &wanted).unwrap();
    assert!(found.power_high_w > most_w, "{} {most_w}", found.power_high_w);
    // Given levels between which u_eq begins and ends, but does not stay.
    let changes = settling::changes(&winds, winds[0].unheated_c + 20.0);
    let levels_w = (found.power_low_w, 0.19);
    let refused =
        settling::settling_s(&changes[..1], Some(1.001 * free_s), levels_w, &mut Vec::new()).err().unwrap().to_string();
    let named = format!("a high level above the {most_w:.5} W that it needs {most_s:.3} s after the change");
    assert!(refused.contains(&named) && refused.ends_with(&format!("it would be {free_s:.3} s")), "{refused}");
}

#[test]
fn with_one_wind_a_response_is_not_looked_at_and_that_is_said() {
    let found = design(&winds()[..1], &Requirements { response_s: Some(5.0), ..REQUIREMENTS }).unwrap();
    assert!(found.reasons.iter().any(|reason| reason.contains("one wind only")), "{:?}", found.reasons);
}
