//! Tests of the REMS network against hand calculation and published behaviour.

use super::built_in;
use crate::sensor::body::ThermalBody;
use crate::sensor::body::testing::imbalance;
use crate::sensor::convection::boom::{DICE, DICE_PER_CARD};
use anemometry::gas::{IdealGas, Species};

const GAS_C: f64 = 21.0;
const BOOM: usize = DICE;

fn air() -> IdealGas {
    IdealGas::new(Species::Air, 24_000.0, GAS_C + 273.15).unwrap()
}

fn body() -> ThermalBody {
    built_in("rems", &[]).body(&air(), GAS_C + 273.15, 0).unwrap()
}

/// Rises above the gas in the steady state of a wind.
fn rises_k(wind_m_s: [f64; 3], power_w: impl Fn(usize) -> f64) -> Vec<f64> {
    let mut body = body();
    body.set_wind(wind_m_s);
    body.settle(|i, _| power_w(i));
    (0..=BOOM).map(|i| body.element_temperature_c(i) - GAS_C).collect()
}

#[test]
fn heat_in_is_heat_out_and_heat_stored() {
    let wind = |phase: f64| [0.5 * libm::cos(phase), 0.5 * libm::sin(phase), 0.1];
    let power_w = |i, high| if high { 0.02 } else { 0.001 * i as f64 };
    let weather = |body: &mut ThermalBody, phase| body.set_wind(wind(phase));
    let imbalance = imbalance(&mut body(), (100_000, 0.025), weather, power_w);
    // 12 J/K at 294 K are 3.4 kJ of stored heat: rounding counts in those.
    assert!(imbalance.abs() < 1e-9, "{imbalance}");
}

#[test]
fn twelve_dice_alike_warm_as_a_chain_of_resistances_says() {
    // All alike: no heat between neighbours. Die, leg, card and head from the boundary inwards, the
    // head's rise from the run.
    let construction = built_in("rems", &[("emissivity = 0.9", "emissivity = 0.0")]);
    let mut body = construction.body(&air(), GAS_C + 273.15, 0).unwrap();
    body.set_wind([0.0; 3]);
    body.settle(|i, _| if i < DICE { 0.005 } else { 0.0 });
    let conductance = body.conductance_w_k().to_vec();
    let head = body.element_temperature_c(BOOM) - GAS_C;
    let to_card = 1.0 / (1.0 / 4.7e-3 + 1.0 / 1.63e-3);
    let (die_gas, card_gas, post) = (conductance[0], conductance[DICE], 6.7e-4);
    // 5 mW = die_gas D + to_card (D − K) and 4 to_card (D − K) = card_gas K + post (K − head), D
    // the die's rise, K the card's.
    let determinant = (die_gas + to_card) * (4.0 * to_card + card_gas + post) - 4.0 * to_card * to_card;
    let die = (0.005 * (4.0 * to_card + card_gas + post) + to_card * post * head) / determinant;
    for i in 0..DICE {
        let rise = body.element_temperature_c(i) - GAS_C;
        assert!((rise / die - 1.0).abs() < 1e-9, "die {i}: {rise} for {die}");
    }
}

#[test]
fn dice_alike_are_alike_neighbours_too_and_the_diagonal_one_is_warmed_much_less() {
    let heated = |die: usize| rises_k([0.0; 3], |i| if i == die { 0.01 } else { 0.0 });
    let first = heated(0);
    for die in 1..DICE {
        assert!((heated(die)[die] / first[0] - 1.0).abs() < 1e-9, "die {die}");
    }
    assert!((first[1] / first[3] - 1.0).abs() < 1e-9, "neighbours");
    // Beyond what the whole card has, which all four share.
    let mut body = body();
    body.set_wind([0.0; 3]);
    body.settle(|i, _| if i == 0 { 0.01 } else { 0.0 });
    let card = body.surface_temperature_c(DICE) - GAS_C;
    assert!(first[2] - card < 0.4 * (first[1] - card) && first[2] > card, "{first:?} {card}");
    // Other cards get heat through the boom only.
    assert!(first[4..DICE].iter().all(|rise| *rise < first[BOOM] && *rise > 0.0), "{first:?}");
}

