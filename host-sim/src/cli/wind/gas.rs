//! What the anemometer is told of the gas, and by whom.

use serde_json::{Value, json};

use super::Arguments;
use crate::answer::moment::Moment;
use crate::answer::off_line::OffLine;
use crate::answer::replay::Replay;
use crate::cli::Failure;
use crate::head::{Calibration, Head};
use crate::model::{SAME_PRESSURE, SAME_TEMPERATURE_K};
use crate::recording::{GAS_TEMPERATURE, Metadata};

/// Where the temperature comes from.
#[derive(Debug, Clone, PartialEq)]
enum Temperature {
    /// Held for the whole recording, °C.
    Told(f64),
    /// A column, tick by tick.
    Column(String),
    /// An element of the head.
    Element(String),
}

pub(super) struct GasTold {
    species: &'static str,
    pressure_pa: f64,
    temperature: Temperature,
    last: Option<f32>,
    begun: bool,
    /// Where an option says something else than the recording.
    pub warnings: Vec<String>,
}

impl GasTold {
    pub fn new(
        arguments: &Arguments,
        head: &Head,
        calibration: &Calibration,
        replay: &Replay,
    ) -> Result<Self, Failure> {
        let conditions = replay.conditions();
        let species = calibration.species.name();
        if let Some(of) = conditions.filter(|of| of.species != species) {
            return Err(Failure::usage(format!(
                "{}: was taken in {}, but head `{}` is calibrated for {species}: another gas is another calibration",
                arguments.recording.display(),
                of.species,
                head.name
            )));
        }
        let pressure_pa = arguments.pressure.or(conditions.map(|of| of.pressure_pa)).ok_or_else(|| {
            Failure::usage("the recording does not tell the pressure of its gas: give --pressure, in Pa")
        })?;
        let told = arguments.gas_temperature.as_deref();
        let temperature = match (calibration.reference, told) {
            (Some(_), Some(_)) => {
                return Err(Failure::usage(
                    "--gas-temperature is given, but this head measures the gas by its reference: leave one of them out",
                ));
            }
            (Some(element), None) => Temperature::Element(head.elements[element].name.clone()),
            (None, Some(word)) => match word.parse() {
                Ok(celsius) => Temperature::Told(celsius),
                Err(_) => Temperature::Column(word.to_owned()),
            },
            (None, None) => match conditions {
                Some(of) => Temperature::Told(of.gas_temperature_c),
                None => {
                    return Err(Failure::usage(
                        "nothing tells the temperature of the gas: give --gas-temperature, a number in °C or a column",
                    ));
                }
            },
        };
        let mut warnings = Vec::new();
        if let Some(of) = conditions {
            if (pressure_pa / of.pressure_pa - 1.0).abs() > SAME_PRESSURE {
                warnings.push(format!("--pressure is {pressure_pa} Pa, but the recording says {} Pa", of.pressure_pa));
            }
            if let Temperature::Told(celsius) = temperature
                && (celsius - of.gas_temperature_c).abs() > SAME_TEMPERATURE_K
            {
                warnings.push(format!(
                    "--gas-temperature is {celsius} °C, but the recording says {} °C",
                    of.gas_temperature_c
                ));
            }
        }
        Ok(Self { species, pressure_pa, temperature, last: None, begun: false, warnings })
    }

    /// Before the tick: whenever it has changed.
    pub fn tell(&mut self, anemometer: &mut OffLine<'_>, moment: &Moment) -> Result<(), Failure> {
        let now = match &self.temperature {
            Temperature::Told(celsius) => Some(*celsius as f32),
            Temperature::Column(_) => moment.gas_c.map(|celsius| celsius as f32),
            Temperature::Element(_) => None,
        };
        if self.begun && now == self.last {
            return Ok(());
        }
        (self.begun, self.last) = (true, now);
        anemometer.gas(self.pressure_pa as f32, now).map_err(|error| Failure::usage(format!("gas: {error}")))
    }

    pub fn metadata(&self) -> Metadata {
        let (key, value) = match &self.temperature {
            Temperature::Told(celsius) => (GAS_TEMPERATURE, celsius.to_string()),
            Temperature::Column(name) => ("gas_temperature_from", name.clone()),
            Temperature::Element(name) => ("gas_temperature_from", format!("element {name}")),
        };
        let pairs =
            [("gas_species", self.species.to_owned()), ("gas_pressure_pa", self.pressure_pa.to_string()), (key, value)];
        pairs.map(|(key, value)| (key.to_owned(), value)).into()
    }

    pub fn json(&self) -> Value {
        let (celsius, from) = match &self.temperature {
            Temperature::Told(celsius) => (Some(*celsius), None),
            Temperature::Column(name) => (None, Some(name.clone())),
            Temperature::Element(name) => (None, Some(format!("element {name}"))),
        };
        json!({
            "species": self.species, "pressure_pa": self.pressure_pa,
            "temperature_c": celsius, "temperature_from": from,
        })
    }
}

impl std::fmt::Display for GasTold {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} of {} Pa, ", self.species, self.pressure_pa)?;
        match &self.temperature {
            Temperature::Told(celsius) => write!(f, "{celsius} °C"),
            Temperature::Column(name) => write!(f, "its temperature from column `{name}`"),
            Temperature::Element(name) => write!(f, "its temperature by element `{name}`"),
        }
    }
}
