//! Errors against the covariance that is stated, and measurements that are none.

extern crate std;

use super::super::sphere::{SECTORS, hemispheres, tetrahedral_sectors};
use super::table::{TestRandom, carbon_dioxide, conductances, narrow, wide};
use super::{measured, sphere_a, sphere_b};
use crate::wind::{MeasuredConductance, QualityFlags, WindState};

const PRESSURE_PA: f64 = 1000.0;

/// True conductances with noise of a share of each, and that share as their standard error.
fn noisy<const N: usize>(truth: [f64; N], share: f64, random: &mut TestRandom) -> [Option<MeasuredConductance>; N] {
    truth.map(|g| {
        let sigma = share * g;
        let conductance_w_k = (g + sigma * random.normal()) as f32;
        Some(MeasuredConductance { conductance_w_k, variance_w2_k2: (sigma * sigma) as f32 })
    })
}

/// e · C⁻¹ e, by cofactors in f64.
fn distance_2(covariance: [[f32; 3]; 3], error: [f32; 3]) -> f64 {
    let (c, e) = (covariance.map(wide), wide(error));
    let cofactor = |i: usize, j: usize| {
        let (i1, i2, j1, j2) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
        c[i1][j1] * c[i2][j2] - c[i1][j2] * c[i2][j1]
    };
    let determinant: f64 = (0..3).map(|j| c[0][j] * cofactor(0, j)).sum();
    (0..9).map(|k| e[k / 3] * cofactor(k / 3, k % 3) * e[k % 3]).sum::<f64>() / determinant
}

#[test]
fn errors_lie_within_the_stated_covariance() {
    const DRAWS: usize = 6000;
    let (vector, gas, mut random) = (sphere_b(), carbon_dioxide(PRESSURE_PA), TestRandom::new(4));
    // Complete from weak winds on, and with one sector missing.
    for (missing, least_speed) in [(false, 1.0_f64), (false, 0.06), (true, 1.0)] {
        let (mut inside, mut ellipsoid, mut speeds) = ([0; 3], 0, 0);
        let (mut chi_square, mut direction_2, mut speed_2) = (0.0, 0.0, 0.0);
        for n in 0..DRAWS {
            let speed = if least_speed < 1.0 {
                least_speed * libm::pow(9.0 / least_speed, random.even())
            } else {
                1.0 + 8.0 * random.even()
            };
            let truth = narrow(random.direction().map(|x| speed * x));
            let exact = conductances(&tetrahedral_sectors(0.01), PRESSURE_PA, truth.map(f64::from));
            let mut given = noisy(exact, 1e-3, &mut random);
            if missing {
                given[n % SECTORS] = None;
            }
            // The last wind was this one: which of two it is, where there are two, is not what is
            // tested here.
            let wind = vector.step(&mut WindState { last_m_s: Some(truth) }, &gas, &given);
            assert!(!wind.quality.has(QualityFlags::FAILED), "{truth:?} {wind:?}");
            let error: [f32; 3] = core::array::from_fn(|k| wind.wind_m_s[k] - truth[k]);
            for k in 0..3 {
                let sigma = f64::from(wind.covariance_m2_s2[k][k]).sqrt();
                inside[k] += usize::from(f64::from(error[k].abs()) < 1.959_964 * sigma);
            }
            // 95 % of a χ² of three.
            ellipsoid += usize::from(distance_2(wind.covariance_m2_s2, error) < 7.814_728);
            speeds +=
                usize::from((f64::from(wind.speed_m_s) - speed).abs() < 1.959_964 * f64::from(wind.speed_error_m_s));
            chi_square += f64::from(wind.chi_square);
            direction_2 += f64::from(wind.direction_error_rad).powi(2);
            speed_2 += (f64::from(wind.speed_error_m_s) / speed).powi(2);
            assert_eq!(wind.degrees_of_freedom, u8::from(!missing));
            assert_eq!(wind.quality.has(QualityFlags::DEGRADED), missing);
        }
        let share = |count: usize| 100.0 * count as f64 / DRAWS as f64;
        std::println!(
            "0.1 % noise, {} sectors, from {least_speed} m/s: 95 % intervals hold {:.1} {:.1} {:.1} %, speed {:.1} %, ellipsoid {:.1} %; χ² {:.3}; stated errors {:.3}° and {:.3} % rms",
            if missing { 3 } else { 4 },
            share(inside[0]),
            share(inside[1]),
            share(inside[2]),
            share(speeds),
            share(ellipsoid),
            chi_square / DRAWS as f64,
            (direction_2 / DRAWS as f64).sqrt().to_degrees(),
            100.0 * (speed_2 / DRAWS as f64).sqrt(),
        );
        for count in inside.into_iter().chain([ellipsoid, speeds]) {
            // 95 % of 6000 draws has a standard error of 0.3 %.
            assert!((93.0..=97.0).contains(&share(count)), "{}", share(count));
        }
        if !missing {
            assert!((chi_square / DRAWS as f64 - 1.0).abs() < 0.1);
        }
    }
}

