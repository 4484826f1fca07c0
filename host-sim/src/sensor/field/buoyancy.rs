//! Mixed convection: the rise of the warmed gas as a part of the wind around a sphere.
//!
//! ```text
//! U_b   = √(g β |ΔT| d)                            β = 1 / T_g
//! v_eff = v ± U_b ẑ                                `sum`, an upper bound
//! v_eff = v ± κ_1 U_b² / (U + κ_2 U_b) ẑ           `advected`
//! ```
//!
//! | symbol | key | unit |
//! |---|---|---|
//! | g, ẑ | `gravity_m_s2`, `up` (any length) | m/s², 1 |
//! | ΔT | mean overheat of the sphere's surfaces; ± is its sign | K |
//! | T_g | temperature of the gas | K |
//! | d | diameter of the sphere | m |
//! | v, U | wind and its speed | m/s |
//! | κ_1, κ_2 | `kappa1`, `kappa2` | 1 |
//!
//! `sum` adds what an unhindered parcel would gain along the diameter. `advected` lets the wind
//! carry the parcel away after d/U, so that the rise falls as 1/U. In quiescent gas it leaves
//! κ_1/κ_2 U_b. Its default, 0.61, makes Ranz and Marshall's 0.6 √Re Pr^⅓ (Chem. Eng. Prog. 48,
//! 1952) equal to the free convection of Churchill, 0.589 Ra^¼ / (1 + (0.469/Pr)^9/16)^4/9 (Heat
//! Exchanger Design Handbook, 1983), at Pr 0.77; κ_1 = ½ is assumed.
//!
//! Limits: laminar, Ra below 1e11; a model of one number for the whole sphere, so plumes and
//! separation in opposing flow are not in it. What is beside a sphere meets the wind alone.

use serde::Deserialize;

use crate::sensor::error::{SensorError, require};
use anemometry::gas::IdealGas;
use anemometry::vector::{length, unit};

/// Law by which the rise of the gas joins the wind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum BuoyancyModel {
    /// The whole rise, whatever the wind.
    Sum,
    /// Rise that the wind leaves.
    Advected,
}

/// Gravity, and how the warmed gas rises.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Buoyancy {
    /// Gravity, m/s².
    pub gravity_m_s2: f64,
    /// Direction that points up; any length.
    #[serde(default = "z")]
    pub up: [f64; 3],
    /// Law by which the rise joins the wind.
    #[serde(default = "advected")]
    pub model: BuoyancyModel,
    /// Coefficient of `advected`.
    #[serde(default = "kappa1")]
    pub kappa1: f64,
    /// Coefficient of `advected`.
    #[serde(default = "kappa2")]
    pub kappa2: f64,
}

fn z() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

fn advected() -> BuoyancyModel {
    BuoyancyModel::Advected
}

fn kappa1() -> f64 {
    0.5
}

fn kappa2() -> f64 {
    0.82
}

impl Buoyancy {
    pub(super) fn check(&self) -> Result<(), SensorError> {
        let gravity = self.gravity_m_s2.is_finite() && self.gravity_m_s2 > 0.0;
        require(
            gravity,
            "buoyancy.gravity_m_s2",
            self.gravity_m_s2,
            "more than 0; without gravity leave the table out",
        )?;
        let long = length(self.up);
        require(long.is_finite() && long > 0.0, "buoyancy.up", long, "a vector that is longer than 0")?;
        for (key, kappa) in [("buoyancy.kappa1", self.kappa1), ("buoyancy.kappa2", self.kappa2)] {
            require(kappa.is_finite() && kappa > 0.0, key, kappa, "more than 0")?;
        }
        Ok(())
    }

