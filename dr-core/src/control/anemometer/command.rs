//! What an anemometer is told.

use crate::model::{CrossConfig, FasterConfig, OwnConfig};
use crate::sensor::wind::{CardConfig, GasLawConfig, PartConfig, nusselt::ORDERS};

/// A part of a head: a surface with the element that heats it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PartOfHead {
    /// Which element.
    pub element: u8,
    /// Its place on the sphere; of a die its card's normal, and its place on the card as `corner`.
    pub surface: PartConfig,
    /// True conductance over that which power and temperature say.
    pub gain: f32,
    /// Conductance to still gas at `AnswerConfig::reference_gas_c`, W/K: what the windless network has in it.
    pub windless_w_k: f32,
}

/// How the wind is answered.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AnswerConfig {
    /// 4 sectors, 2 hemispheres, or 4 dice of a card.
    pub parts: u8,
    /// Of the sphere, or side of a die, m.
    pub diameter_m: f32,
    /// Least and greatest Reynolds number of the points, or of the card's winds; none for a head without calibration.
    pub reynolds: Option<[f32; 2]>,
    /// Directions that are more uncertain are said to be none, rad.
    pub direction_error_max_rad: f32,
    /// An answer every so many ticks.
    pub every_ticks: u16,
    /// The element that measures the gas; without it the temperature has to be told.
    pub reference: Option<u8>,
    /// Smoothing time of its readings, and of the powers that go into raw conductances, s.
    pub smoothing_s: [f32; 2],
    /// Temperature of the gas in which the windless network was identified, °C.
    pub reference_gas_c: f32,
}

/// A request that concerns the wind. All in standby, but [`Gas`](Self::Gas), which is obeyed at any time.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum WindCommand {
    /// How an element heats itself. After the sample period.
    Own {
        /// Which, from 0.
        element: u8,
        /// Model and gains.
        config: OwnConfig,
    },
    /// Quicker gains of an element for the time after an alarm. After the element, from set 0 on.
    Faster(FasterConfig),
    /// How an element heats another. After both.
    Cross(CrossConfig),
    /// Amplitudes of the local Nusselt number at a Reynolds number.
    Point {
        /// Which point, from 0.
        point: u8,
        /// a_0 … a_5.
        amplitudes: [f32; ORDERS],
    },
    /// A part of the head.
    Part {
        /// Which, from 0.
        part: u8,
        /// What.
        config: PartOfHead,
    },
    /// The gas.
    GasLaw(GasLawConfig),
    /// Last of the set-up: from now on there are answers.
    Answer(AnswerConfig),
    /// What the gas is like now.
    Gas {
        /// Pressure, Pa.
        pressure_pa: f32,
        /// Temperature, °C, where no element measures it.
        temperature_c: Option<f32>,
    },
    /// The parts are dice on a card, and this is how they answer: in place of points.
    Card(CardConfig),
}

crate::seal::sealable!(PartOfHead { element, surface, gain, windless_w_k });
crate::seal::sealable!(AnswerConfig {
    parts,
    diameter_m,
    reynolds,
    direction_error_max_rad,
    every_ticks,
    reference,
    smoothing_s,
    reference_gas_c,
});
