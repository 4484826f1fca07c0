//! Convection from the dice, cards and boom of a transducer of the REMS type, for any wind vector,
//! by correlations.
//!
//! ```text
//! die    G = 4/√π k a + h_plate(U_k, a) A (1 − r (e_along p + e_around q))
//!        square on a plane, and its laminar layer
//! card   G = A_k (h_still + (h_still⁴ + h_plate(U_k, l)⁴)^¼)     its inside, and its outside
//! boom   G = A (h_still⁴ + h_cylinder(Ū, d)⁴)^¼                  head, and each cell of the shank
//!
//! U_k² = (w_x s)² + (|w_across| (0.8 + 0.5 f_k))²           effective speed over card k
//! s    = ½ (1 + shade) + ½ (1 − shade) h                    1 head-on, `shade` in reverse
//! ```
//!
//! | symbol | meaning |
//! |---|---|
//! | h | cosine between the boom, towards its tip, and where the wind comes from: 1 head-on, −1 in reverse |
//! | f_k | cosine between the card's outward normal and where the part of the wind across the boom comes from |
//! | e, p, q | direction of the stream over the card, and the place of the die on it, ±1 towards the tip and ±1 around the boom |
//! | r | `front_to_rear`: upstream dice have the thinner layer and colder gas |
//! | Ū | mean of U_k over the cards |
//!
//! Head-on cools more than reverse because the stream then meets the tip first; in reverse it comes
//! from behind the boom's root and what carries it, and `shade` of its speed is left. Across the
//! boom the card in front sees 1.3, a side 0.8 and the rear 0.3 of the speed, as the local heat
//! transfer of a cylinder at Reynolds numbers of 10 to 100.
//!
//! *Sources.* h_plate: laminar layer of Pohlhausen, `plate_nusselt`. h_cylinder: Churchill and
//! Bernstein 1977. h_still: free convection of an upright plate and of a horizontal cylinder, both
//! Churchill and Chu 1975, at 5 K of overheat. Free and forced together: Churchill's blend with the
//! exponent 4 of a stream across. 4/√π k a: a square on a plane into a half-space, within 1 %. The
//! two cosine laws are the simplest that tell front, side and rear apart; their sizes are assumed
//! (`heads/rems.toml` has the reasons).
//!
//! *Limits.* Laminar up to a Reynolds number of 5·10⁵ on a card; beyond, `extrapolated` says so.
//! h_cylinder is correlated for Re·Pr > 0.2, which on the head of 10 mm in air of 240 mbar is 2
//! mm/s; below, free convection has taken over. h_still is taken at one overheat: at 1 K it is a
//! quarter less, at 20 K a third more. Plates and cylinders agree with measurements within some 20
//! %. No die warms the gas for the next beyond what r says.

use std::f64::consts::PI;

use super::flow::{
    continuum, cylinder_factor, cylinder_nusselt, free_cylinder_nusselt, free_plate_nusselt, joined, plate_nusselt,
    rayleigh,
};
use super::plate::LAMINAR_REYNOLDS;
use crate::sensor::error::SensorError;
use anemometry::gas::IdealGas;
pub use anemometry::head::body::BoomShape;
use anemometry::vector::{dot, length};

/// Cards around the boom.
pub const CARDS: usize = 3;
/// Dice on each of them.
pub const DICE_PER_CARD: usize = 4;
/// All dice.
pub const DICE: usize = CARDS * DICE_PER_CARD;

const GRAVITY_M_S2: f64 = 9.81;
/// Overheat at which free convection is taken.
const STILL_OVERHEAT_K: f64 = 5.0;
/// Share of the speed across the boom that a card at its side sees, and how much more or less it is
/// in front or at the rear.
const SIDE: f64 = 0.8;
const FACING: f64 = 0.5;

/// Places of the dice of a card, towards the tip and around the boom: neighbours follow each other,
/// 1 and 3, 2 and 4 are diagonal.
const PLACES: [[f64; 2]; DICE_PER_CARD] = [[1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]];

