//! Convection from a small, thin film on its own in the stream, by a correlation.
//!
//! ```text
//! G = 8 k a + h_plate(U, w) 2 l w          a = √(l w / π)
//! ```
//!
//! l, w are the film's length across and its width along the stream, a the radius of a disc of its
//! area. 8 k a is conduction from both faces of an isothermal disc into gas at rest; h_plate is the
//! laminar layer of a plate, `plate_nusselt`, on both faces. Their sum is the form of most
//! correlations of small bodies.
//!
//! Limits: edge-on to whatever wind there is, so that direction does not matter; the layer of a
//! plate is that of Reynolds numbers well above 1, and here adds to conduction from 0 on; no free
//! convection; a continuum around the width.

use std::f64::consts::PI;

use super::flow::{continuum, plate_nusselt};
use crate::sensor::error::SensorError;
use anemometry::gas::IdealGas;
use anemometry::vector::length;

/// Convection of one film in one gas.
#[derive(Clone, Debug)]
pub struct Film {
    length_m: f64,
    width_m: f64,
    conductivity_w_m_k: f64,
    /// Of its width in 1 m/s.
    reynolds: f64,
    prandtl_third: f64,
}

impl Film {
    /// Refuses a gas so thin that it is no continuum around the film.
    pub fn new(gas: &IdealGas, length_m: f64, width_m: f64) -> Result<Film, SensorError> {
        continuum(gas, width_m)?;
        Ok(Film::of(gas, length_m, width_m))
    }

    fn of(gas: &IdealGas, length_m: f64, width_m: f64) -> Film {
        Film {
            length_m,
            width_m,
            conductivity_w_m_k: gas.conductivity_w_m_k,
            reynolds: gas.reynolds(1.0, width_m),
            prandtl_third: gas.prandtl().cbrt(),
        }
    }

    /// The same in another gas.
    pub fn follow(&mut self, gas: &IdealGas) {
        *self = Film::of(gas, self.length_m, self.width_m);
    }

    /// Conductance to the gas, W/K.
    pub fn conductance_w_k(&self, wind_m_s: [f64; 3]) -> f64 {
        let face_m2 = self.length_m * self.width_m;
        let speed_m_s = length(wind_m_s);
        let still_w_k = 8.0 * self.conductivity_w_m_k * (face_m2 / PI).sqrt();
        let nusselt = plate_nusselt(self.reynolds * speed_m_s, self.prandtl_third);
        still_w_k + nusselt * self.conductivity_w_m_k / self.width_m * 2.0 * face_m2
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use anemometry::gas::Species;

    #[test]
    fn a_film_on_mars_takes_what_disc_and_plate_take() {
        // By hand, from the printed properties of 220 K (k 10.84 mW/(m·K), µ 11.05 µPa·s, Pr 0.773)
        // and ρ 0.02406 kg/m³ at 1000 Pa.
        let gas = IdealGas::new(Species::CarbonDioxide, 1000.0, 220.0).unwrap();
        let film = Film::new(&gas, 4e-3, 2.5e-3).unwrap();
        // 8 · 10.84e-3 · 1.784e-3.
        let still_w_k = film.conductance_w_k([0.0; 3]);
        assert!((still_w_k / 154.7e-6 - 1.0).abs() < 1e-3, "{still_w_k}");
        // Re 27.2, Nu 0.664 · 5.217 · 0.918 = 3.180, 13.79 W/(m²·K) on 20 mm². Three digits of
        // each.
        let layer_w_k = film.conductance_w_k([3.0, 0.0, -4.0]) - still_w_k;
        assert!((layer_w_k / 275.8e-6 - 1.0).abs() < 3e-3, "{layer_w_k}");
    }
}
