//! Prototype B as a thermal network: four silver sectors, a platinum chip on each, two core
//! heaters, a support stem.
//!
//! ```text
//!   gas ── sector 1 ── chip 1        sectors 1 and 2 face core 1, sectors 3 and 4 core 2;
//!            │   ╲                   every sector also touches the three others,
//!            │    sector 2 …         and all four radiate to surroundings at gas temperature
//!          core 1 ══ core 2
//!               ╲    ╱
//!            stem, 8 cells ── support at a fixed temperature
//! ```
//!
//! | part | value | origin |
//! |---|---|---|
//! | sphere | 10 mm | published |
//! | sector | 0.118 J/K | published 0.5 g of silver, 235 J/(kg·K); at 0.6 mm its own gradient is 1e-3 of that to the gas |
//! | chip | 4.7 mJ/K | derived: bare silicon, 2.5 × 2.5 × 0.5 mm, 2330 kg/m³, 650 J/(kg·K) at 250 K |
//! | chip to sector | 2 W/K | derived: soldered; half its thickness 0.2, 25 µm of solder 0.1, spreading in 0.6 mm of silver 0.2 K/W |
//! | sector to core | 0.6 mW/K | assumed: gas gap and wires |
//! | sector to sector | 0.1 mW/K | assumed: three seams each |
//! | core | 75 mJ/K each | derived: half of 0.15 J/K: two FR4 boards of 6 × 6 × 0.8 mm with copper, solder and resistor |
//! | core to core | 20 mW/K | derived: the boards back to back, 36 mm² through 2 × 0.4 mm of FR4 at 0.3 W/(m·K), and some vias |
//! | stem | 1.2 mW/K, 0.2 J/K | assumed; from the cores to the support in 8 cells |
//! | emissivity | 0.03 | sputtered gold |
//!
//! The element that heats and senses is the chip on a sector, and the board itself in the core.
//! What a chip reads right after a period at the high level lies above its sector by power times
//! contact (20 mK here). A one-bit loop turns part of that into an offset of the mean: up to 9 mK
//! at 100 Hz; glued with 20 µm of silver epoxy (0.5 W/K) it would be 25 mK.
//!
//! Elements: `sector1` … `sector4` (the chips), `core1`, `core2`, and a
//! [`reference`](mod@reference) where the head has one. Surfaces: the four sectors.
//!
//! Limits: those of every [sphere](super::sphere).

use super::convection::sphere_surfaces::SphereDivision;
use super::rod::SupportRod;
use super::sphere::{CarriedLayer, SphereConstruction};