/// Convection of dice, cards and boom in one gas.
#[derive(Clone, Debug)]
pub struct Boom {
    shape: BoomShape,
    conductivity_w_m_k: f64,
    /// Reynolds number of a length of 1 m in 1 m/s.
    reynolds: f64,
    prandtl_third: f64,
    /// Factor of a cylinder's √Re.
    cylinder: f64,
    card_still_w_m2_k: f64,
    head_still_w_m2_k: f64,
    shank_still_w_m2_k: f64,
}

/// The stream over one card.
struct BoomStream {
    speed_m_s: f64,
    along: f64,
    around: f64,
}

impl Boom {
    /// Refuses a gas so thin that it is no continuum around a die.
    pub fn new(gas: &IdealGas, shape: &BoomShape) -> Result<Boom, SensorError> {
        continuum(gas, shape.die_side_m)?;
        Ok(Boom::of(gas, shape))
    }

    fn of(gas: &IdealGas, shape: &BoomShape) -> Boom {
        let prandtl = gas.prandtl();
        let rayleigh = |length_m: f64| rayleigh(gas, length_m, STILL_OVERHEAT_K, GRAVITY_M_S2);
        let plate = |length_m: f64| free_plate_nusselt(rayleigh(length_m), prandtl);
        let cylinder = |diameter_m: f64| free_cylinder_nusselt(rayleigh(diameter_m), prandtl);
        let k = gas.conductivity_w_m_k;
        Boom {
            shape: *shape,
            conductivity_w_m_k: k,
            reynolds: gas.reynolds(1.0, 1.0),
            prandtl_third: libm::cbrt(prandtl),
            cylinder: cylinder_factor(prandtl),
            card_still_w_m2_k: plate(shape.card_width_m) * k / shape.card_width_m,
            head_still_w_m2_k: cylinder(shape.head_diameter_m) * k / shape.head_diameter_m,
            shank_still_w_m2_k: cylinder(shape.shank_diameter_m) * k / shape.shank_diameter_m,
        }
    }

    /// The same in another gas.
    pub fn follow(&mut self, gas: &IdealGas) {
        *self = Boom::of(gas, &self.shape);
    }

    /// Radiating area of a surface, m²: only the outside of a card has one.
    pub fn area_m2(&self, surface: usize) -> f64 {
        if (DICE..DICE + CARDS).contains(&surface) { card_area_m2(&self.shape) } else { 0.0 }
    }

    /// Tells whether the flow over a card would no longer be laminar.
    pub fn extrapolated(&self, wind_m_s: [f64; 3]) -> bool {
        self.reynolds * self.shape.card_length_m * length(wind_m_s) > LAMINAR_REYNOLDS
    }

    /// Conductances to the gas, W/K: of all dice, of the cards, of the boom's head, of the cells of
    /// its shank.
    pub fn conductance_w_k(&self, wind_m_s: [f64; 3], conductance_w_k: &mut [f64]) {
        let (dice, rest) = conductance_w_k.split_at_mut(DICE);
        let (cards, boom) = rest.split_at_mut(CARDS);
        let (head, shank) = boom.split_at_mut(1);
        let BoomShape { die_side_m, card_length_m, front_to_rear, .. } = self.shape;
        let die_still_w_k = 4.0 / PI.sqrt() * self.conductivity_w_m_k * die_side_m;
        let mut mean_m_s = 0.0;
        for (i, card) in cards.iter_mut().enumerate() {
            let stream = self.over_card(wind_m_s, i);
            mean_m_s += stream.speed_m_s / CARDS as f64;
            let layer_w_k = self.plate_w_m2_k(stream.speed_m_s, die_side_m) * die_area_m2(&self.shape);
            for (die, [p, q]) in dice[DICE_PER_CARD * i..].iter_mut().zip(PLACES) {
                let upstream = 1.0 - front_to_rear * (stream.along * p + stream.around * q);
                *die = die_still_w_k + layer_w_k * upstream;
            }
            let outside = joined(self.card_still_w_m2_k, self.plate_w_m2_k(stream.speed_m_s, card_length_m));
            *card = card_area_m2(&self.shape) * (self.card_still_w_m2_k + outside);
        }
        let BoomShape { head_diameter_m, head_length_m, shank_diameter_m, shank_length_m, .. } = self.shape;
        let shank_cells = shank.len();
        let cylinder = |still_w_m2_k: f64, diameter_m: f64, length_m: f64| {
            PI * diameter_m * length_m * joined(still_w_m2_k, self.cylinder_w_m2_k(mean_m_s, diameter_m))
        };
        head[0] = cylinder(self.head_still_w_m2_k, head_diameter_m, head_length_m);
        shank.fill(cylinder(self.shank_still_w_m2_k, shank_diameter_m, shank_length_m / shank_cells as f64));
    }

