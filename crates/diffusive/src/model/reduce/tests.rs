use dr_core::model::mesh;

use super::*;
use crate::model::testing;

fn geometric(first: f64, last: f64, order: usize) -> Vec<f64> {
    (0..order).map(|k| mesh::rate_rad_s(first, last, k, order)).collect()
}

/// Cole–Cole with α = ½ and τ = 1 s on a mesh of 20 rates: all of them weigh.
fn twenty() -> Model {
    let rates = geometric(1e-3, 10.0, 20);
    let ratio = libm::log(libm::pow(1e4, 1.0 / 19.0));
    let r: Vec<f64> = rates.iter().map(|rate| rate.sqrt() / (std::f64::consts::PI * (1.0 + rate)) * ratio).collect();
    testing::model(&rates, &r)
}

#[test]
fn two_poles_among_zeros_come_back_exactly() {
    let rates = geometric(1e-3, 10.0, 20);
    let mut r = vec![0.0; 20];
    (r[4], r[13]) = (300.0, 2.5);
    let reduced = reduce(&testing::model(&rates, &r), 8, Rates::Free).unwrap();
    let pair = &reduced.model.pairs[0];
    // to the rounding of f32
    assert_eq!(pair.mesh_rad_s, [f64::from(rates[4] as f32), f64::from(rates[13] as f32)]);
    for (value, expected) in pair.classes["all"].r_k_per_w.iter().zip([300.0, 2.5]) {
        assert!((value / expected - 1.0).abs() < 1e-6, "{pair:?}");
    }
    let se = &pair.classes["all"].se_k_per_w;
    assert!(se.iter().all(|se| *se > 0.0 && se.is_finite()), "{se:?}");
    let loss = &reduced.losses[0];
    assert!(loss.levels.rms_share < 1e-6 && loss.bits.rms_share < 1e-4, "{loss:?}");
}

#[test]
fn eight_free_poles_stand_for_twenty() {
    let model = twenty();
    let free = reduce(&model, 8, Rates::Free).unwrap();
    let mesh = reduce(&model, 8, Rates::Mesh).unwrap();
    let (free_loss, mesh_loss) = (&free.losses[0], &mesh.losses[0]);
    println!("20 → 8 poles, free: {free_loss:?}\nmesh: {mesh_loss:?}");
    for loss in [free_loss, mesh_loss] {
        assert!(loss.bits.rms_share < 1e-2 && loss.levels.rms_share < 1e-2, "{loss:?}");
        assert!(loss.steady_gain_change.abs() < 1e-2, "{loss:?}");
    }
    assert!(free_loss.bits.rms_share < 1e-3 && free_loss.levels.rms_share < 1e-3, "{free_loss:?}");
    assert_eq!(free.model.pairs[0].mesh_rad_s.len(), 8);
    assert_eq!(free.model.chosen.order, 8);
    assert!(free.model.chosen.reasons[0].contains("reduced from 20 to 8 poles"));
    // A model like any other.
    assert_eq!(Model::from_json(&free.model.to_json()).unwrap(), free.model);
}

#[test]
fn fewer_poles_lose_more_and_none_is_negative() {
    let model = twenty();
    let losses: Vec<f64> = (1..=8)
        .map(|order| {
            let reduced = reduce(&model, order, Rates::Free).unwrap();
            assert!(reduced.model.pairs[0].classes["all"].r_k_per_w.iter().all(|r| *r >= 0.0));
            reduced.losses[0].levels.rms_share
        })
        .collect();
    println!("share lost by 1 … 8 free poles: {losses:.6?}");
    assert!(losses.windows(2).all(|two| two[1] < two[0]), "{losses:?}");
}

#[test]
fn every_pair_and_class_is_reduced_on_rates_that_its_classes_share() {
    let mut model = twenty();
    let rates = model.pairs[0].mesh_rad_s.clone();
    let gust: Vec<f64> = rates.iter().map(|rate| 3.0 / (1.0 + 5.0 * rate)).collect();
    model.classes.push("gust".to_owned());
    model.pairs[0].classes.insert("gust".to_owned(), testing::class(&gust));
    // Cross-heating: slow, of both signs, zero at the first instant.
    model.inputs.push("power_w_b".to_owned());
    let cross: Vec<f64> = rates.iter().map(|rate| (0.01 / rate).min(1.0) - 0.3 * rate / (0.2 + rate)).collect();
    let classes = [("all".to_owned(), testing::class(&cross)), ("gust".to_owned(), testing::class(&cross))];
    model.pairs.push(Pair {
        input: "power_w_b".to_owned(),
        non_negative: false,
        classes: classes.into(),
        dead_time_samples: 2,
        ..model.pairs[0].clone()
    });
    let reduced = reduce(&model, 6, Rates::Free).unwrap();
    assert_eq!(reduced.losses.len(), 4);
    for loss in &reduced.losses {
        println!("{loss:?}");
        assert!(loss.bits.rms_share < 2e-2 && loss.levels.rms_share < 2e-2, "{loss:?}");
    }
    let pair = &reduced.model.pairs[1];
    assert_eq!((pair.dead_time_samples, pair.mesh_rad_s.len()), (2, 6));
    assert!(pair.classes.values().all(|class| class.r_k_per_w.len() == 6 && class.se_k_per_w.len() == 6));
    Model::from_json(&reduced.model.to_json()).unwrap();
}

#[test]
fn a_single_pole_is_a_mesh_of_one() {
    let reduced = reduce(&testing::model(&[0.5], &[10.0]), 8, Rates::Mesh).unwrap();
    assert_eq!(reduced.model.pairs[0].mesh_rad_s, [0.5]);
    assert!(reduced.losses[0].levels.rms_share < 1e-6);
}

#[test]
fn a_pair_without_effect_stays_one() {
    let reduced = reduce(&testing::model(&[0.1, 1.0], &[0.0, 0.0]), 4, Rates::Free).unwrap();
    assert_eq!(reduced.model.pairs[0].classes["all"].r_k_per_w, [0.0]);
    assert_eq!(reduced.losses[0].levels.rms_share, 0.0);
}

#[test]
fn orders_that_the_board_does_not_have_are_refused() {
    for order in [0, 9] {
        let sentence = reduce(&twenty(), order, Rates::Free).unwrap_err().to_string();
        assert_eq!(sentence, format!("a model for the board has 1 to 8 poles a pair, not {order}"));
    }
}
