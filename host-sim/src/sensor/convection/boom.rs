//! Forced convection from small dice on three cards around a boom, for any wind vector, by correlations.
//!
//! ```text
//! die, support of a die   G = k a (S + c(γ, τ) Re_a^½ Pr^⅓)           one face of a flat square of side a; S = 2.30
//!                         c = along + ½ (head − lee) cos γ + (½ (head + lee) − along) cos²γ + upwind τ
//! cell of the boom        G = k π l (Nu₀ + 0.62 Re_n^½ Pr^⅓ / (1 + (0.4/Pr)^⅔)^¼ · (1 + (Re_n / 282 000)^⅝)^⅘)
//! ```
//!
//! | symbol | meaning |
//! |---|---|
//! | γ | angle between the card's outward normal and where the wind comes from: c is `head_on` at 0°, `along` at 90°, `lee` at 180° |
//! | τ | component of that direction along the line from the card's centre to the die: more for the die that meets the wind first |
//! | S a | conduction from one face of a square into still gas, half the exact 4.61 a of a free square plate |
//! | Re_a | with the side a of the square |
//! | Re_n, l | with the boom's diameter and U_n² = U_across² + 0.04 U_along²; length of a cell |
//! | Nu₀ | of the boom in still gas; a cylinder of finite length, not the 0.3 of an endless one |
//!
//! *Sources.* Laminar boundary layer on a plate, 0.664 Re^½ Pr^⅓ (Pohlhausen); the sum with the conduction limit after Yovanovich;
//! the cylinder after Churchill and Bernstein 1977; 0.04 is the usual yaw factor of cylinders. The quadratic in cos γ and the linear
//! term in τ are the simplest that tell front, side and back apart, and the dice of a card from each other. Their coefficients are
//! parameters with reasons in [`rems`](super::super::rems): no measurement of such a card is published, so head-on more than along
//! more than lee is known, and by how much is assumed.
//!
//! *Limits.* Laminar up to a Reynolds number of 5·10⁵ on a card; beyond, `extrapolated` says so. Below Re·Pr = 0.2 of the boom its
//! correlation is only the sum's interpolation to still gas. Plate and cylinder agree with measurements within some 20 %. Neighbours
//! do not warm the gas for each other, the boom does not shield its cards more than c says, and there is no free convection.

use std::f64::consts::PI;

use super::super::SensorError;
use super::super::gas::Gas;
use super::{continuum, dot};

pub const CARDS: usize = 3;
pub const DICE_PER_CARD: usize = 4;
pub const DICE: usize = CARDS * DICE_PER_CARD;

/// Of one face of an isothermal square in still gas: half of 4π · 0.367.
pub const SQUARE_FACE: f64 = 2.30;
/// End of the laminar boundary layer.
pub const HIGHEST_REYNOLDS: f64 = 5e5;
/// Share of the square of the wind along a cylinder that cools it.
const ALONG_CYLINDER: f64 = 0.04;

/// Where the dice of a card lie: along the card's tangent and along the boom's axis. Neighbours follow each other; 1 and 3, 2 and 4
/// are diagonal.
const CORNERS: [[f64; 2]; DICE_PER_CARD] = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];

/// What the wind sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    pub die_side_m: f64,
    /// Of the square that carries a die; a card has four.
    pub support_side_m: f64,
    pub boom_diameter_m: f64,
    pub boom_length_m: f64,
    pub boom_cells: usize,
    pub boom_still_nusselt: f64,
    pub head_on: f64,
    pub along: f64,
    pub lee: f64,
    pub upwind: f64,
}

/// A card's outward normal, and the direction from its centre to every die.
#[derive(Clone, Copy, Debug)]
struct Card {
    normal: [f64; 3],
    dice: [[f64; 3]; DICE_PER_CARD],
}

/// Convection of boom, cards and dice in one gas. Immutable; made once.
#[derive(Clone, Debug)]
pub struct Boom {
    shape: Shape,
    conductivity_w_m_k: f64,
    cards: [Card; CARDS],
    /// Of a length of 1 m in 1 m/s.
    reynolds: f64,
    prandtl_third: f64,
    /// 0.62 Pr^⅓ / (1 + (0.4/Pr)^⅔)^¼.
    cylinder: f64,
    /// Exposed share of a die's support.
    bare: f64,
}

