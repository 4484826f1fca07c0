extern crate std;
use super::*;

const SHARES: CalibrationUncertainty = CalibrationUncertainty {
    conductance_share: [0.0, 1e-3, 1e-3, 3e-3],
    speed_share: [0.02, 0.01, 0.01, 0.04],
    direction_rad: [0.01, 0.002, 0.002, 0.02],
    chi_square_most: 7.0,
};
/// 1 m/s is Re 10; from 1 to 8 m/s, so that a knot stands at each doubling.
const SCALE: SpeedScale = SpeedScale { reynolds: [10.0, 80.0], per_speed: 10.0, away: [0.0; 2] };
const MOST_RAD: f32 = 0.3;

fn wind(wind_m_s: [f32; 3], chi_square: f32) -> WindEstimate {
    let variance = 1e-6;
    WindEstimate {
        wind_m_s,
        speed_m_s: crate::arithmetic::length(wind_m_s),
        covariance_m2_s2: [[variance, 0.0, 0.0], [0.0, variance, 0.0], [0.0, 0.0, variance]],
        speed_error_m_s: 1e-3,
        direction_error_rad: 1e-3 / crate::arithmetic::length(wind_m_s),
        chi_square,
        degrees_of_freedom: 1,
        quality: QualityFlags::default(),
        ..WindEstimate::none()
    }
}

/// Conductances of four surfaces, each known to `share` of itself by the noise.
fn measured(share: f32) -> [Option<MeasuredConductance>; 4] {
    [1e-3, 2e-3, 1.5e-3, 1e-3]
        .map(|g: f32| Some(MeasuredConductance { conductance_w_k: g, variance_w2_k2: square(share * g) }))
}

fn near(a: f32, b: f32) {
    assert!((a - b).abs() <= 1e-4 * b.abs() + 1e-9, "{a} for {b}");
}

#[test]
fn the_shares_of_speed_and_direction_add_along_and_across_the_wind() {
    // Half-way between the knots at 4 and 8 m/s, in the logarithm.
    let speed = 32_f32.sqrt();
    let (along, across) = (0.025 * speed, 0.011 * speed);
    let found = SHARES.added_to(wind([0.6 * speed, 0.0, -0.8 * speed], 0.5), &measured(1.0), &SCALE, MOST_RAD);
    near(found.speed_error_m_s, libm::hypotf(along, 1e-3));
    near(found.direction_error_rad, libm::hypotf(across / speed, 1e-3 / speed));
    let c = found.covariance_m2_s2;
    near(c[0][0], 1e-6 + 0.36 * along * along + 0.64 * across * across);
    near(c[1][1], 1e-6 + across * across);
    near(c[0][2], -0.48 * (along * along - across * across));
    assert_eq!(c[0][2].to_bits(), c[2][0].to_bits());
    assert_eq!(found.quality, QualityFlags::default());
}

#[test]
fn below_the_calibration_errors_keep_their_size_and_above_their_share() {
    let at = |speed: f32| SHARES.added_to(wind([speed, 0.0, 0.0], 0.5), &measured(1.0), &SCALE, MOST_RAD);
    near(at(0.25).speed_error_m_s, libm::hypotf(0.02, 1e-3));
    near(at(0.25).direction_error_rad, libm::hypotf(0.04, 4e-3));
    near(at(80.0).speed_error_m_s, 3.2);
    assert!(at(0.03).quality.has(QualityFlags::NO_DIRECTION), "0.33 rad");
    let still = at(0.0);
    assert!(still.speed_error_m_s.is_finite() && still.covariance_m2_s2[1][1] >= square(0.01), "{still:?}");
}

#[test]
fn residuals_beyond_the_calibration_are_flagged_and_widen_the_uncertainty() {
    // At 2 m/s the calibration misses conductances by 0.1 %, as much as the noise: half of χ².
    let at = |chi_square| SHARES.added_to(wind([0.0, 2.0, 0.0], chi_square), &measured(1e-3), &SCALE, MOST_RAD);
    let explained = at(13.9);
    assert!(!explained.quality.has(QualityFlags::INCONSISTENT));
    near(explained.chi_square, 6.95);
    let contradicted = at(32.0);
    assert!(contradicted.quality.has(QualityFlags::INCONSISTENT));
    near(contradicted.chi_square, 16.0);
    near(contradicted.speed_error_m_s, 8.0 * explained.speed_error_m_s);
    near(contradicted.direction_error_rad, 8.0 * explained.direction_error_rad);
    near(contradicted.covariance_m2_s2[2][2], 64.0 * explained.covariance_m2_s2[2][2]);
    // Without a conductance to spare nothing can contradict.
    let spare = WindEstimate { degrees_of_freedom: 0, ..wind([0.0, 2.0, 0.0], 32.0) };
    assert_eq!(SHARES.added_to(spare, &measured(1e-3), &SCALE, MOST_RAD).quality, QualityFlags::default());
}

#[test]
fn a_wind_that_failed_stays_as_it_is() {
    let failed = WindEstimate::none();
    assert_eq!(SHARES.added_to(failed, &measured(1.0), &SCALE, MOST_RAD), failed);
}

#[test]
fn shares_that_cannot_be_are_refused() {
    let mut bad = SHARES;
    bad.speed_share[3] = 1.5;
    assert_eq!(bad.checked().unwrap_err().parameter, Parameter::CalibrationUncertainty);
    bad = SHARES;
    bad.direction_rad[0] = f32::NAN;
    assert!(bad.checked().is_err());
    assert!(CalibrationUncertainty { chi_square_most: 0.5, ..SHARES }.checked().is_err());
    assert_eq!(SHARES.checked(), Ok(SHARES));
}

#[test]
fn what_was_contradicted_a_minute_ago_is_still_flagged() {
    let (good, bad) = (QualityFlags::default(), QualityFlags::INCONSISTENT);
    let mut memory = ContradictionMemory::default();
    // Ten estimates a second: one of ten that is contradicted by chance or by jumps of the wind,
    // then a fault that every other wind shows.
    let gain = 0.1 / MEMORY_S;
    let flagged = |memory: &mut ContradictionMemory, every: u32, count: u32| {
        let of = |n: u32| if n.is_multiple_of(every) { bad } else { good };
        (0..count).filter(|&n| memory.with(of(n), gain).has(bad)).count()
    };
    assert_eq!(flagged(&mut memory, 10, 30_000), 3_000, "by chance, each by itself");
    flagged(&mut memory, 2, 9_000);
    assert_eq!(flagged(&mut memory, 2, 3_000), 3_000);
    // It is forgotten, but not by estimates that do not count.
    flagged(&mut memory, u32::MAX, 1);
    let before = memory;
    memory.with(QualityFlags::STARTING, gain);
    memory.with(QualityFlags(bad.0 | QualityFlags::SATURATED.0), gain);
    assert_eq!(memory, before);
    for _ in 0..9_000 {
        memory.with(good, gain);
    }
    assert_eq!(memory.with(good, gain), good);
}

#[test]
fn winds_slower_than_all_of_the_calibration_are_flagged_and_quiescent_gas_is_not() {
    let at = |speed: f32| SHARES.added_to(wind([speed, 0.0, 0.0], 0.5), &measured(1.0), &SCALE, MOST_RAD).quality;
    for (speed, is_below) in [(0.01, false), (0.3, true), (0.9, true), (0.99, false), (1.5, false)] {
        assert_eq!(at(speed).has(QualityFlags::BELOW_CALIBRATION), is_below, "{speed} m/s");
    }
}
