//! A transducer of the REMS type as a thermal network: three cards at 120° on a boom, four silicon
//! dice a card.
//!
//! ```text
//!   gas ── die ── leg ── card ── head of the boom ── shank, 3 cells ── support at a fixed
//!           │      │       │           │                 │             temperature
//!        the next die     gas      gas, resistor        gas
//!        and leg of the card, a ring of four
//! ```
//!
//! | part | value | origin |
//! |---|---|---|
//! | 3 cards at 120°, 4 dice a card, one platinum resistor a die | | published |
//! | die | 1.5 mm, 0.25 mm thick, 0.93 mJ/K | derived: silicon, 2330 kg/m³, 710 J/(kg·K); thickness assumed |
//! | legs | 0.32 mJ/K | derived: four of Pyrex, 0.4 × 0.4 × 0.3 mm, 2230 kg/m³, 750 J/(kg·K) |
//! | die to leg | 4.7 mW/K | derived: the upper half of the legs, 0.64 mm² · 1.1 W/(m·K) / 0.15 mm |
//! | leg to card | 1.63 mW/K | calibrated to the published pole of a die; its lower half in series with the spreading in the board |
//! | leg to the next leg | 0.37 mW/K | calibrated to the published ratio of diagonal and adjacent die: board and tracks |
//! | die to the next die | 14 µW/K | derived: gas between two sides, 0.7 mm apart |
//! | card | 45 × 22 mm, 1.1 J/K | derived: FR4 of 0.6 mm, 1850 kg/m³, 1000 J/(kg·K); size assumed |
//! | card to head | 0.67 mW/K | calibrated to the published rise of the boom: posts and wires |
//! | head | 10 × 18 mm, 3.6 J/K | calibrated to the published pole near 2·10⁻⁴ Hz: solid aluminium, with its Pt100 and screws |
//! | shank | 10 × 100 mm, 0.2 mW/K, 4.8 J/K | derived: glass-fibre tube of 28 mm², 0.4 W/(m·K), 1.7 J/(cm³·K), and 27 manganin wires |
//! | emissivity of a card, outside | 0.9 | assumed: bare FR4; head and shank are gold-plated, the inside faces them, and a die is 2 mm²: none of these radiates here |
//! | shade | 0.3 | assumed: share of the speed that is left in reverse; published is that head-on cools more |
//! | front to rear | 0.10 | assumed: upstream dice 10 % more of the layer, downstream ones 10 % less |
//!
//! Elements: `card1-die1` … `card3-die4`, `boom` (a Pt100 in the head). Surfaces: the dice, the
//! cards, the head, the cells of the shank. The boom lies along x with its tip at +x, cards 1, 2
//! and 3 look towards 90° (up), 210° and 330° around it. The azimuth of a wind is yaw and its
//! elevation pitch; head-on is a wind that goes towards azimuth 180°. Dice 1 and 2 of a card are
//! the pair at the tip, 3 and 4 that at the root; 1 and 4 lie on the same side.
//!
//! Limits: those of the [convection](super::convection::boom), free convection at one overheat
//! among them; cards warm each other only through the head; no temperature dependence of the parts.

use super::body::{Surface, ThermalBody};
use super::convection::BodyConvection;
use super::convection::boom::{Boom, BoomShape, CARDS, DICE, DICE_PER_CARD, card_normal};
use super::element::SensorElement;
use super::error::SensorError;
use super::network::ThermalNetwork;
use super::rod::SupportRod;
use anemometry::gas::IdealGas;

/// What the transducer is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RemsConstruction {
    /// Sizes, and what the wind does with them.
    pub shape: BoomShape,
    pub die_capacity_j_k: f64,
    pub die_to_leg_w_k: f64,
    pub die_to_die_w_k: f64,
    pub leg_capacity_j_k: f64,
    pub leg_to_leg_w_k: f64,
    pub leg_to_card_w_k: f64,
    pub card_capacity_j_k: f64,
    pub card_to_head_w_k: f64,
    pub card_emissivity: f64,
    pub head_capacity_j_k: f64,
    pub shank: SupportRod,
}

