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
//! | m | `surface` | temperature of the surface over that of the element in each relaxation ([`ladder`](super::ladder)) | |
//! | P, q | | heating power and convective power | W |

use serde::Serialize;

use super::ladder::{LadderSection, contact_time_s};

/// Self-heating of an element.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SelfHeatingParameters {
    /// Place of the element in the head.
    #[serde(skip)]
    pub element: usize,
    /// Name of the element.
    pub name: String,
    /// Temperature with no heating at all, °C.
    pub rest_c: f64,
    /// ξ_k, ascending.
    pub mesh_rad_s: Vec<f64>,
    /// R_k
    pub r_k_per_w: Vec<f64>,
    /// m_k; `None` for an element that no wind cools.
    pub surface: Option<Vec<f64>>,
    /// Layers between the element and its surface.
    pub layers: Vec<LadderSection>,
}

/// Cross-heating of one element by another.
#[derive(Debug, Clone, PartialEq)]
pub struct CrossHeatingParameters {
    /// Place in the head of the element that heats.
    pub from: usize,
    /// Place in the head of the element that becomes warm.
    pub to: usize,
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

impl SelfHeatingParameters {
    /// By how much the surface lags behind the element, s.
    pub fn contact_time_s(&self) -> f64 {
        contact_time_s(&self.layers)
    }
}
