//! Sphere A against calculations by hand.

use super::built_in;
use crate::sensor::body::ThermalBody;
use crate::sensor::body::testing::imbalance;
use anemometry::gas::{IdealGas, Species, ZERO_CELSIUS_K};

const HEMISPHERES: usize = 2;

fn mars() -> IdealGas {
    IdealGas::new(Species::CarbonDioxide, 700.0, 220.0).unwrap()
}

fn body() -> ThermalBody {
    built_in("sphere-a", &[]).body(&mars(), 230.0, 0).unwrap()
}

#[test]
fn heat_in_is_heat_out_and_heat_stored() {
    let wind = |phase: f64| [6.0 * libm::cos(phase), 3.0 * libm::sin(phase), 1.0];
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
        // The heat that is not given to the gas or radiated goes inside.
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
    let time_constant_s = 2.0 * 0.282 / total;
    assert!((400.0..480.0).contains(&time_constant_s), "{time_constant_s}");
}
