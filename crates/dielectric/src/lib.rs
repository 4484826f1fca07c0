//! Charge in the dielectric of a contactless electrostatic MEMS, the thesis' other diffusive system
//! (2.4, 3.4): its devices, simulated and measured, and experiments on them.
//!
//! The membrane of a capacitor with a bias V has the capacitance C(V) = α (V − V_sh)² + C₀, where
//! V_sh = Q_d/C_d is the voltage shift of the charge Q_d that the dielectric has trapped. Symbols
//! of one bit (V₊ for most of a symbol time and V₋ for the rest, or the reverse) drive the charge
//! up or down, and one quasi-differential reading a symbol gives V_sh without C₀.

pub mod device;
pub mod experiment;
pub mod meter;
pub mod port;
pub mod predict;
pub mod run;
pub mod simulated;

/// The examples name this crate as others do.
#[cfg(test)]
extern crate self as dielectric;
