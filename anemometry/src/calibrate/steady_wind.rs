//! Mean readings of a head in one steady, known wind.

use dr_core::wind::GasState;

use super::error::CalibrateError;

/// Properties of the gas during a reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GasProperties {
    /// ρ, kg/m³.
    pub density_kg_m3: f64,
    /// µ, Pa·s.
    pub viscosity_pa_s: f64,
    /// k, W/(m·K).
    pub conductivity_w_m_k: f64,
}

/// One steady wind.
#[derive(Debug, Clone, PartialEq)]
pub struct SteadyWind {
    /// Label of the conditions.
    pub label: String,
    /// Where the gas goes to, m/s, in the tunnel's frame; zero for quiescent gas.
    pub wind_m_s: [f64; 3],
    /// The gas.
    pub gas: GasProperties,
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

impl GasProperties {
    /// As dr-core takes it.
    ///
    /// # Errors
    /// Names the property that no gas has.
    pub fn core(&self) -> Result<GasState, dr_core::ConfigError> {
        GasState::new(self.density_kg_m3 as f32, self.viscosity_pa_s as f32, self.conductivity_w_m_k as f32)
    }
}

impl SteadyWind {
    /// The gas as dr-core takes it.
    pub(super) fn core_gas(&self) -> Result<GasState, CalibrateError> {
        self.gas.core().map_err(|error| self.refuse(format!("gas: {error}")))
    }

    /// The error for a reading of this wind.
    pub(super) fn refuse(&self, problem: String) -> CalibrateError {
        CalibrateError::Reading { label: self.label.clone(), problem }
    }
}
