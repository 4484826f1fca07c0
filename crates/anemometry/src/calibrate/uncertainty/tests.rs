use super::*;

/// 200 winds over Re 10 … 80, whose errors are by the noise and by what the calibration misses:
/// shares of speed and direction that grow threefold towards the fast end.
fn winds(noise: f64, missed: f64, spread: f64) -> Vec<ComparedWind> {
    // Normal deviates of variance one by the sum of twelve; a fixed sequence.
    let mut state = 7_u64;
    let mut uniform = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut normal = move || (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
    (0..200)
        .map(|n| {
            let place = f64::from(n) / 199.0;
            let own = missed * (1.0 + 2.0 * place);
            let (a, b) = (normal(), normal());
            ComparedWind {
                reynolds: 10.0 * libm::pow(8.0, place),
                direction_deg: Some((libm::hypot(noise, own) * libm::hypot(a, b)).to_degrees()),
                speed: noise * normal() + own * normal(),
                stated: StatedError {
                    speed_u: noise,
                    direction_u_rad: noise,
                    chi_square: (normal() * (1.0 + (spread * spread * 1e6)).sqrt()).powi(2),
                    degrees_of_freedom: 1,
                    precision: 1e6,
                    is_extrapolated: false,
                },
            }
        })
        .collect()
}

fn table(of: &[ComparedWind]) -> UncertaintyTable {
    uncertainty(of, of, [10.0, 80.0], 2.0).unwrap()
}

fn near(found: f64, expected: f64, within: f64) {
    assert!((found / expected - 1.0).abs() < within, "{found} for {expected}");
}

#[test]
fn shares_are_what_errors_have_beyond_the_noise() {
    let found = table(&winds(1e-3, 2e-3, 3e-3));
    // 2e-3 (1 + ⅔ p), squared and weighted by the distance from the knot p = 0 … 3.
    for (knot, expected) in [2.46e-3, 3.38e-3, 4.70e-3, 5.56e-3].into_iter().enumerate() {
        near(found.speed_share[knot], expected, 0.25);
        near(found.direction_deg[knot].to_radians(), expected, 0.25);
        near(found.conductance_share[knot], 3e-3, 0.5);
    }
    // 99 of a hundred by chance are below 6.63.
    assert!((5.5..12.0).contains(&found.chi_square_most), "{}", found.chi_square_most);
    assert!(found.config().checked().is_ok());
}

#[test]
fn where_the_noise_explains_all_half_of_it_may_be_the_calibration() {
    let found = table(&winds(1e-3, 0.0, 0.0));
    for knot in 0..KNOTS {
        near(found.speed_share[knot], 5e-4, 0.4);
        near(found.direction_deg[knot].to_radians(), 5e-4, 0.4);
        assert!(found.conductance_share[knot] < 1e-3, "{:?}", found.conductance_share);
    }
}

#[test]
fn winds_that_had_to_be_extrapolated_do_not_count_and_few_winds_are_none() {
    let mut few = winds(1e-3, 2e-3, 3e-3);
    let expected = table(&few[..190]);
    for wind in &mut few[190..] {
        wind.speed = 0.5;
        wind.stated.chi_square = 1e9;
        wind.stated.is_extrapolated = true;
    }
    assert_eq!(table(&few), expected);
    assert_eq!(uncertainty(&few[..3], &few[..3], [10.0, 80.0], 2.0), None);
}

/// One wind that the others hardly determine.
#[test]
fn an_outlier_does_not_make_the_calibration_blind() {
    let mut one = winds(1e-3, 2e-3, 3e-3);
    let expected = table(&one);
    one[150].stated.chi_square = 1e6;
    let found = table(&one);
    near(found.chi_square_most, expected.chi_square_most, 0.2);
    for knot in 0..KNOTS {
        near(found.conductance_share[knot], expected.conductance_share[knot], 0.1);
    }
}

#[test]
fn a_single_element_has_no_direction() {
    let mut winds = winds(1e-3, 2e-3, 3e-3);
    for wind in &mut winds {
        wind.direction_deg = None;
        wind.stated.degrees_of_freedom = 0;
        wind.stated.chi_square = 0.0;
    }
    let found = table(&winds);
    assert_eq!((found.direction_deg, found.conductance_share), ([0.0; KNOTS], [0.0; KNOTS]));
}

#[test]
fn few_winds_are_less_sure_as_students_table_has_it() {
    // GUM, table G.2, of 95.45 %.
    for (degrees, quantile) in [(4.0, 2.87), (5.0, 2.65), (8.0, 2.37), (10.0, 2.28), (20.0, 2.13), (50.0, 2.05)] {
        near(student(degrees), quantile / 2.0, 0.01);
    }
}
