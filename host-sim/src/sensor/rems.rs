//! A transducer of the REMS type as a thermal network: three cards at 120° near the tip of a boom, four silicon dice a card.
//!
//! ```text
//!   gas ── die ── support ── gas          12 times: a platinum resistor on the die heats and senses;
//!                  │   ╲                  supports of a card touch their two neighbours (1–2–3–4–1)
//!                  │    support …
//!        gas ── boom cell 1 ── gas ── cell 2 … cell 8 ── support of the boom, at a fixed temperature
//!                  │
//!             boom resistor               all outer surfaces radiate to surroundings at gas temperature
//! ```
//!
//! | part | value | origin |
//! |---|---|---|
//! | 3 cards at 120°, 4 dice a card, one resistor each | | published |
//! | die | 1.47 mJ/K | derived: silicon of 1.5 × 1.5 × 0.4 mm, 2330 kg/m³, 705 J/(kg·K); size assumed |
//! | die to its support | 1.7 mW/K | assumed, so that die and conductance make a rate near the published 0.2 Hz |
//! | support | 6 mJ/K | derived: Pyrex of 3 × 3 × 0.4 mm, 2230 kg/m³, 750 J/(kg·K); size assumed |
//! | support to its neighbour | 0.2 mW/K | assumed: adjacent dice then warm each other a few times more than diagonal ones, as published |
//! | support to boom | 0.16 mW/K | assumed, so that four dice at 17 K warm the boom by the published 0.6 to 0.7 K |
//! | boom | 10 × 100 mm, 31 J/K, 11.8 mW/K | assumed: a steel rod, 7900 kg/m³, 500 J/(kg·K), 15 W/(m·K); with its loss to the gas its poles are at the published 2·10⁻⁴ and 2·10⁻³ Hz |
//! | boom resistor | 5 mJ/K, 5 mW/K | assumed: a ceramic Pt100 of 2.3 × 2 × 1.3 mm, clamped |
//! | boom in still gas | Nu 0.7 | derived: 2 / ln(4 l / d) of a cylinder of 100 mm by 10 mm is 0.54; its end adds to that |
//! | emissivity | die 0.6, support 0.9, boom 0.2 | passivated silicon, glass, bare steel |
//! | convection head-on, along, lee | 0.8, 0.6, 0.35 | assumed around the 0.664 of a plate; published is the order: head-on cools more than reverse |
//! | upwind | 0.15 | assumed: of a card in a stream along it, the two dice in front lose some 30 % more to the layer than the two behind |
//!
//! Elements: `card1-die1` … `card3-die4`, `boom`. Surfaces: the dice, the supports of the dice, the cells of the boom. The boom comes up
//! along z, cards 1, 2 and 3 look towards azimuth 0°, 120° and 240°: the azimuth of a wind is yaw, its elevation pitch. Seen from
//! outside with the tip upwards, dice 1 to 4 go round the card from the upper right against the clock.
//!
//! Limits: those of the [convection](super::convection::boom); cards warm each other only through the boom; wires carry no heat; no
//! temperature dependence of the parts.

use std::f64::consts::PI;

use super::SensorError;
use super::body::{Body, Surface};
use super::construction::{Part, check};
use super::convection::Convection;
use super::convection::boom::{Boom, CARDS, DICE, DICE_PER_CARD, Shape, card_normal};
use super::gas::Gas;
use super::network::Network;
use super::rod::Rod;

/// What the transducer is made of; the default is the one of the head of this file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Construction {
    pub die_side_m: f64,
    pub die_capacity_j_k: f64,
    pub die_to_support_w_k: f64,
    pub die_emissivity: f64,
    pub support_side_m: f64,
    pub support_capacity_j_k: f64,
    pub support_to_neighbour_w_k: f64,
    pub support_to_boom_w_k: f64,
    pub support_emissivity: f64,
    pub boom_diameter_m: f64,
    pub boom_length_m: f64,
    pub boom_capacity_j_k: f64,
    pub boom_w_k: f64,
    pub boom_cells: usize,
    pub boom_emissivity: f64,
    pub boom_resistor_capacity_j_k: f64,
    pub boom_resistor_to_boom_w_k: f64,
    pub boom_still_nusselt: f64,
    pub head_on: f64,
    pub along: f64,
    pub lee: f64,
    pub upwind: f64,
}

impl Default for Construction {
    fn default() -> Construction {
        Construction {
            die_side_m: 1.5e-3,
            die_capacity_j_k: 1.47e-3,
            die_to_support_w_k: 1.7e-3,
            die_emissivity: 0.6,
            support_side_m: 3e-3,
            support_capacity_j_k: 6e-3,
            support_to_neighbour_w_k: 2e-4,
            support_to_boom_w_k: 1.6e-4,
            support_emissivity: 0.9,
            boom_diameter_m: 0.01,
            boom_length_m: 0.1,
            boom_capacity_j_k: 31.0,
            boom_w_k: 11.8e-3,
            boom_cells: 8,
            boom_emissivity: 0.2,
            boom_resistor_capacity_j_k: 5e-3,
            boom_resistor_to_boom_w_k: 5e-3,
            boom_still_nusselt: 0.7,
            head_on: 0.8,
            along: 0.6,
            lee: 0.35,
            upwind: 0.15,
        }
    }
}

