//! Functions that several kinds of convection need: the limit of a continuum, laminar layers, free
//! convection, and both together.

use anemometry::gas::IdealGas;
use anemometry::vector::{dot, unit};

use crate::sensor::error::SensorError;

/// Highest Knudsen number of a continuum.
pub(super) const HIGHEST_KNUDSEN: f64 = 0.01;

/// Refuses a gas so thin that its Knudsen number around a body of `length_m` is above `highest`.
pub(super) fn at_most(gas: &IdealGas, length_m: f64, highest: f64) -> Result<(), SensorError> {
    let knudsen = gas.knudsen(length_m);
    if knudsen > highest {
        let sentence = format!(
            "is {}: the gas is no continuum around the sensor (Knudsen number {knudsen:.3}, at most {highest}); \
             {:.0} Pa or more would be",
            gas.pressure_pa,
            gas.pressure_pa * knudsen / highest
        );
        return Err(SensorError::Number { key: "gas.pressure_pa".to_owned(), sentence });
    }
    Ok(())
}

/// Refuses a gas so thin that it is no continuum around a body of `length_m`.
pub(super) fn continuum(gas: &IdealGas, length_m: f64) -> Result<(), SensorError> {
    at_most(gas, length_m, HIGHEST_KNUDSEN)
}

/// Mean Nusselt number of a plate in a laminar layer (Pohlhausen): 0.664 Re^½ Pr^⅓.
pub(super) fn plate_nusselt(reynolds: f64, prandtl_third: f64) -> f64 {
    0.664 * reynolds.sqrt() * prandtl_third
}

/// Factor of √Re in [`cylinder_nusselt`]: 0.62 Pr^⅓ / (1 + (0.4/Pr)^⅔)^¼.
pub(super) fn cylinder_factor(prandtl: f64) -> f64 {
    0.62 * libm::cbrt(prandtl) / libm::pow(1.0 + libm::pow(0.4 / prandtl, 2.0 / 3.0), 0.25)
}

/// Mean Nusselt number of a cylinder in crossflow (Churchill and Bernstein 1977), for Re·Pr > 0.2.
pub(super) fn cylinder_nusselt(reynolds: f64, factor: f64) -> f64 {
    0.3 + factor * reynolds.sqrt() * libm::pow(1.0 + libm::pow(reynolds / 282_000.0, 0.625), 0.8)
}

/// Rayleigh number of a body of `length_m` that is `overheat_k` warmer than the gas.
pub(super) fn rayleigh(gas: &IdealGas, length_m: f64, overheat_k: f64, gravity_m_s2: f64) -> f64 {
    let viscosity_m2_s = gas.viscosity_pa_s / gas.density_kg_m3;
    gravity_m_s2 / gas.temperature_k * overheat_k * length_m.powi(3) * gas.prandtl() / viscosity_m2_s.powi(2)
}

/// Free convection of an upright plate, laminar (Churchill and Chu 1975).
pub(super) fn free_plate_nusselt(rayleigh: f64, prandtl: f64) -> f64 {
    0.68 + 0.670 * libm::pow(rayleigh, 0.25) / laminar(0.492, prandtl)
}

/// Free convection of a horizontal cylinder, laminar (Churchill and Chu 1975).
pub(super) fn free_cylinder_nusselt(rayleigh: f64, prandtl: f64) -> f64 {
    0.36 + 0.518 * libm::pow(rayleigh, 0.25) / laminar(0.559, prandtl)
}

fn laminar(constant: f64, prandtl: f64) -> f64 {
    libm::pow(1.0 + libm::pow(constant / prandtl, 9.0 / 16.0), 4.0 / 9.0)
}

/// Free and forced convection together (Churchill's blend, exponent 4 of a stream across).
pub(super) fn joined(still: f64, forced: f64) -> f64 {
    (still.powi(4) + forced.powi(4)).sqrt().sqrt()
}

/// Speed that a wire or cylinder sees, m/s: across it, and a share of that along it,
/// U² = U_across² + k² U_along².
pub(super) fn effective_speed_m_s(wind_m_s: [f64; 3], axis: [f64; 3], yaw_factor: f64) -> f64 {
    let along_m_s = dot(wind_m_s, unit(axis));
    let across2 = (dot(wind_m_s, wind_m_s) - along_m_s * along_m_s).max(0.0);
    (across2 + (yaw_factor * along_m_s).powi(2)).sqrt()
}

/// Temperature between a surface and the gas, held to where gases are known.
pub(super) fn film_gas(gas: &IdealGas, surface_k: f64) -> IdealGas {
    gas.at(film_k(gas, surface_k).clamp(*KNOWN_K.start(), *KNOWN_K.end()))
}

/// Tells whether that temperature is beyond where gases are known.
pub(super) fn film_extrapolated(gas: &IdealGas, surface_k: f64) -> bool {
    !KNOWN_K.contains(&film_k(gas, surface_k))
}

fn film_k(gas: &IdealGas, surface_k: f64) -> f64 {
    0.5 * (gas.temperature_k + surface_k)
}

const KNOWN_K: std::ops::RangeInclusive<f64> = anemometry::gas::TEMPERATURE_RANGE_K;