impl Boom {
    /// Refuses a gas so thin that it is no continuum around a die.
    pub fn new(gas: &Gas, shape: &Shape) -> Result<Boom, SensorError> {
        continuum(gas, shape.die_side_m)?;
        let prandtl = gas.prandtl();
        Ok(Boom {
            shape: *shape,
            conductivity_w_m_k: gas.conductivity_w_m_k,
            cards: std::array::from_fn(card),
            reynolds: gas.reynolds(1.0, 1.0),
            prandtl_third: prandtl.cbrt(),
            cylinder: 0.62 * prandtl.cbrt() / (1.0 + (0.4 / prandtl).powf(2.0 / 3.0)).powf(0.25),
            bare: 1.0 - (shape.die_side_m / shape.support_side_m).powi(2),
        })
    }

    /// Whether the flow over a card would no longer be laminar.
    pub fn extrapolated(&self, wind_m_s: [f64; 3]) -> bool {
        let card_m = 2.0 * self.shape.support_side_m;
        self.reynolds * card_m * dot(wind_m_s, wind_m_s).sqrt() > HIGHEST_REYNOLDS
    }

    /// Conductances to the gas, W/K: of all dice, of the supports of the dice, of the cells of the boom.
    pub fn conductance_w_k(&self, wind_m_s: [f64; 3], conductance_w_k: &mut [f64]) {
        let (dice, rest) = conductance_w_k.split_at_mut(DICE);
        let (supports, boom) = rest.split_at_mut(DICE);
        let speed_m_s = dot(wind_m_s, wind_m_s).sqrt();
        let from = if speed_m_s > 0.0 { wind_m_s.map(|v| -v / speed_m_s) } else { [0.0; 3] };
        for (i, card) in self.cards.iter().enumerate() {
            let facing = self.facing(dot(from, card.normal));
            for (j, die) in card.dice.iter().enumerate() {
                let c = facing + self.shape.upwind * dot(from, *die);
                let k = DICE_PER_CARD * i + j;
                dice[k] = self.square_w_k(self.shape.die_side_m, c, speed_m_s);
                supports[k] = self.bare * self.square_w_k(self.shape.support_side_m, c, speed_m_s);
            }
        }
        boom.fill(self.cell_w_k(wind_m_s));
    }

    fn facing(&self, cosine: f64) -> f64 {
        let Shape { head_on, along, lee, .. } = self.shape;
        along + 0.5 * (head_on - lee) * cosine + (0.5 * (head_on + lee) - along) * cosine * cosine
    }

    fn square_w_k(&self, side_m: f64, c: f64, speed_m_s: f64) -> f64 {
        let layer = c * (self.reynolds * side_m * speed_m_s).sqrt() * self.prandtl_third;
        self.conductivity_w_m_k * side_m * (SQUARE_FACE + layer)
    }

    fn cell_w_k(&self, [x, y, z]: [f64; 3]) -> f64 {
        let Shape { boom_diameter_m, boom_length_m, boom_cells, boom_still_nusselt, .. } = self.shape;
        let across_m_s = (x * x + y * y + ALONG_CYLINDER * z * z).sqrt();
        let reynolds = self.reynolds * boom_diameter_m * across_m_s;
        let turbulent = (1.0 + (reynolds / 282_000.0).powf(0.625)).powf(0.8);
        let nusselt = boom_still_nusselt + self.cylinder * reynolds.sqrt() * turbulent;
        self.conductivity_w_m_k * PI * boom_length_m / boom_cells as f64 * nusselt
    }
}

/// Outward normal of card `i`: across the boom, which comes up along z, the first towards +x and the others 120° on.
pub fn card_normal(i: usize) -> [f64; 3] {
    let azimuth = 2.0 * PI * i as f64 / CARDS as f64;
    [azimuth.cos(), azimuth.sin(), 0.0]
}