/// Prototype B; its only layer is the chip.
pub const SPHERE_B: SphereConstruction = SphereConstruction {
    name: "sphere-b",
    diameter_m: 0.01,
    division: SphereDivision::Sectors,
    surface_capacity_j_k: 0.118,
    layers: &[CarriedLayer { capacity_j_k: 4.7e-3, contact_w_k: 2.0 }],
    surface_to_core_w_k: 6e-4,
    surface_to_surface_w_k: 1e-4,
    core_capacity_j_k: 0.075,
    core_to_core_w_k: 0.02,
    stem: SupportRod { conductance_w_k: 1.2e-3, capacity_j_k: 0.2, cells: 8 },
    emissivity: 0.03,
    reference: false,
};

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    use crate::sensor::body::testing::imbalance;
    use crate::sensor::body::{STEFAN_BOLTZMANN, ThermalBody};
    use anemometry::gas::{IdealGas, Species, ZERO_CELSIUS_K};

    const SECTORS: usize = 4;

    fn mars() -> IdealGas {
        IdealGas::new(Species::CarbonDioxide, 700.0, 220.0).unwrap()
    }

    fn body() -> ThermalBody {
        SPHERE_B.body(&mars(), 230.0).unwrap()
    }

    #[test]
    fn heat_in_is_heat_out_and_heat_stored() {
        let wind = |phase: f64| [6.0 * phase.cos(), 3.0 * phase.sin(), 1.0];
        let power_w = |i, high| if high { 0.04 } else { 0.001 * i as f64 };
        let weather = |body: &mut ThermalBody, phase| body.set_wind(wind(phase));
        let imbalance = imbalance(&mut body(), (100_000, 0.01), weather, power_w);
        assert!(imbalance.abs() < 1e-10, "{imbalance}");
    }

    #[test]
    fn heat_in_is_heat_out_and_heat_stored_in_a_swinging_gas_and_with_a_reference() {
        let construction = SphereConstruction { reference: true, ..SPHERE_B };
        let mut body = construction.body(&mars(), 230.0).unwrap();
        let weather = |body: &mut ThermalBody, phase: f64| {
            body.set_gas_temperature_k(220.0 + 15.0 * (0.3 * phase).sin());
            body.set_wind([6.0 * phase.cos(), 3.0 * phase.sin(), 1.0]);
        };
        let power_w = |i, high| match i {
            6 => 8e-6,
            _ if high => 0.04,
            _ => 0.001 * i as f64,
        };
        let imbalance = imbalance(&mut body, (100_000, 0.01), weather, power_w);
        assert!(imbalance.abs() < 1e-10, "{imbalance}");
    }

    #[test]
    fn steady_heat_of_a_sector_is_what_it_conducts_radiates_and_gives_to_the_gas() {
        let mut body = body();
        body.set_wind([2.0, 0.0, 0.0]);
        body.settle(|_, _| 0.02);
        body.advance(0.01, |_, _| 0.02);
        let flows = body.flows();
        for (i, conductance) in body.conductance_w_k().iter().enumerate() {
            let overheat = body.surface_temperature_c(i) + ZERO_CELSIUS_K - 220.0;
            assert!((flows.convection_w[i] - conductance * overheat).abs() < 1e-12);
            let left = flows.convection_w[i] + flows.radiation_w[i] + flows.conduction_w[i];
            assert!((left - 0.02).abs() < 1e-9, "{left}");
            // The chip stands above its sector by the heat through its contact.
            let contact = body.element_temperature_c(i) - body.surface_temperature_c(i);
            assert!((contact - 0.02 / 2.0).abs() < 1e-9);
        }
    }

    #[test]
    fn gold_radiates_about_a_fiftieth_of_a_milliwatt_a_kelvin() {
        let mut body = body();
        // A warm sphere: 4 ε σ A T³ at the mean of 220 K and its own temperature.
        body.set_conductance_w_k(&[1e-12; SECTORS]);
        body.settle(|i, _| if i < SECTORS { 5e-3 } else { 0.0 });
        body.advance(1e-3, |i, _| if i < SECTORS { 5e-3 } else { 0.0 });
        let flows = body.flows();
        let overheat = body.surface_temperature_c(0) + ZERO_CELSIUS_K - 220.0;
        let per_kelvin = flows.radiation_w.iter().sum::<f64>() / overheat;
        let mean_k: f64 = 220.0 + 0.5 * overheat;
        let expected = 4.0 * 0.03 * STEFAN_BOLTZMANN * PI * 1e-4 * mean_k.powi(3);
        assert!((per_kelvin / expected - 1.0).abs() < 0.02, "{per_kelvin} for {expected}");
        let at_gas = 4.0 * 0.03 * STEFAN_BOLTZMANN * PI * 1e-4 * 220.0_f64.powi(3);
        assert!((at_gas * 1e3 - 0.02).abs() < 0.005, "{at_gas}");
    }

    #[test]
    fn the_stem_conducts_what_it_should() {
        // Only core 1 is heated and nothing leaves through the gas: all heat goes down the stem.
        let mut body = SphereConstruction { emissivity: 0.0, ..SPHERE_B }.body(&mars(), 230.0).unwrap();
        body.set_conductance_w_k(&[0.0; SECTORS]);
        body.settle(|i, _| if i == SECTORS { 0.012 } else { 0.0 });
        body.advance(0.01, |i, _| if i == SECTORS { 0.012 } else { 0.0 });
        let flows = body.flows();
        assert!((flows.support_w - 0.012).abs() < 1e-9);
        // The mean of the two cores drives it: 12 mW over 1.2 mW/K is 10 K, the symmetric
        // half-links see exactly the mean.
        let mean_core = 0.5 * (body.element_temperature_c(4) + body.element_temperature_c(5)) + ZERO_CELSIUS_K;
        assert!((mean_core - 240.0).abs() < 1e-6, "{mean_core}");
    }

    #[test]
    fn a_free_sector_cools_with_the_published_time_constant() {
        // Silver sphere in still gas of 1 m/s or less: C/G = 4 · 0.118 / (1.2 to 1.4 mW/K), 340–400
        // s.
        let mut body = body();
        body.set_wind([1.0, 0.0, 0.0]);
        let total: f64 = body.conductance_w_k().iter().sum();
        let time_constant_s = 4.0 * SPHERE_B.surface_capacity_j_k / total;
        assert!((340.0..=400.0).contains(&time_constant_s), "{time_constant_s}");
    }

    #[test]
    #[should_panic(expected = "a link conducts")]
    fn an_impossible_construction_does_not_become_a_network() {
        let layers = &[CarriedLayer { capacity_j_k: 4.7e-3, contact_w_k: 0.0 }];
        let _ = SphereConstruction { layers, ..SPHERE_B }.body(&mars(), 230.0);
    }
}