    fn over_card(&self, wind_m_s: [f64; 3], card: usize) -> BoomStream {
        let [x, y, z] = wind_m_s;
        let speed_m_s = length(wind_m_s);
        if speed_m_s == 0.0 {
            return BoomStream { speed_m_s, along: 0.0, around: 0.0 };
        }
        let shade = self.shape.shade;
        let along_m_s = x * (0.5 * (1.0 + shade) - 0.5 * (1.0 - shade) * x / speed_m_s);
        let across_m_s = (y * y + z * z).sqrt();
        let normal = card_normal(card);
        let facing = if across_m_s > 0.0 { -dot(wind_m_s, normal) / across_m_s } else { 0.0 };
        let seen_m_s = across_m_s * (SIDE + FACING * facing);
        let effective_m_s = (along_m_s * along_m_s + seen_m_s * seen_m_s).sqrt();
        // Around the boom from +x seen against the clock: x × normal.
        let around_m_s = dot(wind_m_s, [0.0, -normal[2], normal[1]]);
        BoomStream {
            speed_m_s: effective_m_s,
            along: along_m_s / effective_m_s,
            // At the rear more of the wind goes round than is seen: a direction is one at most.
            around: around_m_s.signum() * (around_m_s.abs() / effective_m_s).min(1.0),
        }
    }

    fn plate_w_m2_k(&self, speed_m_s: f64, length_m: f64) -> f64 {
        let nusselt = plate_nusselt(self.reynolds * length_m * speed_m_s, self.prandtl_third);
        nusselt * self.conductivity_w_m_k / length_m
    }

    /// Conductance of forced convection alone: without wind it is nothing, and free convection has
    /// the rest.
    fn cylinder_w_m2_k(&self, speed_m_s: f64, diameter_m: f64) -> f64 {
        if speed_m_s == 0.0 {
            return 0.0;
        }
        let reynolds = self.reynolds * diameter_m * speed_m_s;
        cylinder_nusselt(reynolds, self.cylinder) * self.conductivity_w_m_k / diameter_m
    }
}

/// Area of one side of a card, m².
fn card_area_m2(shape: &BoomShape) -> f64 {
    shape.card_length_m * shape.card_width_m
}

/// Face and four sides, m².
fn die_area_m2(shape: &BoomShape) -> f64 {
    shape.die_side_m * (shape.die_side_m + 4.0 * shape.die_thickness_m)
}

