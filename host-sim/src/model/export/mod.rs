//! A model in the forms that others use: networks, netlists, frequency responses, tables for a board.
//!
//! One pair of input and output in one event class is a one-port of thermal impedance, in K/W:
//!
//! ```text
//! Z(s) = feed-through + Σ_k R_k / (1 + s/ξ_k)
//! ```
//!
//! | module | form |
//! |---|---|
//! | [`response`](mod@response) | Z(jω), with dead time and with the wind of structure `conductance` |
//! | [`symbol`] | the continuous symbol η(ξ_k) |
//! | [`foster`] | R_k parallel C_k in series, straight from the model |
//! | [`cauer`] | the ladder of the same impedance, and its cumulative structure function |
//! | [`spice`] | either network as a netlist |
//! | [`source`] | constants in C or Rust |
//! | [`table`] | all that is a table, as CSV |
//!
//! [`part`] finds the pair and the class.

pub mod cauer;
pub mod foster;
pub mod part;
pub mod response;
pub mod source;
pub mod spice;
pub mod symbol;
pub mod table;
#[cfg(test)]
pub(crate) mod testing;

pub use cauer::structure_function;
pub use part::Part;
pub use response::{response, response_in_class};
pub use symbol::continuous_symbol;

/// Why a model has no such form.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ExportError {
    #[error(
        "R_{} = {resistance_k_per_w} K/W is negative, and a ladder of resistors and capacitors has none such: identify the pair with non-negative resistances, or export the Foster network",
        k + 1
    )]
    Negative { k: usize, resistance_k_per_w: f64 },
    #[error("all resistances are zero: this pair has no network")]
    Nothing,
    #[error(
        "a single rate has no distance to a neighbour, by which the continuous symbol is weighted: it needs an order of 2 at least"
    )]
    OneRate,
}
