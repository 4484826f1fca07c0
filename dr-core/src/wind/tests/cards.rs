//! Four dice on a card whose curves are known.

use crate::error::Parameter;
use crate::wind::card_inverse::{CONDUCTION, Card, CardConfig, DICE, KNOTS, TERMS};
use crate::wind::{GasState, MeasuredConductance, QualityFlags, SurfaceConfig, WindEstimate};

pub(crate) const SIDE_M: f32 = 1.5e-3;
pub(crate) const MOST_REYNOLDS: f32 = 240.0;

/// A layer that goes as √Re, of which the dice upstream have a tenth more; in reverse and across
/// less of the speed.
fn config() -> CardConfig {
    let root = |k: usize| k as f32 * MOST_REYNOLDS.sqrt() / (KNOTS - 1) as f32;
    let (mut along, mut around, mut seen) = ([0.0; TERMS], [0.0; TERMS], [0.0; TERMS]);
    (along[0], along[1], along[2]) = (-0.1, 0.8, -0.1);
    (around[0], around[2]) = (0.9, 0.05);
    (seen[0], seen[1], seen[2]) = (0.65, -0.35, 0.0);
    CardConfig {
        mean: core::array::from_fn(|k| CONDUCTION + root(k)),
        difference: core::array::from_fn(|k| 0.1 * root(k)),
        along,
        around,
        seen,
        mean_share: 0.01,
        difference_share: 0.005,
    }
}

