//! What every kind of convection needs: the limit of a continuum, and a laminar plate.

use anemometry::gas::IdealGas;

use crate::sensor::error::SensorError;

const HIGHEST_KNUDSEN: f64 = 0.01;

/// Refuses a gas so thin that it is no continuum around a body of `length_m`.
pub(super) fn continuum(gas: &IdealGas, length_m: f64) -> Result<(), SensorError> {
    let knudsen = gas.knudsen(length_m);
    if knudsen > HIGHEST_KNUDSEN {
        let sentence = format!(
            "is {}: the gas is no continuum around the sensor (Knudsen number {knudsen:.3}, at most {HIGHEST_KNUDSEN}); \
             {:.0} Pa or more would be",
            gas.pressure_pa,
            gas.pressure_pa * knudsen / HIGHEST_KNUDSEN
        );
        return Err(SensorError::Number { key: "gas.pressure_pa".to_owned(), sentence });
    }
    Ok(())
}

/// Mean Nusselt number of a plate in a laminar layer (Pohlhausen): 0.664 Re^½ Pr^⅓.
pub(super) fn plate_nusselt(reynolds: f64, prandtl_third: f64) -> f64 {
    0.664 * reynolds.sqrt() * prandtl_third
}
