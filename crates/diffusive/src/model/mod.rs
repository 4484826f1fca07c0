//! Diffusive models as files: what was identified, with its uncertainty, in JSON.
//!
//! A model leads from inputs u (heating power) to outputs y (temperature). Every pair of input and
//! output has a mesh of rates ξ_k and, per event class, thermal resistances R_k (thesis 2.10,
//! normalised states):
//!
//! ```text
//! dx_k/dt = ξ_k (u(t − dead time) − x_k),    y = offset + Σ_pairs (Σ_k R_k x_k + feed-through · u)
//! ```
//!
//! Structure `symbol` (thesis 2.19): a class's R_k weigh the heat that was injected while that
//! class held. Structure `conductance` (wind as feedback): one class of R_k, and the wind in the
//! input, w = u − ΔG_class · (y − T_gas), element by element; where the gas moved, outputs follow
//! it as well ([`Following`]).
//!
//! Row n of a record holds y at t_n and u over [t_n, t_{n+1}): x at row n has seen u up to row n
//! − 1.

pub mod certainty;
mod check;
mod conditions;
mod content;
pub mod export;
mod file;
mod forward;
mod gain_unit;
mod losses;
pub mod merge;
pub mod pair_class;
pub mod reduce;
mod support;
#[cfg(any(test, feature = "testing"))]
pub mod testing;

pub use conditions::{Conditions, SAME_PRESSURE, SAME_TEMPERATURE_K};
pub use content::*;
pub use forward::Forward;
pub use gain_unit::{gain_unit, refuse_other_units, rise_unit};
pub use losses::PlacedLoss;
pub use pair_class::PairClass;

/// Reason why a model cannot be read, reduced, exported, predicted with or designed for: one
/// sentence that says what is wrong, where, and what would be right. Nobody handles one cause differently from
/// another, so that there are no variants.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct ModelError(String);

impl ModelError {
    /// An error of one sentence.
    pub fn new(sentence: impl Into<String>) -> Self {
        Self(sentence.into())
    }

    /// The same with what it is about before it: a file or a pair.
    pub fn about(self, what: impl std::fmt::Display) -> Self {
        Self(format!("{what}: {self}"))
    }
}
