//! Data sheet of an element in f64: its resistor and its two currents.

use serde::Deserialize;

/// Nominal characteristic of a platinum resistor, as a head file has it.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(tag = "characteristic", rename_all = "lowercase", deny_unknown_fields)]
pub enum PlatinumKind {
    /// R = R0 (1 + αT).
    Linear {
        /// R0, Ω.
        resistance_0c_ohm: f64,
        /// α, 1/°C.
        coefficient_per_c: f64,
    },
    /// IEC 60751, whose coefficients are fixed.
    Iec60751 {
        /// R0, Ω.
        resistance_0c_ohm: f64,
    },
}

/// Nominal values of one element and its two currents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NominalElement {
    /// Resistor.
    pub platinum: PlatinumKind,
    /// Low level, A.
    pub current_low_a: f64,
    /// High level as it was made, A; the controller's may be measured.
    pub current_high_a: f64,
}
