//! What surfaces radiate to, and how well they radiate.
//!
//! ```text
//! Q_i = ε σ A_i (T_i⁴ − T_sky⁴)
//! ```
//!
//! | symbol | key | unit |
//! |---|---|---|
//! | Q_i | heat radiated by surface i | W |
//! | ε | `emissivity`; without it, the head's of every surface | 1 |
//! | σ = 5.670374419e-8 | Stefan–Boltzmann constant, CODATA 2018 | W/(m²·K⁴) |
//! | A_i, T_i | area and temperature of surface i | m², K |
//! | T_sky | `temperature_c`; without it, the gas's mean | K |
//!
//! Limits: grey surfaces, one radiant temperature all around. The sky's temperature is that of a
//! black enclosure that radiates as sky and ground together do.

use serde::Deserialize;

use crate::sensor::error::{SensorError, require};
use anemometry::gas::ZERO_CELSIUS_K;

/// What surfaces radiate to.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sky {
    /// Radiant temperature, °C.
    pub temperature_c: Option<f64>,
    /// Of all surfaces.
    pub emissivity: Option<f64>,
}

impl Sky {
    pub(super) fn check(&self) -> Result<(), SensorError> {
        if let Some(temperature_c) = self.temperature_c {
            let possible = temperature_c.is_finite() && temperature_c >= -ZERO_CELSIUS_K;
            require(possible, "sky.temperature_c", temperature_c, "-273.15 or more")?;
        }
        self.emissivity.map_or(Ok(()), |emissivity| {
            require((0.0..=1.0).contains(&emissivity), "sky.emissivity", emissivity, "0 to 1")
        })
    }
}