#[test]
fn errors_of_two_hemispheres_lie_within_what_is_stated() {
    const DRAWS: usize = 6000;
    let (vector, gas, mut random) = (sphere_a(), carbon_dioxide(PRESSURE_PA), TestRandom::new(9));
    let (mut along, mut speeds) = (0, 0);
    for _ in 0..DRAWS {
        let speed = 1.0 + 8.0 * random.even();
        let truth = random.direction().map(|x| speed * x);
        let given = noisy(conductances(&hemispheres(0.01), PRESSURE_PA, truth), 1e-3, &mut random);
        let wind = vector.step(&mut WindState::default(), &gas, &given);
        assert!(!wind.quality.has(QualityFlags::FAILED), "{truth:?} {wind:?}");
        let error = (f64::from(wind.wind_m_s[0]) - truth[0]).abs();
        along += usize::from(error < 1.959_964 * f64::from(wind.covariance_m2_s2[0][0]).sqrt());
        speeds += usize::from((f64::from(wind.speed_m_s) - speed).abs() < 1.959_964 * f64::from(wind.speed_error_m_s));
    }
    let share = |count: usize| 100.0 * count as f64 / DRAWS as f64;
    std::println!(
        "two hemispheres, 0.1 % noise: 95 % intervals hold {:.1} % along, speed {:.1} %",
        share(along),
        share(speeds)
    );
    for count in [along, speeds] {
        assert!((93.0..=97.0).contains(&share(count)), "{}", share(count));
    }
}

#[test]
fn errors_that_the_variances_do_not_know_show_in_chi_square_and_do_not_stop_it() {
    let (vector, gas, mut random) = (sphere_b(), carbon_dioxide(PRESSURE_PA), TestRandom::new(8));
    let (mut chi_square, mut worst) = (0.0, 0.0_f64);
    for _ in 0..2000 {
        let speed = 0.5 + 8.5 * random.even();
        let truth = random.direction().map(|x| speed * x);
        let exact = conductances(&tetrahedral_sectors(0.01), PRESSURE_PA, truth);
        // A calibration that is 3 % wrong on each sector, with readings stated to be right to 0.1
        // %.
        let wrong = exact.map(|g| g * (1.0 + 0.03 * random.normal()));
        let wind = vector.step(&mut WindState::default(), &gas, &measured(wrong, 1e-3));
        assert!(
            !wind.quality.has(QualityFlags::FAILED) && !wind.quality.has(QualityFlags::NO_DIRECTION),
            "{truth:?} {wind:?}"
        );
        chi_square += f64::from(wind.chi_square) / 2000.0;
        let error: [f64; 3] = core::array::from_fn(|k| f64::from(wind.wind_m_s[k]) - truth[k]);
        worst = worst.max(error.iter().map(|e| e * e).sum::<f64>().sqrt() / speed);
    }
    std::println!(
        "3 % errors stated as 0.1 %: χ² {chi_square:.0}, worst error of the vector {:.0} % of speed",
        100.0 * worst
    );
    // 30², and for the worst of 2000 at 0.5 m/s, where front and rear differ least, some five
    // standard errors.
    assert!((600.0..1200.0).contains(&chi_square), "{chi_square}");
    assert!(worst < 0.4, "{worst}");
}

