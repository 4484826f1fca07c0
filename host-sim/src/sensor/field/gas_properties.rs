//! At which temperature a sphere's convection takes the properties of the gas.
//!
//! ```text
//! T_f,i = (T_i + T_g) / 2
//! G_i   = Nu_i(Re(T_f,i), Pr(T_f,i)) k(T_f,i) π d s_i
//! ```
//!
//! with surface i at T_i, gas at T_g in K, and density, viscosity, conductivity and heat capacity
//! of each surface's own T_f,i, at the gas's pressure. Source: film temperature, Incropera and
//! DeWitt, Fundamentals of Heat and Mass Transfer, ch. 6.
//!
//! Limits: each surface sees a stream of its own properties, though all share one layer. What is
//! beside a sphere keeps its own rule.

use serde::Deserialize;

/// At which temperature properties are taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum GasProperties {
    /// The gas's.
    #[default]
    Gas,
    /// The mean of gas and surface.
    Film,
}
