//! The true state of a simulated sensor, which no instrument can see.

/// The true state at the end of the last sample period; powers and heat flows are means over it.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorTruth {
    /// Since the start, s.
    pub time_s: f64,
    /// Of every element, °C.
    pub element_temperature_c: Vec<f64>,
    /// Electrical heat of every element.
    pub power_w: Vec<f64>,
    /// Of every surface, in the order of
    /// [`Sensor::surface_names`](super::Sensor::surface_names); so are the next three.
    pub surface_temperature_c: Vec<f64>,
    /// To the gas.
    pub convection_w: Vec<f64>,
    /// To the surroundings.
    pub radiation_w: Vec<f64>,
    /// To the inside and to other surfaces.
    pub conduction_w: Vec<f64>,
    /// From stem or boom to the support.
    pub support_w: f64,
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
        self.convection_w[surface] + self.radiation_w[surface] + self.conduction_w[surface]
    }
}
