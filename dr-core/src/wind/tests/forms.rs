//! Cylinders, wires and single elements: their winds come back, and what they leave open is said.

extern crate std;

use super::super::form::{HeadForm, MOST_SURFACES};
use super::super::surface_inverse::{MeasuredConductance, WindState, WindVector};
use super::table::carbon_dioxide;
use crate::error::Parameter;
use crate::wind::{GasState, NusseltConfig, QualityFlags, SurfaceConfig, WindEstimate};
use core::f64::consts::{PI, TAU};
use std::vec::Vec;

const DIAMETER_M: f32 = 6e-3;
const SHARE: f64 = 1e-3;
const NORTH: [f32; 3] = [0.0, 0.0, 1.0];

/// King's law, with the amplitudes of a smooth dependence on the angle.
fn king(angular: [f32; 5]) -> NusseltConfig {
    let amplitudes = core::array::from_fn(|j| {
        let reynolds = libm::powf(200.0, j as f32 / 31.0);
        let forced = 0.6 * libm::powf(reynolds, 0.47);
        let mut row = [0.5 + forced, 0.0, 0.0, 0.0, 0.0, 0.0];
        row[1..].iter_mut().zip(angular).for_each(|(a, share)| *a = share * forced);
        row
    });
    NusseltConfig { least_reynolds: 1.0, most_reynolds: 200.0, amplitudes }
}

fn at_angle(angle: f64) -> [f32; 3] {
    [libm::cos(angle) as f32, libm::sin(angle) as f32, 0.0]
}

fn surface(angle: f64, means: [f32; 5]) -> SurfaceConfig {
    SurfaceConfig { axis: at_angle(angle), corner: NORTH, area_m2: 1e-5, means, threefold: [0.0; 3] }
}

/// Sectors of equal width round a cylinder: a mean of cos mφ over each.
fn sectors(count: usize) -> Vec<SurfaceConfig> {
    let half = PI / count as f64;
    let means = core::array::from_fn(|m| {
        let x = (m + 1) as f64 * half;
        (libm::sin(x) / x) as f32
    });
    (0..count).map(|i| surface(TAU * i as f64 / count as f64, means)).collect()
}

fn cylinder(count: usize) -> WindVector {
    let nusselt = king([0.4, 0.25, -0.05, 0.04, 0.01]);
    WindVector::new(HeadForm::Cylinder, &nusselt, &sectors(count), DIAMETER_M, 0.5).unwrap()
}

fn wires(angles: &[f64]) -> WindVector {
    let surfaces: Vec<_> = angles.iter().map(|&angle| surface(angle, [1.0; 5])).collect();
    WindVector::new(HeadForm::Wires, &king([0.45, -0.05, 0.02, 0.0, 0.0]), &surfaces, DIAMETER_M, 0.5).unwrap()
}

fn estimated(head: &WindVector, gas: &GasState, wind_m_s: [f32; 3], off: f64) -> WindEstimate {
    let measured = head.conductances(gas, wind_m_s).map(|of| {
        let conductance_w_k = of.conductance_w_k * (1.0 + off as f32);
        let error_w_k = SHARE as f32 * conductance_w_k;
        Some(MeasuredConductance { conductance_w_k, variance_w2_k2: error_w_k * error_w_k })
    });
    head.step(&mut WindState::default(), gas, &measured)
}

fn off(a: [f32; 3], b: [f32; 3]) -> f32 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f32>().sqrt()
}

#[test]
fn wires_find_the_wind_that_they_face_whatever_the_last_one_was() {
    let gas = carbon_dioxide(700.0);
    let head = wires(&[0.3, 0.3 + PI / 2.0]);
    for n in 0..60 {
        let last = at_angle(0.3 + 1.618 * n as f64).map(|x| 3.0 * x);
        // Between the two axes: into that the wind blows which they face.
        let wind = at_angle(PI + 0.3 + PI / 4.0 + 0.6 * libm::sin(2.4 * n as f64)).map(|x| 4.0 * x);
        let measured = head.conductances(&gas, wind).map(|of| {
            let error_w_k = SHARE as f32 * of.conductance_w_k;
            Some(MeasuredConductance { conductance_w_k: of.conductance_w_k, variance_w2_k2: error_w_k * error_w_k })
        });
        let found = [None, Some(last)].map(|last_m_s| head.step(&mut WindState { last_m_s }, &gas, &measured));
        assert_eq!(found[0].wind_m_s, found[1].wind_m_s, "{last:?} {wind:?}");
        assert!(off(found[1].wind_m_s, wind) < 2e-2, "{last:?} {wind:?} {:?}", found[1]);
    }
}

