//! Records whose rows stand at times of their own.

use super::*;
use crate::identify::{IdentifyOptions, identify};
use crate::model::export::cauer::cauer;

/// 2 and 6 K/W with 1 ms and 10 s, ten rows a decade from 10 µs to 100 s at 3 W, 25 °C at rest,
/// readings to 0.1 mK.
fn heated() -> String {
    let row = |n: usize| {
        let time_s = libm::pow(10.0, n as f64 / 10.0 - 5.0);
        let rise_k = 3.0 * (-2.0 * libm::expm1(-time_s / 1e-3) - 6.0 * libm::expm1(-time_s / 10.0));
        format!("{time_s:.9e},3,{:.4}\n", 25.0 + rise_k)
    };
    (0..=70).map(row).collect()
}

#[test]
fn a_transient_that_begins_just_after_zero_is_heated_since_then_and_gives_its_ladder() {
    let file = file("tester.csv", &format!("time_s,power_w,temperature_c\n{}", heated()));
    let mut record = open(std::slice::from_ref(&file.path), &Selection::default()).unwrap();
    let survey = record.survey();
    assert_eq!((survey.rows, survey.is_uneven, survey.first_time_s), (72, true, 0.0));
    assert!((survey.sample_period_s / 1e-5 - 1.0).abs() < 1e-9 && (survey.duration_s() - 100.0).abs() < 1e-6);
    assert!(survey.notes.iter().any(|note| note.contains("its power is taken to be held since 0 s")));
    let model = identify(&mut *record, &IdentifyOptions::default(), &mut |_, _, _| {}, &mut |_| {}).unwrap();
    let pair = &model.pairs[0];
    let class = &pair.classes["all"];
    let [low, high] = class.interval_95.unwrap();
    assert!(low < 8.0 && 8.0 < high, "{low} to {high}");
    assert!(model.provenance.uneven_times);
    let ladder = cauer(&pair.mesh_rad_s, &class.r_k_per_w).unwrap();
    assert_eq!(ladder.len(), 2, "{ladder:?}");
    // A ladder of 2 and 6 K/W whose time constants lie four decades apart.
    assert!((ladder[0].resistance_k_per_w - 2.0).abs() < 0.02 && (ladder[1].resistance_k_per_w - 6.0).abs() < 0.02);
}

#[test]
fn options_that_need_uniform_times_are_refused_by_name() {
    let file = file("tester.csv", &format!("time_s,power_w,temperature_c\n{}", heated()));
    let mut record = open(std::slice::from_ref(&file.path), &Selection::default()).unwrap();
    let options = IdentifyOptions { free_poles: Some(2), ..IdentifyOptions::default() };
    let error = identify(&mut *record, &options, &mut |_, _, _| {}, &mut |_| {}).unwrap_err().to_string();
    assert!(error.contains("has times that are not uniform, for which --free-poles is not worked out"), "{error}");
}