/// On a card that looks up, with its tip at +x.
pub(crate) fn dice() -> [SurfaceConfig; DICE] {
    [[1.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [-1.0, 1.0]].map(|[x, y]| SurfaceConfig {
        axis: [0.0, 0.0, 1.0],
        corner: [x, y, 0.0],
        area_m2: SIDE_M * SIDE_M,
        means: [0.0; 5],
        threefold: [0.0; 3],
    })
}

fn card() -> Card {
    Card::new(&config(), &dice(), SIDE_M, MOST_REYNOLDS, 0.5).unwrap()
}

fn air() -> GasState {
    GasState::new(0.284, 18.1e-6, 25.7e-3).unwrap()
}

fn answered(wind_m_s: [f32; 3], noise: f32, left_out: Option<usize>) -> WindEstimate {
    let mut measured = card().conductances_w_k(&air(), wind_m_s).map(|conductance_w_k| {
        Some(MeasuredConductance { conductance_w_k, variance_w2_k2: (noise * conductance_w_k).powi(2) })
    });
    if let Some(die) = left_out {
        measured[die] = None;
    }
    card().step(&air(), &measured)
}

fn wind(speed_m_s: f32, degrees: f32) -> [f32; 3] {
    let (sine, cosine) = libm::sincosf(degrees.to_radians());
    [speed_m_s * cosine, speed_m_s * sine, 0.0]
}

#[test]
fn the_frame_is_that_of_the_places_of_the_dice() {
    let [tip, around] = card().basis();
    // Around the boom is its axis times the normal: away from +y.
    assert_eq!((tip, around), ([1.0, 0.0, 0.0], [0.0, -1.0, 0.0]));
}

#[test]
fn dice_upstream_lose_more() {
    let [first, second, third, fourth] = card().conductances_w_k(&air(), [-2.0, 0.0, 0.0]);
    assert!(first > 1.05 * fourth && second > 1.05 * third, "head-on the tip comes first");
    let [first, second, third, fourth] = card().conductances_w_k(&air(), [0.0, 2.0, 0.0]);
    assert!(second > 1.05 * first && third > 1.05 * fourth, "towards +y, dice 2 and 3 come first");
}

#[test]
fn winds_in_the_plane_come_back_as_they_were() {
    for speed_m_s in [0.3, 1.0, 3.0, 9.0] {
        for step in 0..72 {
            let truth = wind(speed_m_s, 5.0 * step as f32 + 1.3);
            let told = answered(truth, 1e-3, None);
            let off = (0..3).map(|k| (told.wind_m_s[k] - truth[k]).powi(2)).sum::<f32>().sqrt();
            // Roundings of conductances of which differences are a tenth.
            assert!(off < 2e-3 * speed_m_s, "{truth:?}: {told:?}");
            assert!(
                !told.quality.has(QualityFlags::FAILED)
                    && told.quality.has(QualityFlags::UNDETERMINED)
                    && !told.quality.has(QualityFlags::EXTRAPOLATED)
            );
            assert_eq!(told.degrees_of_freedom, 2);
        }
    }
}

#[test]
fn three_dice_still_answer_with_wider_errors_and_two_do_not() {
    let truth = wind(2.0, 217.0);
    let whole = answered(truth, 1e-2, None);
    let mut widest_rad = 0.0_f32;
    for die in 0..DICE {
        let told = answered(truth, 1e-2, Some(die));
        assert!(told.quality.has(QualityFlags::DEGRADED) && !told.quality.has(QualityFlags::FAILED), "{told:?}");
        assert!((told.speed_m_s / 2.0 - 1.0).abs() < 2e-3);
        assert!(told.direction_error_rad > whole.direction_error_rad, "{told:?} {whole:?}");
        widest_rad = widest_rad.max(told.direction_error_rad);
    }
    // The component across the diagonal of a missing die is known as before; along it the variance
    // is threefold.
    assert!(widest_rad > 1.4 * whole.direction_error_rad, "{widest_rad}");
    let mut measured = [None; DICE];
    measured[0] = Some(MeasuredConductance { conductance_w_k: 3e-4, variance_w2_k2: 1e-12 });
    measured[2] = measured[0];
    assert!(card().step(&air(), &measured).quality.has(QualityFlags::FAILED));
}

#[test]
fn errors_are_as_large_as_they_are_said_to_be() {
    // Curves that are known to the digit.
    let exact = CardConfig { mean_share: 0.0, difference_share: 0.0, ..config() };
    let card = Card::new(&exact, &dice(), SIDE_M, MOST_REYNOLDS, 0.8).unwrap();
    let noise_w_k = 3e-6;
    let mut seed = 1_u32;
    // A sum of twelve even numbers less six has a variance of one.
    let mut normal = || {
        (0..12)
            .map(|_| {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (seed >> 8) as f32 / (1 << 24) as f32
            })
            .sum::<f32>()
            - 6.0
    };
    let (mut speed, mut angle, mut count) = (0.0, 0.0, 0.0);
    for n in 0..2000 {
        let truth = wind(2.0, 0.18 * n as f32);
        let measured = card.conductances_w_k(&air(), truth).map(|conductance_w_k| {
            let conductance_w_k = conductance_w_k + noise_w_k * normal();
            Some(MeasuredConductance { conductance_w_k, variance_w2_k2: noise_w_k * noise_w_k })
        });
        let told = card.step(&air(), &measured);
        let off = (told.wind_m_s[0] * truth[1] - told.wind_m_s[1] * truth[0]) / (2.0 * told.speed_m_s);
        speed += ((told.speed_m_s - 2.0) / told.speed_error_m_s).powi(2);
        angle += (off / told.direction_error_rad).powi(2);
        count += 1.0;
    }
    let (speed, angle) = (f32::sqrt(speed / count), f32::sqrt(angle / count));
    // A standard deviation of 2000 is known to 2 %; the rest is what is not linear, where the angle
    // is known to 5° only.
    assert!((0.9..1.1).contains(&speed) && (0.9..1.1).contains(&angle), "{speed} {angle}");
}

#[test]
fn still_gas_has_a_speed_of_nearly_nothing_and_no_direction() {
    let told = answered([0.0; 3], 3e-3, None);
    assert!(!told.quality.has(QualityFlags::FAILED) && told.quality.has(QualityFlags::NO_DIRECTION), "{told:?}");
    assert!(told.speed_m_s < 1e-3 && told.speed_error_m_s > 0.0);
    let fast = answered(wind(30.0, 160.0), 1e-3, None);
    assert!(fast.quality.has(QualityFlags::EXTRAPOLATED) && !fast.quality.has(QualityFlags::FAILED));
}

#[test]
fn a_card_that_cannot_be_is_refused_by_name() {
    let refused = |change: &dyn Fn(&mut CardConfig, &mut [SurfaceConfig; DICE])| {
        let (mut config, mut dice) = (config(), dice());
        change(&mut config, &mut dice);
        Card::new(&config, &dice, SIDE_M, MOST_REYNOLDS, 0.5).unwrap_err().parameter
    };
    assert_eq!(refused(&|config, _| config.mean[5] = config.mean[4]), Parameter::CardMean);
    assert_eq!(refused(&|config, _| config.difference[11] = f32::NAN), Parameter::CardDifference);
    assert_eq!(refused(&|config, _| config.around[0] = -0.9), Parameter::CardAnisotropy);
    assert_eq!(refused(&|config, _| config.seen[0] = 0.2), Parameter::CardAnisotropy);
    assert_eq!(refused(&|config, _| config.mean_share = -0.1), Parameter::CardShare);
    assert_eq!(refused(&|_, dice| dice.swap(1, 2)), Parameter::Corner);
    assert_eq!(refused(&|_, dice| dice[2].corner = [0.0; 3]), Parameter::Corner);
}