/// Outward normal of card `i`: across the boom, which lies along x with its tip at +x; the first
/// looks up, the others 120° on.
fn card_normal(i: usize) -> [f64; 3] {
    let angle = PI * (0.5 + 2.0 * i as f64 / CARDS as f64);
    [0.0, libm::cos(angle), libm::sin(angle)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use anemometry::gas::Species;

    const SHAPE: BoomShape = BoomShape {
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
    };
    const HEAD: usize = DICE + CARDS;
    const SHANK_CELLS: usize = 3;

    fn air() -> IdealGas {
        IdealGas::new(Species::Air, 24_000.0, 294.15).unwrap()
    }

    fn conductance(wind: [f64; 3]) -> Vec<f64> {
        let mut all = vec![0.0; HEAD + 1 + SHANK_CELLS];
        Boom::new(&air(), &SHAPE).unwrap().conductance_w_k(wind, &mut all);
        all
    }

    #[test]
    fn still_gas_takes_what_conduction_and_free_convection_take() {
        let all = conductance([0.0; 3]);
        let k = air().conductivity_w_m_k;
        assert!(all[..DICE].iter().all(|g| (g / (k * 1.5e-3 * 2.2568) - 1.0).abs() < 1e-4));
        // By hand: ν 6.36e-5 m²/s, Pr 0.71; Ra of 22 mm at 5 K 311, Nu 0.68 + 0.670 · 4.20 / 1.304
        // = 2.84; both faces of 990 mm².
        let card = 2.0 * 990e-6 * 2.84 * k / 0.022;
        assert!((all[DICE] / card - 1.0).abs() < 0.01, "{} for {card}", all[DICE]);
        // Ra of 10 mm 29.2, Nu 0.36 + 0.518 · 2.325 / 1.327 = 1.27.
        let head = PI * 0.01 * 0.018 * 1.27 * k / 0.01;
        assert!((all[HEAD] / head - 1.0).abs() < 0.01, "{} for {head}", all[HEAD]);
    }

    #[test]
    fn head_on_the_dice_have_the_layer_of_a_plate_and_in_reverse_that_of_the_shaded_speed() {
        let gas = air();
        let still = conductance([0.0; 3])[0];
        for (wind, speed) in [([-2.0, 0.0, 0.0], 2.0), ([2.0, 0.0, 0.0], 0.6)] {
            let all = conductance(wind);
            let nusselt = 0.664 * gas.reynolds(speed, 1.5e-3).sqrt() * libm::cbrt(gas.prandtl());
            let layer = nusselt * gas.conductivity_w_m_k / 1.5e-3 * 3.75e-6;
            // The mean of front and rear.
            let mean = all[..DICE_PER_CARD].iter().sum::<f64>() / 4.0 - still;
            assert!((mean / layer - 1.0).abs() < 1e-9, "{wind:?}");
            assert!((0..DICE).all(|i| (all[i] / all[i % DICE_PER_CARD] - 1.0).abs() < 1e-12), "all cards alike");
        }
    }

    #[test]
    fn the_dice_that_meet_the_wind_first_are_cooled_most() {
        // Head-on: the tip, dice 1 and 2.
        let all = conductance([-0.5, 0.0, 0.0]);
        assert!((all[0] / all[1] - 1.0).abs() < 1e-12 && (all[2] / all[3] - 1.0).abs() < 1e-12);
        assert!(all[0] > 1.05 * all[3]);
        // Over card 1, which looks up, towards +y: around it that is the negative direction, so
        // dice 2 and 3 come first.
        let all = conductance([0.0, 0.5, 0.0]);
        assert!((all[1] / all[2] - 1.0).abs() < 1e-12 && all[1] > 1.05 * all[0]);
    }

    #[test]
    fn across_the_boom_the_card_in_front_is_cooled_most_and_the_two_others_alike() {
        let all = conductance([0.0, 0.0, -0.5]);
        assert!(all[DICE] > 1.1 * all[DICE + 1], "{all:?}");
        assert!((all[DICE + 1] / all[DICE + 2] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_third_of_a_turn_changes_nothing_but_the_numbers_of_the_cards() {
        let wind = |degrees: f64| {
            let angle = degrees.to_radians();
            [0.8, 3.0 * libm::cos(angle), 3.0 * libm::sin(angle)]
        };
        let (one, turned) = (conductance(wind(17.0)), conductance(wind(137.0)));
        for (i, die) in one[..DICE].iter().enumerate() {
            let next = (i + DICE_PER_CARD) % DICE;
            assert!((die / turned[next] - 1.0).abs() < 1e-12, "die {i}");
        }
    }

    #[test]
    fn the_boom_in_a_wind_agrees_with_churchill_and_bernstein() {
        // Re 100, Pr 0.71 by hand: 0.3 + 0.62 · 10 · 0.892 / 1.139 · 1.006 = 5.19.
        let gas = air();
        let speed = 100.0 / gas.reynolds(1.0, 0.01);
        let head = conductance([-speed, 0.0, 0.0])[HEAD];
        let nusselt = head / (PI * 0.018 * gas.conductivity_w_m_k);
        assert!((nusselt / 5.19 - 1.0).abs() < 0.01, "{nusselt}");
    }

    #[test]
    fn only_a_storm_at_high_pressure_is_beyond_the_laminar_layer() {
        let boom = Boom::new(&air(), &SHAPE).unwrap();
        assert!(!boom.extrapolated([100.0, 0.0, 0.0]));
        let speed = LAMINAR_REYNOLDS / air().reynolds(1.0, 45e-3);
        assert!(boom.extrapolated([0.0, 1.001 * speed, 0.0]));
    }
}
