//! Convection from a fine wire across the stream.
//!
//! ```text
//! Kramers           Nu = 0.42 Pr^0.2 + 0.57 Pr^⅓ √Re
//! Collis, Williams  Nu = (0.24 + 0.56 Re^0.45) (T_f/T_gas)^0.17     Re ≤ 44
//!                   Nu = 0.48 Re^0.51 (T_f/T_gas)^0.17              above
//! 1/Nu_wire = 1/Nu + 2 Kn                                           temperature jump
//! G    = Nu_wire k π l         U² = U_across² + k² U_along²
//! ```
//!
//! T_f is the mean of wire and gas, at which all properties are taken; Kn the mean free path over
//! the diameter. 2 Kn is the jump of a gas of Pr 0.71 and γ 1.4 whose molecules leave with 0.9 of
//! the wall's energy.
//!
//! *Sources.* Kramers 1946, Physica 12, 61: Re 0.01 … 10⁴. Collis and Williams 1959, J. Fluid Mech.
//! 6, 357: air, Re 0.02 … 140, overheat ratios up to 1.1; below, buoyancy decides.
//!
//! *Limits.* Above the ranges, and where T_f is beyond the known gases: `extrapolated`. Kn ≤ 0.1.
//! No conduction into prongs (that is for links and rods), no free convection.

use std::f64::consts::PI;

use super::flow::{at_most, effective_speed_m_s, film_extrapolated, film_gas};
use crate::sensor::error::SensorError;
use anemometry::gas::IdealGas;
use anemometry::head::body::{WireLaw, WireShape};

/// Where the jump is no small correction any more.
const HIGHEST_KNUDSEN: f64 = 0.1;
/// Temperature jump at the wall over the mean free path, both in diameters.
const JUMP: f64 = 2.0;
/// End of the attached wake, where Collis and Williams change the law.
const SHEDDING_REYNOLDS: f64 = 44.0;

/// Convection of one wire in one gas.
#[derive(Clone, Debug)]
pub struct Wire {
    shape: WireShape,
    gas: IdealGas,
}

impl Wire {
    /// Refuses a gas so thin that the jump at the wall is no small correction.
    pub fn new(gas: &IdealGas, shape: &WireShape) -> Result<Wire, SensorError> {
        at_most(gas, shape.diameter_m, HIGHEST_KNUDSEN)?;
        Ok(Wire { shape: *shape, gas: *gas })
    }

    /// The same in another gas.
    pub fn follow(&mut self, gas: &IdealGas) {
        self.gas = *gas;
    }

    /// Surface, m².
    pub fn area_m2(&self) -> f64 {
        PI * self.shape.diameter_m * self.shape.length_m
    }

    /// Tells whether the law ends below this wind, or this temperature.
    pub fn extrapolated(&self, wind_m_s: [f64; 3], surface_k: f64) -> bool {
        let highest = match self.shape.law {
            WireLaw::Kramers => 1e4,
            WireLaw::CollisWilliams => 140.0,
        };
        film_extrapolated(&self.gas, surface_k) || self.reynolds(&film_gas(&self.gas, surface_k), wind_m_s) > highest
    }

    fn reynolds(&self, film: &IdealGas, wind_m_s: [f64; 3]) -> f64 {
        let WireShape { diameter_m, axis, yaw_factor, .. } = self.shape;
        film.reynolds(effective_speed_m_s(wind_m_s, axis, yaw_factor), diameter_m)
    }

    /// Conductance to the gas, W/K.
    pub fn conductance_w_k(&self, wind_m_s: [f64; 3], surface_k: f64) -> f64 {
        let film = film_gas(&self.gas, surface_k);
        let reynolds = self.reynolds(&film, wind_m_s);
        let continuum = match self.shape.law {
            WireLaw::Kramers => {
                let prandtl = film.prandtl();
                0.42 * libm::pow(prandtl, 0.2) + 0.57 * libm::cbrt(prandtl) * reynolds.sqrt()
            }
            WireLaw::CollisWilliams => {
                let loading = libm::pow(film.temperature_k / self.gas.temperature_k, 0.17);
                let shedding = reynolds > SHEDDING_REYNOLDS;
                loading
                    * if shedding { 0.48 * libm::pow(reynolds, 0.51) } else { 0.24 + 0.56 * libm::pow(reynolds, 0.45) }
            }
        };
        let nusselt = 1.0 / (1.0 / continuum + JUMP * film.knudsen(self.shape.diameter_m));
        nusselt * film.conductivity_w_m_k * PI * self.shape.length_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use anemometry::gas::Species;

    fn wire(law: WireLaw, yaw_factor: f64) -> Wire {
        let gas = IdealGas::new(Species::Air, 101_325.0, 293.15).unwrap();
        let shape = WireShape { diameter_m: 10e-6, length_m: 2e-3, axis: [0.0, 0.0, 1.0], yaw_factor, law };
        Wire::new(&gas, &shape).unwrap()
    }

    #[test]
    fn both_laws_agree_with_a_calculation_by_hand_and_with_each_other_within_what_they_differ() {
        // 10 µm in 10 m/s, 60 K above 20 °C: film of 323.15 K with ν 1.81e-5 m²/s, k 0.0278
        // W/(m·K), Pr 0.705, λ 0.075 µm; Re 5.52.
        // Kramers: 0.392 + 0.507 · 2.350 = 1.583; Collis: (0.24 + 0.56 · 2.157) 1.0167 = 1.472.
        // Jump: 2 · 0.0075 = 0.015: 1.546 and 1.440.
        for (law, expected) in [(WireLaw::Kramers, 1.546), (WireLaw::CollisWilliams, 1.440)] {
            let conductance = wire(law, 0.0).conductance_w_k([6.0, -8.0, 0.0], 353.15);
            let nusselt = conductance / (0.0278 * PI * 2e-3);
            assert!((nusselt / expected - 1.0).abs() < 0.02, "{law:?}: {nusselt}");
        }
    }

    #[test]
    fn a_wire_sees_what_is_across_it_and_a_share_of_what_is_along_it() {
        let inclined = wire(WireLaw::Kramers, 0.2).conductance_w_k([3.0, 0.0, 10.0], 353.15);
        let across = wire(WireLaw::Kramers, 0.0).conductance_w_k([13.0_f64.sqrt(), 0.0, 0.0], 353.15);
        assert!((inclined / across - 1.0).abs() < 1e-12);
    }

    #[test]
    fn beyond_its_range_it_says_so() {
        let collis = wire(WireLaw::CollisWilliams, 0.0);
        // Re 140 of 10 µm is some 250 m/s.
        assert!(!collis.extrapolated([200.0, 0.0, 0.0], 353.15) && collis.extrapolated([300.0, 0.0, 0.0], 353.15));
        assert!(collis.extrapolated([1.0, 0.0, 0.0], 520.0));
        let thin = IdealGas::new(Species::CarbonDioxide, 700.0, 220.0).unwrap();
        assert!(Wire::new(&thin, &collis.shape).unwrap_err().to_string().contains("gas.pressure_pa"));
    }
}
