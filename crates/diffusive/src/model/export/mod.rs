//! A model in the forms that others use: networks, netlists, frequency responses, tables for a
//! board.
//!
//! One pair of input and output in one event class is a one-port of thermal impedance, in K/W:
//!
//! ```text
//! Z(s) = feed-through + Σ_k R_k / (1 + s/ξ_k)
//! ```
//!
//! | module | form |
//! |---|---|
//! | [`state_space()`] | matrices in discrete time |
//! | [`response`](mod@response) | Z(jω), with dead time and with the wind of structure `conductance` |
//! | [`symbol`] | the continuous symbol η(ξ_k) |
//! | [`foster`] | R_k parallel C_k in series, straight from the model |
//! | [`cauer`] | the ladder of the same impedance, and its cumulative structure function |
//! | [`spice`] | either network as a netlist |
//! | [`source`] | constants in C or Rust |
//! | [`table`] | all that is a table, as CSV |
//!
//! [`PairClass`](super::PairClass) finds the pair and the class.

pub mod cauer;
pub mod foster;
mod report;
pub mod response;
pub mod source;
pub mod spice;
mod state_space;
pub mod symbol;
pub mod table;

pub use cauer::structure_function;
pub use report::{ExportForm, ExportReport};
pub use response::{impulse_response, response_in_class};
pub use state_space::{StateSpace, state_space};
pub use symbol::continuous_symbol;