fn card(i: usize) -> Card {
    let normal = card_normal(i);
    let tangent = [-normal[1], normal[0], 0.0];
    let corner = |[t, z]: [f64; 2]| [t * tangent[0], t * tangent[1], z].map(|v| v / 2.0_f64.sqrt());
    Card { normal, dice: CORNERS.map(corner) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::gas::Species;

    const SHAPE: Shape = Shape {
        die_side_m: 1.5e-3,
        support_side_m: 3e-3,
        boom_diameter_m: 0.01,
        boom_length_m: 0.1,
        boom_cells: 4,
        boom_still_nusselt: 0.7,
        head_on: 0.8,
        along: 0.664,
        lee: 0.35,
        upwind: 0.15,
    };

    fn air() -> Gas {
        Gas::new(Species::Air, 24_000.0, 294.15).unwrap()
    }

    fn conductance(shape: Shape, wind: [f64; 3]) -> Vec<f64> {
        let mut all = vec![0.0; 2 * DICE + shape.boom_cells];
        Boom::new(&air(), &shape).unwrap().conductance_w_k(wind, &mut all);
        all
    }

    #[test]
    fn still_gas_takes_what_conduction_takes() {
        let all = conductance(SHAPE, [0.0; 3]);
        let k = air().conductivity_w_m_k;
        assert!(all[..DICE].iter().all(|g| (g / (k * 1.5e-3 * 2.30) - 1.0).abs() < 1e-12));
        // A quarter of the support is under its die.
        assert!(all[DICE..2 * DICE].iter().all(|g| (g / (0.75 * k * 3e-3 * 2.30) - 1.0).abs() < 1e-12));
        let boom: f64 = all[2 * DICE..].iter().sum();
        assert!((boom / (k * PI * 0.1 * 0.7) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_plate_in_a_parallel_stream_has_the_laminar_nusselt_number() {
        // Card 1 looks along x, the wind goes along y; without the order of the dice all four are alike.
        let all = conductance(Shape { upwind: 0.0, ..SHAPE }, [0.0, 2.0, 0.0]);
        let gas = air();
        let laminar = 0.664 * gas.reynolds(2.0, 1.5e-3).sqrt() * gas.prandtl().cbrt();
        for die in &all[..DICE_PER_CARD] {
            assert!((die / (gas.conductivity_w_m_k * 1.5e-3) - 2.30 - laminar).abs() < 1e-9);
        }
    }

    #[test]
    fn the_boom_agrees_with_churchill_and_bernstein() {
        // Air of Pr 0.7 at Re 1000: an endless cylinder has Nu 16.5 (their fig. 1 and the formula worked by hand).
        let gas = air();
        let speed = 1000.0 / gas.reynolds(1.0, 0.01);
        let all = conductance(Shape { boom_still_nusselt: 0.3, ..SHAPE }, [0.0, -speed, 0.0]);
        let nusselt = all[2 * DICE..].iter().sum::<f64>() / (gas.conductivity_w_m_k * PI * 0.1);
        assert!((nusselt / 16.0 - 1.0).abs() < 0.05, "{nusselt}");
        // A wind along the boom cools it like a fifth of itself across.
        let along = conductance(SHAPE, [0.0, 0.0, 5.0]);
        let across = conductance(SHAPE, [1.0, 0.0, 0.0]);
        assert!((along[2 * DICE] / across[2 * DICE] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn head_on_cools_more_than_along_and_that_more_than_lee() {
        let card = |wind| conductance(SHAPE, wind)[..DICE_PER_CARD].iter().sum::<f64>();
        let (head, along, lee) = (card([-0.125, 0.0, 0.0]), card([0.0, 0.125, 0.0]), card([0.125, 0.0, 0.0]));
        assert!(head > 1.02 * along && along > 1.02 * lee, "{head} {along} {lee}");
    }

    #[test]
    fn a_third_of_a_turn_changes_nothing_but_the_numbers_of_the_cards() {
        let wind = |degrees: f64| {
            let azimuth = degrees.to_radians();
            [3.0 * azimuth.cos(), 3.0 * azimuth.sin(), 0.8]
        };
        let (one, turned) = (conductance(SHAPE, wind(17.0)), conductance(SHAPE, wind(137.0)));
        for i in 0..DICE {
            let next = (i + DICE_PER_CARD) % DICE;
            assert!((one[i] / turned[next] - 1.0).abs() < 1e-12, "die {i}");
        }
    }

    #[test]
    fn the_die_that_meets_the_wind_first_is_cooled_most() {
        // Towards −y over card 1: its tangent is +y, so dice 1 and 4 come first.
        let all = conductance(SHAPE, [0.0, -1.0, 0.0]);
        assert!((all[0] / all[3] - 1.0).abs() < 1e-12 && (all[1] / all[2] - 1.0).abs() < 1e-12);
        assert!(all[0] > 1.05 * all[1]);
    }

    #[test]
    fn only_a_storm_at_high_pressure_is_beyond_the_laminar_layer() {
        let boom = Boom::new(&air(), &SHAPE).unwrap();
        assert!(!boom.extrapolated([100.0, 0.0, 0.0]));
        let speed = HIGHEST_REYNOLDS / air().reynolds(1.0, 6e-3);
        assert!(boom.extrapolated([0.0, 1.001 * speed, 0.0]));
    }
}
