//! Cards that lose heat as the simulated transducer's do.

use anemometry::calibrate::card::{calibrate, cross_validate};
use anemometry::calibrate::{CalibrateError, DrawnCard, SteadyWind, SurfaceReading};
use anemometry::gas::{IdealGas, Species};
use dr_core::wind::card_inverse::DICE;
use host_sim::sensor::convection::boom::{Boom, BoomShape};

const OVERHEAT_K: f64 = 21.0;

fn air() -> IdealGas {
    IdealGas::new(Species::Air, 24_000.0, 294.15).unwrap()
}

fn shape() -> BoomShape {
    BoomShape {
        die_side_m: 1.5e-3,
        die_thickness_m: 0.25e-3,
        card_length_m: 45e-3,
        card_width_m: 22e-3,
        head_diameter_m: 0.01,
        head_length_m: 0.018,
        shank_diameter_m: 0.01,
        shank_length_m: 0.1,
        shade: 0.3,
        front_to_rear: 0.1,
    }
}

fn drawn() -> DrawnCard {
    DrawnCard { side_m: 1.5e-3, normal: [0.0, 0.0, 1.0], tip: [1.0, 0.0, 0.0] }
}

/// A wind that a card's dice are read in, each off by its own gain, and by a share of noise that
/// depends on `n`.
fn reading(speed_m_s: f64, degrees: f64, gains: [f64; DICE], noise: f64, n: usize) -> SteadyWind {
    let (gas, angle) = (air(), degrees.to_radians());
    let wind_m_s = [speed_m_s * libm::cos(angle), speed_m_s * libm::sin(angle), 0.0];
    let mut conductance_w_k = vec![0.0; 12 + 3 + 1 + 3];
    Boom::new(&gas, &shape()).unwrap().conductance_w_k(wind_m_s, &mut conductance_w_k);
    let quiescent_w_k = drawn().quiescent_w_k(gas.conductivity_w_m_k);
    let surfaces = (0..DICE).map(|i| {
        // An irrational step, as good as chance here.
        let off = 1.0 + noise * (2.0 * ((n * DICE + i) as f64 * 0.754_877_666).fract() - 1.0) * 3f64.sqrt();
        SurfaceReading {
            power_w: (conductance_w_k[i] / gains[i] * off - quiescent_w_k) * OVERHEAT_K,
            overheat_k: OVERHEAT_K,
            above_reference_k: OVERHEAT_K,
            variance_w2: (conductance_w_k[i] * noise.max(1e-4) * OVERHEAT_K).powi(2),
        }
    });
    SteadyWind { label: format!("wind {n}"), wind_m_s, gas, surfaces: surfaces.collect() }
}

/// Winds in all directions and of 0.5 to 10 m/s.
fn tunnel(count: usize, gains: [f64; DICE], noise: f64) -> Vec<SteadyWind> {
    (0..count)
        .map(|n| {
            let share = |by: f64| ((n + 1) as f64 * by).fract();
            let speed_m_s = 0.5 * libm::pow(20.0, share(0.618_033_989));
            reading(speed_m_s, 360.0 * share(0.414_213_562), gains, noise, n)
        })
        .collect()
}

#[test]
fn winds_that_were_left_out_are_estimated_within_degrees() {
    let steady = tunnel(120, [1.0; DICE], 1e-3);
    let calibration = calibrate(&drawn(), &steady).unwrap();
    println!("{calibration}");
    // Same as the simulation: a laminar layer, the shade in reverse and the side of the boom.
    assert!((calibration.exponent - 0.5).abs() < 0.02, "{}", calibration.exponent);
    assert!((calibration.seen_at(0.0) - 0.3).abs() < 0.05, "{}", calibration.seen_at(0.0));
    let across = calibration.seen_at(std::f64::consts::FRAC_PI_2);
    assert!((across - 0.8).abs() < 0.05, "{across}");
    let told = cross_validate(&drawn(), &steady, 10).unwrap();
    println!("{told}");
    let all = told.overall();
    assert_eq!((all.winds, told.failed.len()), (120, 0));
    // Noise of 0.1 % of conductances of which differences are a tenth: 0.5 %, so 0.3°; the rest are
    // the corners in how a simulated card sees winds from the side, which eight harmonics round
    // off.
    assert!(all.direction_rms_deg < 3.0 && all.speed_rms < 0.03, "{all:?}");
}

#[test]
fn dice_that_are_not_alike_are_estimated_from_the_wind() {
    let gains = [1.02, 0.99, 1.0, 0.99];
    let calibration = calibrate(&drawn(), &tunnel(120, gains, 1e-4)).unwrap();
    for (found, gain) in calibration.gains.iter().zip(gains) {
        assert!((found / gain - 1.0).abs() < 5e-3, "{:?}", calibration.gains);
    }
    let wind = reading(3.0, 200.0, gains, 0.0, 7);
    let error = calibration.compare(&wind).unwrap().unwrap();
    assert!(error.direction_deg.unwrap() < 4.0 && error.speed.abs() < 0.04, "{error:?}");
}

#[test]
fn winds_that_do_not_determine_a_card_are_refused_with_what_is_missing() {
    let spread = |steady: &[SteadyWind]| match calibrate(&drawn(), steady).unwrap_err() {
        CalibrateError::Spread(lacking) => lacking.join("\n"),
        other => other.to_string(),
    };
    let all = tunnel(120, [1.0; DICE], 1e-3);
    assert!(spread(&all[..20]).contains("20 winds given, at least 40 are needed"));
    let half: Vec<SteadyWind> = all.iter().filter(|of| of.wind_m_s[1] < 0.0).cloned().collect();
    // Around the boom is −y.
    assert!(spread(&half).contains("no wind goes towards 180 to 210°"), "{}", spread(&half));
    let slow: Vec<SteadyWind> =
        (0..60).map(|n| reading(1.0 + 0.01 * n as f64, 6.0 * n as f64, [1.0; DICE], 1e-3, n)).collect();
    assert!(spread(&slow).contains("times as fast as the slowest"));
    let mut upwards = all.clone();
    upwards[3].wind_m_s[2] = 1.0;
    let sentence = spread(&upwards);
    assert!(sentence.contains("wind 3") && sentence.contains("blow across the card"), "{sentence}");
}
