//! Findings of a calibration on the stream that a sphere meets: the rise of warmed gas, the wake of
//! a stem, and gas that was not quiescent.

use anemometry::calibrate::{
    ComparisonSummary, ConvectionOptions, DrawnSurfaces, Gravity, SoughtConvection, SteadyWind, calibrate, chosen,
    compare,
};
use anemometry::vector::{dot, length, unit};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use crate::tunnel::{Tunnel, directions, speeds};

const GRAVITY: Gravity = Gravity { m_s2: 3.71, up: [0.0, 0.0, 1.0] };
const OPTIONS: ConvectionOptions =
    ConvectionOptions { film_share: Some(0.0), gravity: GRAVITY, stem: [0.0, 0.0, -1.0] };
/// √(g ΔT d / T) of the tunnel: 30 K over 220 K.
const RISE_M_S: f64 = 0.071_12;

/// Readings in the winds that `stream` makes of known ones.
fn readings(count: usize, seed: u64, stream: &dyn Fn([f64; 3]) -> [f64; 3]) -> Vec<SteadyWind> {
    let tunnel = Tunnel::sectors();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut one = |label: String, wind_m_s: [f64; 3]| SteadyWind {
        wind_m_s,
        ..tunnel.reading(label, stream(wind_m_s), 1e-3, &mut random)
    };
    let mut all = vec![one("still".to_owned(), [0.0; 3])];
    for (n, speed) in speeds(0.3, 12.0, 10).into_iter().enumerate() {
        for (k, direction) in directions(count).enumerate() {
            all.push(one(format!("{n}, {k}"), direction.map(|x| x * speed)));
        }
    }
    all
}

/// Chosen convection, and the errors in other winds of the same kind.
fn judged(stream: &dyn Fn([f64; 3]) -> [f64; 3]) -> (DrawnSurfaces, ComparisonSummary) {
    let (plain, seen) = (Tunnel::sectors().head(), readings(24, 1, stream));
    let head = DrawnSurfaces { convection: chosen(&plain, &seen, &OPTIONS).unwrap(), ..plain };
    let calibration = calibrate(&head, &seen).unwrap();
    let unseen = readings(17, 2, stream);
    let errors: Vec<_> = unseen.iter().filter_map(|steady| compare(&calibration, steady).unwrap()).collect();
    (head, ComparisonSummary::of(errors.iter()))
}

#[test]
fn an_undisturbed_stream_is_taken_for_one() {
    let (head, errors) = judged(&|wind| wind);
    assert_eq!(head.convection, SoughtConvection::default());
    assert!(errors.direction_rms_deg < 0.35 && errors.speed_rms < 4e-3, "{errors:?}");
}

#[test]
fn the_rise_of_warmed_gas_is_found_whichever_way_it_joins_the_wind() {
    for (at_rest, decay) in [(0.61, 1.22), (1.0, 0.0), (0.4, 2.0)] {
        let stream = |[x, y, z]: [f64; 3]| {
            let rise = at_rest * RISE_M_S / (1.0 + decay * length([x, y, z]) / RISE_M_S);
            [x, y, z + rise]
        };
        let (head, errors) = judged(&stream);
        assert!(head.convection.rise.is_some() && !head.convection.is_without_quiescent, "{:?}", head.convection);
        assert!(errors.direction_rms_deg < 0.4 && errors.speed_rms < 5e-3, "{at_rest}, {decay}: {errors:?}");
    }
}

#[test]
fn a_wake_becomes_a_map_and_winds_from_within_it_are_right() {
    // Another shape than the map's: linear to 35°, slower by 15 %, 3° away half way.
    let stream = |wind: [f64; 3]| {
        let (from, speed) = (wind.map(|v| -v), length(wind));
        if speed == 0.0 {
            return wind;
        }
        let axis = [0.0, 0.0, -1.0];
        let (along, edge) = (dot(unit(from), axis).clamp(-1.0, 1.0), 35_f64.to_radians());
        let angle = libm::acos(along);
        if angle >= edge {
            return wind;
        }
        let near = 1.0 - angle / edge;
        let turned = angle + 3_f64.to_radians() * libm::sin(std::f64::consts::PI * angle / edge);
        let side: [f64; 3] = std::array::from_fn(|k| unit(from)[k] - along * axis[k]);
        let side = if length(side) > 0.0 { unit(side) } else { [0.0; 3] };
        let slow = speed * (1.0 - 0.15 * near);
        std::array::from_fn(|k| -slow * (libm::cos(turned) * axis[k] + libm::sin(turned) * side[k]))
    };
    let (head, errors) = judged(&stream);
    assert!(head.convection.stem.is_some(), "{:?}", head.convection);
    assert!(errors.direction_rms_deg < 0.6 && errors.speed_rms < 1e-2, "{errors:?}");
    let behind = |head: &DrawnSurfaces| {
        let calibration = calibrate(head, &readings(24, 1, &stream)).unwrap();
        let unseen = readings(40, 2, &stream);
        let near = unseen.iter().filter(|of| length(of.wind_m_s) > 0.0 && unit(of.wind_m_s)[2] > 0.85);
        let errors: Vec<_> = near.filter_map(|steady| compare(&calibration, steady).unwrap()).collect();
        ComparisonSummary::of(errors.iter())
    };
    let (mapped, blind) = (behind(&head), behind(&Tunnel::sectors().head()));
    assert!(mapped.direction_rms_deg < 0.7 && mapped.speed_rms < 0.03, "{mapped:?}");
    assert!(blind.speed_rms > 2.0 * mapped.speed_rms, "{blind:?} without a map, {mapped:?} with it");
}

#[test]
fn gas_that_was_not_quiescent_is_left_out() {
    let draught = |wind: [f64; 3]| if length(wind) == 0.0 { [0.2, 0.0, 0.0] } else { wind };
    let (head, errors) = judged(&draught);
    assert!(head.convection.is_without_quiescent, "{:?}", head.convection);
    assert!(errors.direction_rms_deg < 0.35 && errors.speed_rms < 4e-3, "{errors:?}");
}
