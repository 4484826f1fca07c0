//! The quiescent-gas network of a head in numbers: how every element heats itself and every other
//! one.
//!
//! ```text
//! T_j = T_j,rest + Σ_i Σ_k R_ijk x_ijk,    dx_ijk/dt = ξ_ijk (P_i − m_ijk q_i − x_ijk)
//! ```
//!
//! | symbol | field | meaning | unit |
//! |---|---|---|---|
//! | ξ | `mesh_rad_s` | rates of the relaxations | rad/s |
//! | R | `r_k_per_w` | thermal resistance of each relaxation | K/W |
//! | m | `surface` | temperature of the surface over that of the element in each relaxation ([`from_model`](super::from_model)); 1 for an element without a surface | |
//! | P | | heating power | W |
//! | q | | convective power; of an element without a surface the heat that it loses on ways that the identification did not have: to a support or by a stem that are warmer, colder or windier than they were | W |

use diffusive::model::export::cauer::LadderSection;
use serde::{Deserialize, Serialize};

use crate::head::element::NominalElement;

/// Self-heating of an element, written as `[[calibration.self_heating]]` of a head file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SelfHeatingParameters {
    /// Place of the element in the head.
    #[serde(skip)]
    pub element: usize,
    /// Name of the element.
    #[serde(rename = "element")]
    pub name: String,
    /// Temperature with no heating at all, °C.
    pub rest_c: f64,
    /// Noise of one reading at the low and at the high level.
    #[serde(rename = "noise_k")]
    pub noise: ReadingNoise,
    /// ξ_k, ascending.
    pub mesh_rad_s: Vec<f64>,
    /// R_k
    pub r_k_per_w: Vec<f64>,
    /// m_k; `None` for an element without a surface in the wind.
    pub surface: Option<Vec<f64>>,
    /// Layers between the element and its surface; a head file has none, as the shares m_k say all
    /// that the board needs of them.
    #[serde(skip)]
    pub layers: Vec<LadderSection>,
}

/// Standard deviations of a reading, K; a pair of numbers in a file.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(from = "[f64; 2]", into = "[f64; 2]")]
pub struct ReadingNoise {
    /// At the low level of the current.
    pub low_k: f64,
    /// At the high level.
    pub high_k: f64,
}

/// Cross-heating of one element by another, written as `[[calibration.cross_heating]]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CrossHeatingParameters {
    /// Place in the head of the element that heats.
    #[serde(skip)]
    pub from: usize,
    /// Place in the head of the element that becomes warm.
    #[serde(skip)]
    pub to: usize,
    /// Name of the element that heats.
    #[serde(rename = "from")]
    pub from_name: String,
    /// Name of the element that becomes warm.
    #[serde(rename = "to")]
    pub to_name: String,
    /// ξ_k, ascending.
    pub mesh_rad_s: Vec<f64>,
    /// R_k
    pub r_k_per_w: Vec<f64>,
    /// m_k of the surface of `from`.
    pub surface: Vec<f64>,
}

/// The network of all elements of a head, in the head's order.
#[derive(Debug, Clone, PartialEq)]
pub struct QuiescentNetwork {
    /// Self-heating, one an element.
    pub own: Vec<SelfHeatingParameters>,
    /// Cross-heating, one an ordered pair of elements.
    pub cross: Vec<CrossHeatingParameters>,
}

impl QuiescentNetwork {
    /// Tells whether there are elements without a surface, which find heat from the support.
    pub fn has_cores(&self) -> bool {
        self.own.iter().any(|own| own.surface.is_none())
    }
}

impl SelfHeatingParameters {
    /// m_k, whether there is a surface or not.
    pub fn shares(&self) -> Vec<f64> {
        self.surface.clone().unwrap_or_else(|| vec![1.0; self.mesh_rad_s.len()])
    }
}

impl ReadingNoise {
    /// By that at the low level: a reading at the high level is so much better as its current is
    /// greater.
    pub fn by_low(low_k: f64, of: &NominalElement) -> Self {
        Self { low_k, high_k: low_k * of.current_low_a / of.current_high_a }
    }
}

impl From<[f64; 2]> for ReadingNoise {
    fn from([low_k, high_k]: [f64; 2]) -> Self {
        Self { low_k, high_k }
    }
}

impl From<ReadingNoise> for [f64; 2] {
    fn from(ReadingNoise { low_k, high_k }: ReadingNoise) -> Self {
        [low_k, high_k]
    }
}

/// A model that cannot be a head's quiescent-gas network, a network whose filters cannot be
/// designed, or records that make no network together: what is wrong, where, and what would be
/// right. Nobody treats one of them otherwise than another.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct NetworkError(String);

impl NetworkError {
    pub(super) fn new(sentence: impl std::fmt::Display) -> Self {
        Self(sentence.to_string())
    }

    /// The same with the element that it is about.
    pub(super) fn of(self, element: &str) -> Self {
        Self(format!("element `{element}`: {self}"))
    }
}
