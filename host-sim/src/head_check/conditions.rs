//! What a head is judged in.

use anemometry::gas::{GasError, IdealGas, Species, ZERO_CELSIUS_K};
use anemometry::head::Head;
use recording::toml_file::FileError;
use serde::Serialize;

use crate::sensor::{BodySurvey, Construction};

/// Gas, overheat, sample period and noise.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct HeadConditions {
    /// Which gas.
    pub species: Species,
    /// Its pressure, Pa.
    pub pressure_pa: f64,
    /// Its temperature and that of the support, °C.
    pub temperature_c: f64,
    /// Elements over the gas, K.
    pub overheat_k: f64,
    /// A bit an element, s.
    pub sample_period_s: f64,
    /// Of a reading, V rms.
    pub noise_v_rms: f64,
}

/// What a command is given of these.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct GivenConditions {
    /// Which gas.
    pub species: Option<Species>,
    /// Its pressure, Pa.
    pub pressure_pa: Option<f64>,
    /// Its temperature, °C.
    pub temperature_c: Option<f64>,
}

impl HeadConditions {
    /// What is not given is that of the head's file, or air of 20 °C and one atmosphere; noise is a
    /// code of the converter.
    pub fn of(head: &Head, gas: Option<anemometry::head::body::table::BodyGas>, given: GivenConditions) -> Self {
        Self {
            species: given.species.or(gas.map(|gas| gas.species)).unwrap_or(Species::Air),
            pressure_pa: given.pressure_pa.or(gas.map(|gas| gas.pressure_pa)).unwrap_or(101_325.0),
            temperature_c: given.temperature_c.or(gas.map(|gas| gas.temperature_c)).unwrap_or(20.0),
            overheat_k: 30.0,
            sample_period_s: 0.01,
            noise_v_rms: head.volt_per_code,
        }
    }

    /// The gas.
    ///
    /// # Errors
    /// If it is not known at that pressure or temperature.
    pub fn gas(&self) -> Result<IdealGas, GasError> {
        IdealGas::new(self.species, self.pressure_pa, self.temperature_c + ZERO_CELSIUS_K)
    }

    /// The body of a head in this gas, on a support of its temperature.
    ///
    /// # Errors
    /// If the gas is none that the head can be simulated in.
    pub fn survey(&self, head: &Head, construction: &Construction) -> Result<BodySurvey, FileError> {
        let refuse = |error: String| head.source.refuse("body", format!("cannot be surveyed: {error}"));
        let gas = self.gas().map_err(|error| refuse(error.to_string()))?;
        BodySurvey::new(construction, &head.elements, &gas, self.temperature_c)
            .map_err(|error| refuse(error.to_string()))
    }

    /// What elements are held at, °C.
    pub fn set_point_c(&self) -> f64 {
        self.temperature_c + self.overheat_k
    }
}