    /// The wind that a sphere of mean overheat ΔT meets.
    pub(super) fn wind_m_s(&self, wind_m_s: [f64; 3], gas: &IdealGas, diameter_m: f64, overheat_k: f64) -> [f64; 3] {
        let free_m_s = (self.gravity_m_s2 / gas.temperature_k * overheat_k.abs() * diameter_m).sqrt();
        let rise_m_s = match self.model {
            _ if free_m_s == 0.0 => 0.0,
            BuoyancyModel::Sum => free_m_s,
            BuoyancyModel::Advected => self.kappa1 * free_m_s * free_m_s / (length(wind_m_s) + self.kappa2 * free_m_s),
        };
        let (up, rise_m_s) = (unit(self.up), rise_m_s.copysign(overheat_k));
        std::array::from_fn(|k| wind_m_s[k] + rise_m_s * up[k])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::convection::sphere_stream::SphereStream;
    use anemometry::gas::Species;

    const ADVECTED: Buoyancy =
        Buoyancy { gravity_m_s2: 9.81, up: [0.0, 0.0, 2.0], model: BuoyancyModel::Advected, kappa1: 0.5, kappa2: 0.82 };

    fn room() -> IdealGas {
        IdealGas::new(Species::Air, 101_325.0, 293.15).unwrap()
    }

    #[test]
    fn a_warm_sphere_of_ten_millimetres_lifts_air_by_a_tenth_of_a_metre_a_second() {
        // √(9.81 · 30 / 293.15 · 0.01) = 0.1002 m/s.
        let free = |overheat_k, model| Buoyancy { model, ..ADVECTED }.wind_m_s([0.0; 3], &room(), 0.01, overheat_k)[2];
        assert!((free(30.0, BuoyancyModel::Sum) - 0.100_2).abs() < 1e-4);
        // A cold one lets it sink; four times the overheat doubles it.
        assert!((free(-120.0, BuoyancyModel::Sum) + 0.200_4).abs() < 2e-4);
        assert!((free(30.0, BuoyancyModel::Advected) - 0.100_2 * 0.5 / 0.82).abs() < 1e-4);
        assert_eq!(free(0.0, BuoyancyModel::Advected), 0.0);
    }

    #[test]
    fn a_strong_wind_carries_the_rise_away() {
        // κ1 g β ΔT d / U, of 0.01004 m²/s², at 10 m/s and more.
        let [x, _, z] = ADVECTED.wind_m_s([20.0, 0.0, 0.0], &room(), 0.01, 30.0);
        assert_eq!(x, 20.0);
        assert!((z / (0.5 * 0.010_04 / 20.0) - 1.0).abs() < 5e-3, "{z}");
        let sum = Buoyancy { model: BuoyancyModel::Sum, up: [0.0, -1.0, 0.0], ..ADVECTED };
        assert!((sum.wind_m_s([20.0, 0.0, 0.0], &room(), 0.01, 30.0)[1] + 0.100_2).abs() < 1e-4);
    }

    #[test]
    fn quiescent_gas_takes_the_heat_of_free_convection() {
        // Churchill's Nu of a sphere, to the 10 % between correlations.
        for (species, pressure_pa, temperature_k, gravity_m_s2) in
            [(Species::Air, 101_325.0, 293.15, 9.81), (Species::CarbonDioxide, 50_000.0, 250.0, 9.81)]
        {
            let gas = IdealGas::new(species, pressure_pa, temperature_k).unwrap();
            let buoyancy = Buoyancy { gravity_m_s2, ..ADVECTED };
            let stream = SphereStream::new(&gas, 0.01).unwrap();
            let speed = length(buoyancy.wind_m_s([0.0; 3], &gas, 0.01, 30.0));
            let found = stream.coefficients(stream.reynolds([speed, 0.0, 0.0]))[0];
            let viscosity_m2_s = gas.viscosity_pa_s / gas.density_kg_m3;
            let grashof = gravity_m_s2 / temperature_k * 30.0 * 1e-6 / viscosity_m2_s.powi(2);
            let (prandtl, rayleigh) = (gas.prandtl(), grashof * gas.prandtl());
            let churchill = 2.0
                + 0.589 * libm::pow(rayleigh, 0.25)
                    / libm::pow(1.0 + libm::pow(0.469 / prandtl, 9.0 / 16.0), 4.0 / 9.0);
            assert!((found / churchill - 1.0).abs() < 0.1, "{found} for {churchill}");
        }
    }
}