impl Construction {
    pub(super) fn body(&self, gas: &Gas, support_k: f64) -> Result<Body, SensorError> {
        self.check()?;
        let mut network = Network::new();
        let gas_k = gas.temperature_k;
        let dice = [(); DICE].map(|()| network.add_node(self.die_capacity_j_k, gas_k));
        let supports = [(); DICE].map(|()| network.add_node(self.support_capacity_j_k, gas_k));
        let boom = Rod { conductance_w_k: self.boom_w_k, capacity_j_k: self.boom_capacity_j_k, cells: self.boom_cells };
        let (cells, support) = boom.add(&mut network, &[], gas_k, support_k);
        let resistor = network.add_node(self.boom_resistor_capacity_j_k, gas_k);

        for i in 0..DICE {
            let card = i / DICE_PER_CARD * DICE_PER_CARD;
            let neighbour = card + (i + 1) % DICE_PER_CARD;
            network.link(dice[i], supports[i], self.die_to_support_w_k);
            network.link(supports[i], supports[neighbour], self.support_to_neighbour_w_k);
            network.link(supports[i], cells[0], self.support_to_boom_w_k);
        }
        network.link(resistor, cells[0], self.boom_resistor_to_boom_w_k);

        let die = |i: usize| Surface {
            name: die_name(i),
            node: dice[i],
            emissivity: self.die_emissivity,
            area_m2: self.die_side_m * self.die_side_m,
            carries: Vec::new(),
            element: Some(i),
        };
        let under = |i: usize| Surface {
            name: format!("{}-support", die_name(i)),
            node: supports[i],
            emissivity: self.support_emissivity,
            area_m2: self.support_side_m * self.support_side_m - self.die_side_m * self.die_side_m,
            carries: Vec::new(),
            element: None,
        };
        let cell = |(i, &node): (usize, &usize)| Surface {
            name: format!("boom{}", i + 1),
            node,
            emissivity: self.boom_emissivity,
            area_m2: PI * self.boom_diameter_m * self.boom_length_m / self.boom_cells as f64,
            carries: Vec::new(),
            element: None,
        };
        let surfaces = (0..DICE).map(die).chain((0..DICE).map(under)).chain(cells.iter().enumerate().map(cell));
        let surfaces = surfaces.collect();
        let elements = dice.into_iter().chain([resistor]).collect();
        let convection = Convection::Boom(Boom::new(gas, &self.shape())?);
        Ok(Body::new(network, elements, surfaces, support, convection, gas_k))
    }

    fn shape(&self) -> Shape {
        Shape {
            die_side_m: self.die_side_m,
            support_side_m: self.support_side_m,
            boom_diameter_m: self.boom_diameter_m,
            boom_length_m: self.boom_length_m,
            boom_cells: self.boom_cells,
            boom_still_nusselt: self.boom_still_nusselt,
            head_on: self.head_on,
            along: self.along,
            lee: self.lee,
            upwind: self.upwind,
        }
    }

    fn check(&self) -> Result<(), SensorError> {
        let positive = [
            ("die_side_m", self.die_side_m),
            ("die_capacity_j_k", self.die_capacity_j_k),
            ("die_to_support_w_k", self.die_to_support_w_k),
            ("support_side_m", self.support_side_m),
            ("support_capacity_j_k", self.support_capacity_j_k),
            ("support_to_neighbour_w_k", self.support_to_neighbour_w_k),
            ("support_to_boom_w_k", self.support_to_boom_w_k),
            ("boom_diameter_m", self.boom_diameter_m),
            ("boom_length_m", self.boom_length_m),
            ("boom_capacity_j_k", self.boom_capacity_j_k),
            ("boom_w_k", self.boom_w_k),
            ("boom_cells", self.boom_cells as f64),
            ("boom_resistor_capacity_j_k", self.boom_resistor_capacity_j_k),
            ("boom_resistor_to_boom_w_k", self.boom_resistor_to_boom_w_k),
            ("boom_still_nusselt", self.boom_still_nusselt),
            ("head_on", self.head_on),
            ("along", self.along),
            ("lee", self.lee),
        ];
        let emissivities = [
            ("die_emissivity", self.die_emissivity),
            ("support_emissivity", self.support_emissivity),
            ("boom_emissivity", self.boom_emissivity),
        ];
        check(&positive, &emissivities)?;
        if self.support_side_m <= self.die_side_m {
            return Err(SensorError::out_of_range("support_side_m", self.support_side_m, "more than `die_side_m`"));
        }
        // No wind may warm a die by cooling it less than still gas does.
        let least = self.head_on.min(self.along).min(self.lee);
        if !(0.0..=least).contains(&self.upwind) {
            return Err(SensorError::out_of_range(
                "upwind",
                self.upwind,
                "0 to the least of `head_on`, `along` and `lee`",
            ));
        }
        Ok(())
    }
}

fn die_name(i: usize) -> String {
    format!("card{}-die{}", i / DICE_PER_CARD + 1, i % DICE_PER_CARD + 1)
}

/// The elements.
pub(super) fn parts() -> Vec<Part> {
    let dice = (0..CARDS * DICE_PER_CARD).map(|i| Part::facing(die_name(i), card_normal(i / DICE_PER_CARD)));
    dice.chain([Part::inside("boom".to_owned())]).collect()
}

#[cfg(test)]
mod tests;