#[test]
fn winds_round_a_cylinder_come_back_whatever_the_number_of_sectors() {
    let gas = carbon_dioxide(700.0);
    for count in 3..=8 {
        let head = cylinder(count);
        for n in 0..60 {
            let speed = [0.6, 2.0, 5.0, 12.0][n % 4];
            let wind = at_angle(0.37 + 1.618 * n as f64).map(|x| speed * x);
            let found = estimated(&head, &gas, wind, 0.0);
            assert!(!found.quality.has(QualityFlags::FAILED), "{count} {wind:?} {found:?}");
            assert!(off(found.wind_m_s, wind) < 2e-3 * speed, "{count} {wind:?} {found:?}");
            assert!((found.speed_m_s - speed).abs() < 2e-3 * speed, "{count} {wind:?} {found:?}");
            // The component along the axis is not known, and is said not to be.
            assert!(found.quality.has(QualityFlags::UNDETERMINED));
            assert!((found.covariance_m2_s2[2][2] - speed * speed).abs() < 0.01 * speed * speed);
            assert!(found.direction_error_rad < 0.02 && found.speed_error_m_s < 0.02 * speed, "{found:?}");
        }
    }
}

#[test]
fn the_gradient_is_the_difference_of_two_winds() {
    let gas = carbon_dioxide(700.0);
    for head in [cylinder(5), wires(&[0.2, 1.4, 2.2])] {
        let (wind, step) = ([1.7_f32, -1.1, 0.0], 0.01);
        let here = head.conductances(&gas, wind);
        for k in 0..2 {
            let moved = |by: f32| {
                let mut moved = wind;
                moved[k] += by;
                head.conductances(&gas, moved)
            };
            for ((here, up), down) in here.iter().zip(moved(step)).zip(moved(-step)) {
                let slope = (up.conductance_w_k - down.conductance_w_k) / (2.0 * step);
                assert!((here.gradient_w_s_k_m[k] - slope).abs() < 2e-3 * slope.abs() + 2e-8, "{here:?} {slope}");
            }
        }
    }
}

#[test]
fn wires_tell_the_wind_on_the_side_that_they_face() {
    let gas = carbon_dioxide(700.0);
    // They face +x: winds come from there, and go to -x.
    let three = wires(&[-PI / 3.0, 0.0, PI / 3.0]);
    let two = wires(&[-PI / 4.0, PI / 4.0]);
    for n in 0..40 {
        let speed = [0.8, 3.0, 9.0][n % 3];
        let angle = -1.2 + 2.4 * n as f64 / 39.0;
        let from = at_angle(angle);
        let wind = from.map(|x| -speed * x);
        let found = estimated(&three, &gas, wind, 0.0);
        assert!(off(found.wind_m_s, wind) < 5e-3 * speed, "{angle} {wind:?} {found:?}");
        // From behind it looks the same.
        let behind = estimated(&three, &gas, from.map(|x| speed * x), 0.0);
        assert!(off(behind.wind_m_s, wind) < 5e-3 * speed, "{angle} {wind:?} {behind:?}");
        if angle.abs() < 0.7 {
            let found = estimated(&two, &gas, wind, 0.0);
            assert!(off(found.wind_m_s, wind) < 1e-2 * speed, "{angle} {wind:?} {found:?}");
        }
    }
}

#[test]
fn wires_have_a_wind_where_they_see_it_mirrored_and_no_wind_fits() {
    let gas = carbon_dioxide(700.0);
    let head = wires(&[-PI / 4.0, PI / 4.0]);
    for n in 0..60 {
        let speed = [0.8, 3.0, 9.0][n % 3];
        // Along the second wire, within 3°; it is cooled less than by any wind: ten standard
        // errors.
        let wind = at_angle(-PI / 4.0 + 0.1 * (n as f64 / 59.0 - 0.5)).map(|x| -speed * x);
        let measured = core::array::from_fn::<_, 2, _>(|i| {
            let conductance_w_k = head.conductances(&gas, wind)[i].conductance_w_k * [1.0, 0.99][i];
            let error_w_k = SHARE as f32 * conductance_w_k;
            Some(MeasuredConductance { conductance_w_k, variance_w2_k2: error_w_k * error_w_k })
        });
        let found = head.step(&mut WindState::default(), &gas, &measured);
        assert!(!found.quality.has(QualityFlags::FAILED), "{n}: {found:?}");
        assert!((found.speed_m_s / speed - 1.0).abs() < 0.02, "{n}: {found:?}");
        assert!(off(found.wind_m_s, wind) < 0.1 * speed && found.direction_error_rad > 0.01, "{n}: {found:?}");
    }
}

