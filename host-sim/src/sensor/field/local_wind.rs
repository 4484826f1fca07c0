//! The wind that a sphere meets: behind its stem, and with the rise of the gas that it warms.

use super::{Buoyancy, Stem};
use anemometry::gas::IdealGas;

/// From the wind to the one that a sphere meets.
#[derive(Clone, Copy, Debug, Default)]
pub struct LocalWind {
    pub buoyancy: Option<Buoyancy>,
    pub stem: Option<Stem>,
}

impl LocalWind {
    /// The wake first, then the rise; `surface_k` are temperatures of the sphere's surfaces.
    pub fn around(&self, wind_m_s: [f64; 3], gas: &IdealGas, diameter_m: f64, surface_k: &[f64]) -> [f64; 3] {
        let behind_m_s = self.stem.map_or(wind_m_s, |stem| stem.wind_m_s(wind_m_s));
        self.buoyancy.map_or(behind_m_s, |buoyancy| {
            let mean_k = surface_k.iter().sum::<f64>() / surface_k.len() as f64;
            buoyancy.wind_m_s(behind_m_s, gas, diameter_m, mean_k - gas.temperature_k)
        })
    }
}
