//! Convection from a small, thin plate on its own in the stream, by a correlation.
//!
//! ```text
//! G = 4 k a n + h_plate(U, w) n l w          a = √(l w / π)
//! ```
//!
//! l, w are the plate's length across and its width along the stream, n the faces that the gas
//! meets, a the radius of a disc of its area. 4 k a is conduction from a face of an isothermal disc
//! into gas at rest; h_plate is the laminar layer of a plate, `plate_nusselt`. Their sum is the
//! form of most correlations of small bodies. With gravity, free convection of an upright plate
//! (Churchill and Chu 1975) joins the layer by `joined`.
//!
//! Limits: edge-on to whatever wind there is, so that direction does not matter; the layer of a
//! plate is that of Reynolds numbers well above 1, and here adds to conduction from 0 on; laminar
//! up to Re 5·10⁵; a continuum around the width; properties at the gas temperature.

use std::f64::consts::PI;

use super::flow::{continuum, free_plate_nusselt, joined, plate_nusselt, rayleigh};
use crate::sensor::error::SensorError;
use anemometry::gas::IdealGas;
use anemometry::head::body::PlateShape;
use anemometry::vector::length;

/// End of the laminar boundary layer.
pub(super) const LAMINAR_REYNOLDS: f64 = 5e5;

/// Convection of one plate in one gas.
#[derive(Clone, Debug)]
pub struct Plate {
    shape: PlateShape,
    gas: IdealGas,
    conductivity_w_m_k: f64,
    /// Reynolds number of its width in 1 m/s.
    reynolds: f64,
    prandtl_third: f64,
}

impl Plate {
    /// Refuses a gas so thin that it is no continuum around the plate.
    pub fn new(gas: &IdealGas, shape: &PlateShape) -> Result<Plate, SensorError> {
        continuum(gas, shape.width_m)?;
        Ok(Plate::of(gas, shape))
    }

    fn of(gas: &IdealGas, shape: &PlateShape) -> Plate {
        Plate {
            shape: *shape,
            gas: *gas,
            conductivity_w_m_k: gas.conductivity_w_m_k,
            reynolds: gas.reynolds(1.0, shape.width_m),
            prandtl_third: libm::cbrt(gas.prandtl()),
        }
    }

    /// The same in another gas.
    pub fn follow(&mut self, gas: &IdealGas) {
        *self = Plate::of(gas, &self.shape);
    }

    /// Surface, m².
    pub fn area_m2(&self) -> f64 {
        f64::from(self.shape.faces) * self.shape.length_m * self.shape.width_m
    }

    /// Tells whether free convection joins in.
    pub fn is_free(&self) -> bool {
        self.shape.gravity_m_s2.is_some()
    }

    /// Tells whether the layer would no longer be laminar.
    pub fn extrapolated(&self, wind_m_s: [f64; 3]) -> bool {
        self.reynolds * length(wind_m_s) > LAMINAR_REYNOLDS
    }

    /// Conductance to the gas, W/K.
    pub fn conductance_w_k(&self, wind_m_s: [f64; 3], surface_k: f64) -> f64 {
        let PlateShape { length_m, width_m, .. } = self.shape;
        let (face_m2, faces) = (length_m * width_m, f64::from(self.shape.faces));
        let still_w_k = 4.0 * faces * self.conductivity_w_m_k * (face_m2 / PI).sqrt();
        let mut nusselt = plate_nusselt(self.reynolds * length(wind_m_s), self.prandtl_third);
        if let Some(gravity_m_s2) = self.shape.gravity_m_s2 {
            let overheat_k = (surface_k - self.gas.temperature_k).abs();
            let rayleigh = rayleigh(&self.gas, width_m, overheat_k, gravity_m_s2);
            // Its conduction, 0.68, is in the disc's already.
            let rising = free_plate_nusselt(rayleigh, self.gas.prandtl()) - free_plate_nusselt(0.0, 1.0);
            nusselt = joined(rising, nusselt);
        }
        still_w_k + nusselt * self.conductivity_w_m_k / width_m * faces * face_m2
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use anemometry::gas::Species;

    fn plate_of(gas: &IdealGas, [length_m, width_m]: [f64; 2], faces: u8, gravity_m_s2: Option<f64>) -> Plate {
        Plate::new(gas, &PlateShape { length_m, width_m, faces, gravity_m_s2 }).unwrap()
    }

    #[test]
    fn a_film_on_mars_takes_what_disc_and_plate_take() {
        // By hand, from the printed properties of 220 K (k 10.84 mW/(m·K), µ 11.05 µPa·s, Pr 0.773)
        // and ρ 0.02406 kg/m³ at 1000 Pa.
        let gas = IdealGas::new(Species::CarbonDioxide, 1000.0, 220.0).unwrap();
        let film = plate_of(&gas, [4e-3, 2.5e-3], 2, None);
        // 8 · 10.84e-3 · 1.784e-3.
        let still_w_k = film.conductance_w_k([0.0; 3], 250.0);
        assert!((still_w_k / 154.7e-6 - 1.0).abs() < 1e-3, "{still_w_k}");
        // Re 27.2, Nu 0.664 · 5.217 · 0.918 = 3.180, 13.79 W/(m²·K) on 20 mm². Three digits of
        // each.
        let layer_w_k = film.conductance_w_k([3.0, 0.0, -4.0], 250.0) - still_w_k;
        assert!((layer_w_k / 275.8e-6 - 1.0).abs() < 3e-3, "{layer_w_k}");
        // One face is half of it.
        let one = plate_of(&gas, [4e-3, 2.5e-3], 1, None);
        assert!((one.conductance_w_k([0.0, 5.0, 0.0], 250.0) * 2.0 / (still_w_k + layer_w_k) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_warm_plate_in_air_rises_its_own_draught_and_a_wind_overrules_it() {
        // 20 mm in air of 1 atm and 20 °C, 30 K warmer: Ra = 9.81/293.15 · 30 · 8e-6 · 0.71 /
        // (1.516e-5)² = 2.48e4; 0.670 · 12.55 / 1.304 = 6.45 beside the disc.
        let gas = IdealGas::new(Species::Air, 101_325.0, 293.15).unwrap();
        let plate = |gravity| plate_of(&gas, [0.02, 0.02], 2, gravity);
        let still = |gravity| plate(gravity).conductance_w_k([0.0; 3], 323.15);
        let rising = (still(Some(9.81)) - still(None)) / (gas.conductivity_w_m_k / 0.02 * 8e-4);
        assert!((rising / 6.45 - 1.0).abs() < 0.02, "{rising}");
        let windy = |gravity| plate(gravity).conductance_w_k([5.0, 0.0, 0.0], 323.15);
        assert!((windy(Some(9.81)) / windy(None) - 1.0).abs() < 2e-3);
    }
}
