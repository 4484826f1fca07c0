//! Properties of the gas that decide between wind and heat: one value for each of the three
//! properties that the equations contain.
//!
//! ```text
//! Re = |v| ρ d / µ          G = Nu k A / d
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | ρ | density | kg/m³ |
//! | µ | dynamic viscosity | Pa·s |
//! | k | thermal conductivity | W/(m·K) |
//!
//! At which temperature the properties are taken (of the gas, or of the film half-way to the
//! surface) is for the calibration to choose; it must only be the same afterwards.

use crate::error::{self, ConfigError, Parameter};

/// A gas at the pressure and temperature of the moment. Immutable; made anew when these have
/// changed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GasState {
    density_kg_m3: f32,
    viscosity_pa_s: f32,
    conductivity_w_m_k: f32,
}

impl GasState {
    /// # Errors
    /// Names the property that is not a finite number greater than zero, or beyond what any gas has
    /// (1000 kg/m³, 1 Pa·s, 10 W/(m·K)).
    pub fn new(density_kg_m3: f32, viscosity_pa_s: f32, conductivity_w_m_k: f32) -> Result<Self, ConfigError> {
        let checked = |parameter, value, most| error::within(parameter, error::positive(parameter, value)?, 0.0, most);
        Ok(Self {
            density_kg_m3: checked(Parameter::DensityKgM3, density_kg_m3, 1000.0)?,
            viscosity_pa_s: checked(Parameter::ViscosityPaS, viscosity_pa_s, 1.0)?,
            conductivity_w_m_k: checked(Parameter::ConductivityWMK, conductivity_w_m_k, 10.0)?,
        })
    }

    /// Reynolds number of 1 m/s, s/m.
    pub fn reynolds_per_speed(&self, diameter_m: f32) -> f32 {
        self.density_kg_m3 * diameter_m / self.viscosity_pa_s
    }

    /// Conductance of an area at a Nusselt number of one, W/K.
    pub fn conductance_per_nusselt_w_k(&self, diameter_m: f32, area_m2: f32) -> f32 {
        self.conductivity_w_m_k * area_m2 / diameter_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_property_that_no_gas_has_is_refused_by_name() {
        for (density, viscosity, conductivity, parameter) in [
            (0.0, 1e-5, 0.01, Parameter::DensityKgM3),
            (0.02, f32::NAN, 0.01, Parameter::ViscosityPaS),
            (0.02, -1e-5, 0.01, Parameter::ViscosityPaS),
            (0.02, 1e-5, f32::INFINITY, Parameter::ConductivityWMK),
        ] {
            assert_eq!(GasState::new(density, viscosity, conductivity).unwrap_err().parameter, parameter);
        }
    }
}
