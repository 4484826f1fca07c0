//! Properties of a gas at the pressure and temperature of the moment.
//!
//! ```text
//! ρ = p / (R_s (T + 273.15))
//! µ, k = Σ a_n sⁿ,   s = (2 T − T_least − T_most) / (T_most − T_least)
//! ```
//!
//! The polynomials stand in for the correlations of one gas between two temperatures, which need
//! roots and exponentials; whoever makes them says how near they come. R_s is the specific gas
//! constant, J/(kg·K).

use super::gas::GasState;
use crate::error::{self, ConfigError, Parameter};

/// Number of coefficients.
pub const TERMS: usize = 7;
/// Zero of the Celsius scale, K.
pub const ZERO_CELSIUS_K: f32 = 273.15;

/// A gas as it travels and is stored.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GasLawConfig {
    /// R_s, J/(kg·K).
    pub gas_constant_j_kg_k: f32,
    /// Least temperature at which the polynomials hold, °C.
    pub least_c: f32,
    /// Greatest one, °C.
    pub most_c: f32,
    /// a_0, a_1 … of the viscosity, Pa·s.
    pub viscosity_pa_s: [f32; TERMS],
    /// a_0, a_1 … of the conductivity, W/(m·K).
    pub conductivity_w_m_k: [f32; TERMS],
}

/// A gas, checked. Immutable.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
pub struct GasLaw {
    config: GasLawConfig,
}

impl GasLaw {
    /// # Errors
    /// Names a number that is not finite, temperatures that do not ascend, or a gas constant that
    /// is not greater than zero.
    pub fn new(config: &GasLawConfig) -> Result<Self, ConfigError> {
        error::positive(Parameter::GasConstantJKgK, config.gas_constant_j_kg_k)?;
        error::ascending((Parameter::GasTemperatureC, config.least_c), (Parameter::GasTemperatureC, config.most_c))?;
        error::within(Parameter::GasTemperatureC, config.least_c, -ZERO_CELSIUS_K, 1e4)?;
        for &a in config.viscosity_pa_s.iter().chain(&config.conductivity_w_m_k) {
            error::within(Parameter::GasPolynomial, a, -1.0, 1.0)?;
        }
        Ok(Self { config: *config })
    }

    /// The gas at a pressure and a temperature.
    ///
    /// # Errors
    /// Names what lies outside of where the law holds, or is no gas.
    pub fn at(&self, pressure_pa: f32, temperature_c: f32) -> Result<GasState, ConfigError> {
        let GasLawConfig { gas_constant_j_kg_k, least_c, most_c, .. } = self.config;
        error::positive(Parameter::PressurePa, pressure_pa)?;
        error::within(Parameter::GasTemperatureC, temperature_c, least_c, most_c)?;
        let s = (2.0 * temperature_c - least_c - most_c) / (most_c - least_c);
        let sum = |a: &[f32; TERMS]| a.iter().rev().fold(0.0, |sum, &a| sum * s + a);
        GasState::new(
            pressure_pa / (gas_constant_j_kg_k * (temperature_c + ZERO_CELSIUS_K)),
            sum(&self.config.viscosity_pa_s),
            sum(&self.config.conductivity_w_m_k),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn config() -> GasLawConfig {
        let mut config = GasLawConfig {
            gas_constant_j_kg_k: 188.92,
            least_c: -123.15,
            most_c: 126.85,
            viscosity_pa_s: [0.0; TERMS],
            conductivity_w_m_k: [0.0; TERMS],
        };
        config.viscosity_pa_s[..3].copy_from_slice(&[13e-6, 6e-6, -1e-6]);
        config.conductivity_w_m_k[..2].copy_from_slice(&[14e-3, 9e-3]);
        config
    }

    #[test]
    fn a_gas_has_its_density_and_the_values_of_the_polynomials() {
        // In the middle s = 0, half-way up 0.5.
        let law = GasLaw::new(&config()).unwrap();
        let wanted = GasState::new(700.0 / (188.92 * (64.35 + 273.15)), 13e-6 + 3e-6 - 0.25e-6, 18.5e-3).unwrap();
        let gas = law.at(700.0, 64.35).unwrap();
        assert!((gas.reynolds_per_speed(0.01) / wanted.reynolds_per_speed(0.01) - 1.0).abs() < 1e-6);
        assert!((gas.conductance_per_nusselt_w_k(1.0, 1.0) / 18.5e-3 - 1.0).abs() < 1e-6);
    }

    #[test]
    fn what_it_does_not_know_is_refused_by_name() {
        let law = GasLaw::new(&config()).unwrap();
        assert_eq!(law.at(700.0, -130.0).unwrap_err().parameter, Parameter::GasTemperatureC);
        assert_eq!(law.at(700.0, f32::NAN).unwrap_err().parameter, Parameter::GasTemperatureC);
        assert_eq!(law.at(0.0, 0.0).unwrap_err().parameter, Parameter::PressurePa);
        let bad = GasLawConfig { most_c: -200.0, ..config() };
        assert_eq!(GasLaw::new(&bad).unwrap_err().parameter, Parameter::GasTemperatureC);
    }
}