/// The transducer of the head of this file.
pub const REMS: RemsConstruction = RemsConstruction {
    shape: BoomShape {
        die_side_m: 1.5e-3,
        die_thickness_m: 0.25e-3,
        card_length_m: 45e-3,
        card_width_m: 22e-3,
        head_diameter_m: 10e-3,
        head_length_m: 18e-3,
        shank_diameter_m: 10e-3,
        shank_length_m: 0.1,
        shade: 0.3,
        front_to_rear: 0.1,
    },
    die_capacity_j_k: 9.3e-4,
    die_to_leg_w_k: 4.7e-3,
    die_to_die_w_k: 1.4e-5,
    leg_capacity_j_k: 3.2e-4,
    leg_to_leg_w_k: 3.7e-4,
    leg_to_card_w_k: 1.63e-3,
    card_capacity_j_k: 1.1,
    card_to_head_w_k: 6.7e-4,
    card_emissivity: 0.9,
    head_capacity_j_k: 3.6,
    shank: SupportRod { conductance_w_k: 2e-4, capacity_j_k: 4.8, cells: 3 },
};

impl RemsConstruction {
    pub(super) fn body(&self, gas: &IdealGas, support_k: f64) -> Result<ThermalBody, SensorError> {
        let mut network = ThermalNetwork::default();
        let gas_k = gas.temperature_k;
        let dice = [(); DICE].map(|()| network.add_node(self.die_capacity_j_k, gas_k));
        let legs = [(); DICE].map(|()| network.add_node(self.leg_capacity_j_k, gas_k));
        let cards = [(); CARDS].map(|()| network.add_node(self.card_capacity_j_k, gas_k));
        let head = network.add_node(self.head_capacity_j_k, gas_k);
        let (cells, support) = self.shank.add(&mut network, &[head], gas_k, support_k);

        for i in 0..DICE {
            let card = i / DICE_PER_CARD;
            let next = card * DICE_PER_CARD + (i + 1) % DICE_PER_CARD;
            network.link(dice[i], legs[i], self.die_to_leg_w_k);
            network.link(dice[i], dice[next], self.die_to_die_w_k);
            network.link(legs[i], legs[next], self.leg_to_leg_w_k);
            network.link(legs[i], cards[card], self.leg_to_card_w_k);
        }
        for card in cards {
            network.link(card, head, self.card_to_head_w_k);
        }

        let bare = |name: String, node: usize, element: Option<usize>| Surface {
            name,
            node,
            emissivity: 0.0,
            area_m2: 0.0,
            carries: Vec::new(),
            element,
        };
        let mut surfaces: Vec<Surface> = (0..DICE).map(|i| bare(die_name(i), dice[i], Some(i))).collect();
        surfaces.extend(cards.iter().enumerate().map(|(i, &card)| Surface {
            emissivity: self.card_emissivity,
            area_m2: self.shape.card_area_m2(),
            ..bare(format!("card{}", i + 1), card, None)
        }));
        surfaces.push(bare("head".to_owned(), head, Some(DICE)));
        surfaces.extend(cells.iter().enumerate().map(|(i, &cell)| bare(format!("shank{}", i + 1), cell, None)));
        let elements = dice.into_iter().chain([head]).collect();
        let convection = BodyConvection::Boom(Boom::new(gas, &self.shape)?);
        Ok(ThermalBody::new(network, elements, surfaces, support, convection, gas))
    }
}

fn die_name(i: usize) -> String {
    format!("card{}-die{}", i / DICE_PER_CARD + 1, i % DICE_PER_CARD + 1)
}

/// The elements.
pub(super) fn elements() -> Vec<SensorElement> {
    let die = |i: usize| SensorElement { name: die_name(i), normal: Some(card_normal(i / DICE_PER_CARD)) };
    (0..DICE).map(die).chain([SensorElement { name: "boom".to_owned(), normal: None }]).collect()
}

#[cfg(test)]
mod tests;
