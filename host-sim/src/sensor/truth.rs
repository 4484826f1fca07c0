//! The true state of a simulated sensor, which no instrument can see.

use super::body::Flows;

/// The true state at the end of the last sample period; powers and heat flows are means over it.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorTruth {
    /// Since the start, s.
    pub time_s: f64,
    /// Of every element, °C.
    pub element_temperature_c: Vec<f64>,
    /// Of every surface, in the order of
    /// [`Sensor::surface_names`](super::Sensor::surface_names).
    pub surface_temperature_c: Vec<f64>,
    /// Mean heat flows.
    pub flows: Flows,
    /// Temperature of the gas, °C.
    pub gas_temperature_c: f64,
    /// Wind vector, m/s.
    pub wind_m_s: [f64; 3],
    /// The wind was beyond what is known of convection from this body, which is then an
    /// extrapolation.
    pub wind_extrapolated: bool,
}

impl SensorTruth {
    /// All heat that leaves a surface: to gas, surroundings and the inside.
    pub fn surface_loss_w(&self, surface: usize) -> f64 {
        self.flows.convection_w[surface] + self.flows.radiation_w[surface] + self.flows.conduction_w[surface]
    }
}