#[test]
fn heat_goes_both_ways_alike() {
    // Reciprocity of a linear network; radiation bends it by some 1e-4.
    let by_die = rises_k([0.3, 0.1, 0.0], |i| if i == 2 { 0.01 } else { 0.0 });
    let by_boom = rises_k([0.3, 0.1, 0.0], |i| if i == BOOM { 0.01 } else { 0.0 });
    assert!((by_die[BOOM] / by_boom[2] - 1.0).abs() < 5e-3, "{} {}", by_die[BOOM], by_boom[2]);
}

#[test]
fn head_on_cools_more_than_reverse_and_reverse_more_than_still_gas() {
    // ±7.5 m/min; of 6 K at 10 mW.
    let rise = |x| rises_k([x, 0.0, 0.0], |i| if i == 0 { 0.01 } else { 0.0 })[0];
    let (head, reverse, still) = (rise(-0.125), rise(0.125), rise(0.0));
    assert!(head < reverse - 0.05 && reverse < still - 0.05, "{head} {reverse} {still}");
}

#[test]
fn four_dice_at_17_k_warm_the_boom_as_published() {
    let card = |power: f64| rises_k([0.0; 3], |i| if i < DICE_PER_CARD { power } else { 0.0 });
    let per_watt = card(1e-3)[0] / 1e-3;
    let rises = card(17.0 / per_watt);
    assert!((rises[0] - 17.0).abs() < 0.3, "{}", rises[0]);
    // Published: 0.6 to 0.7 K; the construction was calibrated to it.
    assert!((0.55..0.75).contains(&rises[BOOM]), "{}", rises[BOOM]);
}

#[test]
fn a_warm_support_warms_the_head_by_the_shank() {
    let mut body = built_in("rems", &[]).body(&air(), GAS_C + 10.0 + 273.15, 0).unwrap();
    body.set_wind([0.0; 3]);
    body.settle(|_, _| 0.0);
    let rise = body.element_temperature_c(BOOM) - GAS_C;
    // 0.2 mW/K and its own loss of a few mW/K on the way leave little of 10 K.
    assert!((1e-3..0.5).contains(&rise), "{rise}");
    assert!(body.flows().support_w < 0.0, "heat comes in");
}

#[test]
fn agrees_with_the_network_worked_out_by_another_program() {
    // The same network as a conductance matrix in numpy, inverted: rise in K/W of card 1's dice 1,
    // 2 and 3, of card 2's die 1 and of the boom, with heat in card 1's die 1; of card 2's die 2
    // with heat in itself; of the boom with heat in itself.
    for (wind_m_s, expected) in [
        ([0.0; 3], [681.440, 137.558, 89.997, 0.5173, 10.5218, 681.440, 214.014]),
        ([-0.125, 0.0, 0.0], [644.507, 121.198, 77.749, 0.2946, 6.6946, 644.507, 152.124]),
        ([0.125, 0.0, 0.0], [664.897, 130.460, 84.158, 0.4239, 8.9672, 664.897, 189.707]),
        ([0.2, 0.3, -0.1], [629.906, 110.703, 67.722, 0.1793, 4.8045, 624.087, 123.576]),
    ] {
        // So little heat that radiation is linear, as it is there.
        let heated = |element: usize| rises_k(wind_m_s, |i| if i == element { 1e-5 } else { 0.0 });
        let (first, other, boom) = (heated(0), heated(5), heated(BOOM));
        let found = [first[0], first[1], first[2], first[4], first[BOOM], other[5], boom[BOOM]].map(|rise| rise / 1e-5);
        for (found, expected) in found.iter().zip(expected) {
            // It has 1005 J/(kg·K) for the heat capacity of air, where ours is computed; and the
            // digits printed here.
            assert!((found / expected - 1.0).abs() < 6e-4, "{wind_m_s:?}: {found} for {expected}");
        }
    }
}
