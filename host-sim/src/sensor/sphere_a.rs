//! Prototype A as a thermal network: two silver hemispheres, a packaged platinum resistor on each,
//! two core heaters, a stem.
//!
//! ```text
//!   gas ── hemisphere 1 ── ceramic 1 ── film 1     and the same with 2; the hemispheres touch
//!             │   ╲                                along their seam and radiate to surroundings
//!             │    hemisphere 2 …                  at gas temperature
//!          core 1 ══ core 2
//!               ╲    ╱
//!            stem, 8 cells ── support at a fixed temperature
//! ```
//!
//! | part | value | origin |
//! |---|---|---|
//! | sphere | 10 mm | published |
//! | hemisphere | 0.282 J/K | published 1.2 g of silver, 235 J/(kg·K) |
//! | film | 1.0 mJ/K | derived: film under its glass cover, about 1.2 mg at 0.8 J/(g·K) |
//! | film to ceramic | 0.10 W/K | derived: 2.5 mm² of alumina, 25 W/(m·K) / 0.5 mm is 0.125, with cover and spreading |
//! | ceramic | 3.8 mJ/K | derived: alumina of 0.5 × 1.25 × 2 mm (a 0805 chip), 4.9 mg, 780 J/(kg·K) |
//! | ceramic to hemisphere | 8 mW/K | calibrated to a tail of tens of seconds (published is a slow one): 2.5 mm² of unfilled epoxy, 0.25 W/(m·K), 80 µm |
//! | hemisphere to hemisphere | 3 mW/K | assumed: equator, 19 mm² of joint, 0.1 mm wide: gas 2, dots of epoxy 1 mW/K |
//! | hemisphere to core | 2.5 mW/K | assumed: two spacers and four copper wires of 0.1 mm, 0.5 mW/K each at 6 mm, and gas 0.5 mW/K |
//! | core | 75 mJ/K each | as for sphere B: one FR4 board of 6 × 6 × 0.8 mm with copper, solder and resistor |
//! | core to core | 20 mW/K | as for sphere B: the boards back to back |
//! | stem | 2.0 mW/K, 0.3 J/K | assumed: thicker than sphere B's 1.2 mW/K, for the wires of the packaged parts; 8 cells |
//! | emissivity | 0.03 | sputtered gold, as for sphere B |
//!
//! What heats and senses is the film. Between it and the silver, which the wind sees, are two
//! resistances and the chip's own heat: at 20 mW the film stands 2.7 K above the silver (2.5 K of
//! glue and 0.2 K of ceramic). A loop that holds the film lets the silver follow the wind through
//! these, so its power answers with the time constants of the silver on the glue besides that of
//! the film. That is the difference from sphere B, whose bare chip is soldered and which has one
//! significant pole.
//!
//! Elements: `hemisphere1`, `hemisphere2` (the films), `core1`, `core2`, and a
//! [`reference`](mod@reference) where the head has one. Surfaces: the two hemispheres, looking
//! along +x and −x; the stem is along −z.
//!
//! Limits: those of every [sphere](super::sphere); the silver has no gradient (0.6 mm at
//! 429 W/(m·K) against some 2 mW/K to the gas).

use super::convection::sphere_surfaces::SphereDivision;
use super::rod::SupportRod;
use super::sphere::{CarriedLayer, SphereConstruction};

/// Prototype A; its layers are the ceramic and the film.
pub const SPHERE_A: SphereConstruction = SphereConstruction {
    name: "sphere-a",
    diameter_m: 0.01,
    division: SphereDivision::Hemispheres,
    surface_capacity_j_k: 0.282,
    layers: &[
        CarriedLayer { capacity_j_k: 3.8e-3, contact_w_k: 8e-3 },
        CarriedLayer { capacity_j_k: 1e-3, contact_w_k: 0.1 },
    ],
    surface_to_core_w_k: 2.5e-3,
    surface_to_surface_w_k: 3e-3,
    core_capacity_j_k: 0.075,
    core_to_core_w_k: 0.02,
    stem: SupportRod { conductance_w_k: 2e-3, capacity_j_k: 0.3, cells: 8 },
    emissivity: 0.03,
    reference: false,
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::body::ThermalBody;
    use crate::sensor::body::testing::imbalance;
    use anemometry::gas::{IdealGas, Species, ZERO_CELSIUS_K};

    const HEMISPHERES: usize = 2;

    fn mars() -> IdealGas {
        IdealGas::new(Species::CarbonDioxide, 700.0, 220.0).unwrap()
    }

    fn body() -> ThermalBody {
        SPHERE_A.body(&mars(), 230.0).unwrap()
    }

    #[test]
    fn heat_in_is_heat_out_and_heat_stored() {
        let wind = |phase: f64| [6.0 * phase.cos(), 3.0 * phase.sin(), 1.0];
        let power_w = |i, high| if high { 0.04 } else { 0.001 * i as f64 };
        let weather = |body: &mut ThermalBody, phase| body.set_wind(wind(phase));
        let imbalance = imbalance(&mut body(), (50_000, 0.01), weather, power_w);
        assert!(imbalance.abs() < 1e-10, "{imbalance}");
    }

    #[test]
    fn the_film_stands_above_the_silver_by_glue_and_ceramic() {
        let mut body = body();
        body.set_wind([0.0, 3.0, 0.0]);
        body.settle(|i, _| if i < HEMISPHERES { 0.02 } else { 0.01 });
        body.advance(0.01, |i, _| if i < HEMISPHERES { 0.02 } else { 0.01 });
        for i in 0..HEMISPHERES {
            let rise = body.element_temperature_c(i) - body.surface_temperature_c(i);
            assert!((rise - 0.02 * (1.0 / 0.1 + 1.0 / 8e-3)).abs() < 1e-8, "{rise}");
            // What is not given to the gas or radiated goes inside.
            let flows = body.flows();
            let overheat = body.surface_temperature_c(i) + ZERO_CELSIUS_K - 220.0;
            assert!((flows.convection_w[i] - body.conductance_w_k()[i] * overheat).abs() < 1e-10);
            let left = flows.convection_w[i] + flows.radiation_w[i] + flows.conduction_w[i];
            assert!((left - 0.02).abs() < 1e-9, "{left}");
        }
    }

    #[test]
    fn in_a_wind_from_the_side_both_halves_are_alike_and_head_on_the_front_is_colder() {
        let mut body = body();
        let mut ends = |wind| {
            body.set_wind(wind);
            body.settle(|_, _| 0.02);
            [0, 1].map(|i| body.surface_temperature_c(i))
        };
        let [one, other] = ends([0.0, 4.0, 1.0]);
        assert!((one - other).abs() < 1e-9, "{one} {other}");
        let [front, back] = ends([-4.0, 0.0, 0.0]);
        assert!(front < back - 1.0, "{front} {back}");
    }

    #[test]
    fn a_free_hemisphere_cools_with_the_time_constant_of_its_silver() {
        // 2 · 0.282 J/K over 1.28 mW/K at 1 m/s: 440 s; A has 1.2 times the silver of B.
        let mut body = body();
        body.set_wind([0.0, 1.0, 0.0]);
        let total: f64 = body.conductance_w_k().iter().sum();
        let time_constant_s = 2.0 * SPHERE_A.surface_capacity_j_k / total;
        assert!((400.0..480.0).contains(&time_constant_s), "{time_constant_s}");
    }
}