#[test]
fn a_single_element_tells_a_speed_with_its_error_and_no_direction() {
    let gas = carbon_dioxide(700.0);
    let single = [surface(0.0, [0.0; 5])];
    let head = WindVector::new(HeadForm::Single, &king([0.0; 5]), &single, DIAMETER_M, 0.5).unwrap();
    for speed in [0.1_f32, 0.7, 2.0, 6.0, 20.0] {
        for direction in [[1.0, 0.0, 0.0], [-0.6, 0.0, 0.8]] {
            let found = estimated(&head, &gas, direction.map(|x: f32| speed * x), 0.0);
            assert!((found.speed_m_s / speed - 1.0).abs() < 2e-3, "{speed} {found:?}");
            assert_eq!(found.wind_m_s, [0.0; 3]);
            assert!(found.quality.has(QualityFlags::UNDETERMINED) && found.quality.has(QualityFlags::NO_DIRECTION));
            assert!(!found.quality.has(QualityFlags::FAILED));
            // Another reading by one standard error is another speed by one.
            let other = estimated(&head, &gas, direction.map(|x: f32| speed * x), SHARE);
            let moved = other.speed_m_s - found.speed_m_s;
            assert!((moved / found.speed_error_m_s - 1.0).abs() < 0.05, "{speed}: {moved} {}", found.speed_error_m_s);
        }
    }
    // Less than quiescent gas takes is next to no wind.
    let still = [Some(MeasuredConductance { conductance_w_k: 1e-6, variance_w2_k2: 1e-10 })];
    let found = head.step(&mut WindState::default(), &gas, &still);
    assert!(found.quality.has(QualityFlags::FAILED) || found.speed_m_s < 0.05, "{found:?}");
}

#[test]
fn errors_of_a_cylinder_have_the_size_that_it_states() {
    let gas = carbon_dioxide(700.0);
    let head = cylinder(3);
    let wind = [2.4_f32, -1.3, 0.0];
    let exact = head.conductances(&gas, wind);
    // A fixed sequence of about normal numbers.
    let mut seed = 1_u32;
    let mut noise = || {
        let uniform = (0..12).map(|_| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 8) / f64::from(1 << 24)
        });
        uniform.sum::<f64>() - 6.0
    };
    let (mut squares, mut stated) = ([0.0; 2], [0.0; 2]);
    let draws = 400;
    for _ in 0..draws {
        let measured = exact.map(|of| {
            let error = SHARE * f64::from(of.conductance_w_k);
            let conductance_w_k = (f64::from(of.conductance_w_k) + error * noise()) as f32;
            Some(MeasuredConductance { conductance_w_k, variance_w2_k2: (error * error) as f32 })
        });
        let found = head.step(&mut WindState::default(), &gas, &measured);
        for k in 0..2 {
            squares[k] += f64::from(found.wind_m_s[k] - wind[k]).powi(2) / f64::from(draws);
            stated[k] += f64::from(found.covariance_m2_s2[k][k]) / f64::from(draws);
        }
    }
    assert!((0..2).all(|k| (squares[k] / stated[k]).sqrt() > 0.85 && (squares[k] / stated[k]).sqrt() < 1.15));
}

#[test]
fn heads_that_cannot_tell_what_their_form_tells_are_refused_by_name() {
    let refused = |form, surfaces: &[SurfaceConfig]| {
        let nusselt = king([0.4, 0.0, 0.0, 0.0, 0.0]);
        WindVector::new(form, &nusselt, surfaces, DIAMETER_M, 0.5).unwrap_err().parameter
    };
    let wire = |angle| surface(angle, [1.0; 5]);
    assert_eq!(refused(HeadForm::Wires, &[wire(0.3)]), Parameter::Parts);
    assert_eq!(refused(HeadForm::Wires, &[wire(0.3), wire(0.31)]), Parameter::Axis);
    assert_eq!(refused(HeadForm::Single, &[wire(0.0), wire(1.0)]), Parameter::Parts);
    assert_eq!(refused(HeadForm::Cylinder, &[wire(0.0); MOST_SURFACES + 1]), Parameter::Parts);
    let flat = WindVector::new(HeadForm::Cylinder, &king([0.0; 5]), &sectors(3), DIAMETER_M, 0.5);
    assert_eq!(flat.unwrap_err().parameter, Parameter::NusseltFirst);
}