#[test]
fn still_gas_has_no_direction_and_a_speed_within_its_error() {
    let (vector, gas, mut random) = (sphere_b(), carbon_dioxide(PRESSURE_PA), TestRandom::new(5));
    let still = conductances(&tetrahedral_sectors(0.01), PRESSURE_PA, [0.0; 3]);
    let exact = vector.step(&mut WindState::default(), &gas, &measured(still, 1e-3));
    assert!(
        !exact.quality.has(QualityFlags::FAILED)
            && exact.quality.has(QualityFlags::NO_DIRECTION)
            && exact.speed_m_s < 1e-3,
        "{exact:?}"
    );
    let mut largest = 0.0_f32;
    for _ in 0..2000 {
        let mut state = WindState::default();
        let wind = vector.step(&mut state, &gas, &noisy(still, 1e-3, &mut random));
        assert!(!wind.quality.has(QualityFlags::FAILED), "{wind:?}");
        assert!(wind.speed_m_s < 5.0 * wind.speed_error_m_s.max(wind.covariance_m2_s2[0][0].sqrt()), "{wind:?}");
        largest = largest.max(wind.speed_m_s);
        // A wind without direction is not remembered as one.
        assert_eq!(state.last_m_s.is_none(), wind.quality.has(QualityFlags::NO_DIRECTION));
    }
    std::println!("quiescent gas with 0.1 % noise: at most {largest:.4} m/s");
    // 0.1 % of Nu 2 against a slope of 0.3 a Reynolds number, 0.046 m/s a Reynolds number, four
    // standard errors.
    assert!(largest < 0.005, "{largest}");
}

#[test]
fn what_is_no_measurement_is_refused_and_said() {
    let (vector, gas) = (sphere_b(), carbon_dioxide(PRESSURE_PA));
    let truth = [2.0, -3.0, 1.0];
    let good = measured(conductances(&tetrahedral_sectors(0.01), PRESSURE_PA, truth), 1e-3);
    let spoiled = |bad: f32, of_variance: bool, count: usize| {
        let mut given = good;
        for measured in given.iter_mut().take(count).flatten() {
            if of_variance { measured.variance_w2_k2 = bad } else { measured.conductance_w_k = bad }
        }
        let wind = vector.step(&mut WindState { last_m_s: Some(narrow(truth)) }, &gas, &given);
        assert!(wind.is_finite(), "{bad}: {wind:?}");
        wind
    };
    for of_variance in [false, true] {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1e-4, 0.0] {
            let (one, two, all) =
                (spoiled(bad, of_variance, 1), spoiled(bad, of_variance, 2), spoiled(bad, of_variance, SECTORS));
            assert!(
                one.quality.has(QualityFlags::REFUSED)
                    && one.quality.has(QualityFlags::DEGRADED)
                    && !one.quality.has(QualityFlags::FAILED),
                "{bad}: {one:?}"
            );
            assert!((0..3).all(|k| (f64::from(one.wind_m_s[k]) - truth[k]).abs() < 1e-2), "{bad}: {one:?}");
            assert!(two.quality.has(QualityFlags::REFUSED) && two.quality.has(QualityFlags::FAILED), "{bad}: {two:?}");
            assert!(all.quality.has(QualityFlags::FAILED) && all.wind_m_s == [0.0; 3], "{bad}: {all:?}");
        }
        // Numbers, but absurd ones: whatever is answered is finite, which `spoiled` asserts.
        for absurd in [f32::MIN_POSITIVE, 1e-30, 1e-12, 1.0, 1e6, 1e30, f32::MAX] {
            for count in 1..=SECTORS {
                spoiled(absurd, of_variance, count);
            }
        }
    }
}
