//! Mean readings of a head in one steady, known wind.

use dr_core::wind::GasState;

use super::error::CalibrateError;
use crate::gas::{IdealGas, ZERO_CELSIUS_K};

/// One steady wind.
#[derive(Debug, Clone, PartialEq)]
pub struct SteadyWind {
    /// Label of the conditions.
    pub label: String,
    /// Where the gas goes to, m/s, in the tunnel's frame; zero for quiescent gas.
    pub wind_m_s: [f64; 3],
    /// The gas.
    pub gas: IdealGas,
    /// Readings of the surfaces, in the head's order.
    pub surfaces: Vec<SurfaceReading>,
}

/// Mean readings of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceReading {
    /// Convective power beyond that in quiescent gas at the reference, W.
    pub power_w: f64,
    /// Surface over gas, K.
    pub overheat_k: f64,
    /// Surface over the gas of the identification, K.
    pub above_reference_k: f64,
    /// Variance of the mean of `power_w`, W².
    pub variance_w2: f64,
}

impl SteadyWind {
    /// Gas temperature, °C, pressure, Pa, and temperatures of the surfaces, °C.
    pub(super) fn conditions(&self) -> (f64, f64, Vec<f64>) {
        let gas_c = self.gas.temperature_k - ZERO_CELSIUS_K;
        (gas_c, self.gas.pressure_pa, self.surfaces.iter().map(|of| gas_c + of.overheat_k).collect())
    }

    /// Mean overheat of the surfaces, K.
    pub(super) fn overheat_k(&self) -> f64 {
        self.surfaces.iter().map(|of| of.overheat_k).sum::<f64>() / self.surfaces.len() as f64
    }

    /// The gas as dr-core takes it, with its properties at so great a share of the way from its
    /// temperature to that of the surfaces.
    pub(super) fn core_gas(&self, film_share: f64) -> Result<GasState, CalibrateError> {
        let IdealGas { species, pressure_pa, temperature_k, .. } = self.gas;
        let properties_k = temperature_k + film_share * self.overheat_k();
        let gas = match film_share > 0.0 {
            true => {
                IdealGas::new(species, pressure_pa, properties_k).map_err(|error| self.refuse(error.to_string()))?
            }
            false => self.gas,
        };
        let IdealGas { density_kg_m3, viscosity_pa_s, conductivity_w_m_k, .. } = gas;
        GasState::new(density_kg_m3 as f32, viscosity_pa_s as f32, conductivity_w_m_k as f32)
            .map_err(|error| self.refuse(format!("gas: {error}")))
    }

    /// The error for a reading of this wind.
    pub(super) fn refuse(&self, problem: String) -> CalibrateError {
        CalibrateError::Reading(format!("`{}`: {problem}", self.label))
    }
}
