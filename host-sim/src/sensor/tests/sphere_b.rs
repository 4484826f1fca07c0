//! Sphere B against calculations by hand.

use std::f64::consts::PI;

use super::built_in;
use crate::sensor::body::testing::imbalance;
use crate::sensor::body::{STEFAN_BOLTZMANN, ThermalBody};
use anemometry::gas::{IdealGas, Species, ZERO_CELSIUS_K};

const SECTORS: usize = 4;

fn mars() -> IdealGas {
    IdealGas::new(Species::CarbonDioxide, 700.0, 220.0).unwrap()
}

fn body() -> ThermalBody {
    built_in("sphere-b", &[]).body(&mars(), 230.0, 0).unwrap()
}

#[test]
fn heat_in_is_heat_out_and_heat_stored() {
    let wind = |phase: f64| [6.0 * libm::cos(phase), 3.0 * libm::sin(phase), 1.0];
    let power_w = |i, high| if high { 0.04 } else { 0.001 * i as f64 };
    let weather = |body: &mut ThermalBody, phase| body.set_wind(wind(phase));
    let imbalance = imbalance(&mut body(), (100_000, 0.01), weather, power_w);
    assert!(imbalance.abs() < 1e-10, "{imbalance}");
}

#[test]
fn heat_in_is_heat_out_and_heat_stored_in_a_swinging_gas_and_with_a_reference() {
    let construction = built_in("sphere-b", &[]).with_reference().unwrap();
    let mut body = construction.body(&mars(), 230.0, 0).unwrap();
    let weather = |body: &mut ThermalBody, phase: f64| {
        body.set_gas_temperature_k(220.0 + 15.0 * libm::sin(0.3 * phase));
        body.set_wind([6.0 * libm::cos(phase), 3.0 * libm::sin(phase), 1.0]);
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
    let mut body = built_in("sphere-b", &[("emissivity = 0.03", "emissivity = 0.0")]).body(&mars(), 230.0, 0).unwrap();
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
    let time_constant_s = 4.0 * 0.118 / total;
    assert!((340.0..=400.0).contains(&time_constant_s), "{time_constant_s}");
}
