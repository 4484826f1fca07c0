//! The studies of closed loops and of the spheres: every bar is met, but for those that are named
//! here with their reason.

use anemo_tests::studies::study;

#[test]
fn a_die_takes_the_power_that_was_predicted() {
    let findings = study("rems-loops", 2, &[]);
    // Without the one-bit rule the prediction is of another mean temperature, and beyond the bar.
    let limits = findings.findings.iter().filter(|finding| finding.what.contains("limit of fast sampling"));
    let rms: Vec<f64> = limits.map(|of| of.ours.split(' ').next().unwrap().parse().unwrap()).collect();
    assert!(rms.len() == 2 && rms.iter().all(|rms| *rms > 2.0), "{rms:?}");
}

#[test]
fn sphere_a_has_a_tail_and_sphere_b_has_none() {
    study("sphere-response", 7, &[]);
}

#[test]
fn models_tell_the_slow_sphere_from_the_fast_one() {
    study("sphere-identification", 2, &[]);
}
