//! Pressure and temperature of the gas for an anemometer, from the recording, from options, or from
//! the head itself.

use std::fmt;
use std::path::Path;

use diffusive::model::{SAME_PRESSURE, SAME_TEMPERATURE_K};
use recording::{GAS_TEMPERATURE, Metadata};
use serde::ser::{Serialize, SerializeMap, Serializer};

use super::gas_uncertainty::GasUncertainty;
use super::moment::Moment;
use super::off_line::GasInputError;
use super::replay::Replay;

use crate::gas::{GasError, ZERO_CELSIUS_K, check_pressure, check_temperature};
use crate::head::calibration::checked::Calibration;
use crate::head::file::Head;

/// Source of the temperature.
#[derive(Debug, Clone, PartialEq)]
enum TemperatureSource {
    /// Constant for the whole recording, °C.
    Constant(f64),
    /// A column, tick by tick.
    Column(String),
    /// An element of the head.
    Element(String),
}

/// The gas of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct GasInput {
    species: &'static str,
    pressure_pa: f64,
    temperature: TemperatureSource,
    /// Uncertainty that an option says.
    uncertainty: GasUncertainty,
    last: Option<f32>,
    has_begun: bool,
    /// Where an option contradicts the recording.
    pub warnings: Vec<String>,
}

/// The column that an option of the gas temperature names; none if it is a number in °C.
pub fn temperature_column(option: Option<&str>) -> Option<&str> {
    option.filter(|word| word.parse::<f64>().is_err())
}

impl GasInput {
    /// `pressure_pa` and `temperature` (°C or a column) are options that stand before the
    /// recording's own.
    ///
    /// # Errors
    /// If a number is missing or no gas has it, or the head is calibrated for another gas.
    pub fn new(
        (pressure_pa, temperature): (Option<f64>, Option<&str>),
        uncertainty: GasUncertainty,
        head: &Head,
        calibration: &Calibration,
        recording: &Path,
        replay: &Replay,
    ) -> Result<Self, GasInputError> {
        let refuse = |sentence: &str| Err(GasInputError(sentence.to_owned()));
        let conditions = replay.conditions.as_ref();
        let species = calibration.table.species.name();
        if let Some(of) = conditions.filter(|of| of.species != species) {
            let taken = format!("{}: was taken in {}", recording.display(), of.species);
            let calibrated = format!("but head `{}` is calibrated for {species}", head.name);
            return refuse(&format!("{taken}, {calibrated}: another gas is another calibration"));
        }
        let in_words = |error: GasError| {
            let is_option = error.name.starts_with("--");
            GasInputError(if is_option { error.to_string() } else { format!("{}: {error}", recording.display()) })
        };
        let (key, pressure_pa) = match (pressure_pa, conditions) {
            (Some(pressure_pa), _) => ("--pressure", pressure_pa),
            (None, Some(of)) => ("gas_pressure_pa", of.pressure_pa),
            (None, None) => {
                return refuse("the recording does not tell the pressure of its gas: give --pressure, in Pa");
            }
        };
        check_pressure(key, pressure_pa).map_err(in_words)?;
        let constant = |key: &'static str, celsius: f64| {
            check_temperature(key, celsius + ZERO_CELSIUS_K).map_err(in_words)?;
            Ok(TemperatureSource::Constant(celsius))
        };
        let temperature = match (calibration.reference, temperature, conditions) {
            (Some(_), Some(_), _) => {
                return refuse(
                    "--gas-temperature is given, but this head measures the gas by its reference: leave one of them out",
                );
            }
            (Some(element), None, _) => TemperatureSource::Element(head.elements[element].name.clone()),
            (None, Some(word), _) => match word.parse() {
                Ok(celsius) => constant("--gas-temperature", celsius)?,
                Err(_) => TemperatureSource::Column(word.to_owned()),
            },
            (None, None, Some(of)) => constant("gas_temperature_c", of.gas_temperature_c)?,
            (None, None, None) => {
                return refuse(
                    "nothing tells the temperature of the gas: give --gas-temperature, a number in °C or a column",
                );
            }
        };
        let mut warnings = Vec::new();
        if let Some(of) = conditions {
            if (pressure_pa / of.pressure_pa - 1.0).abs() > SAME_PRESSURE {
                warnings.push(format!("--pressure is {pressure_pa} Pa, but the recording says {} Pa", of.pressure_pa));
            }
            if let TemperatureSource::Constant(celsius) = temperature
                && (celsius - of.gas_temperature_c).abs() > SAME_TEMPERATURE_K
            {
                let is_c = of.gas_temperature_c;
                warnings.push(format!("--gas-temperature is {celsius} °C, but the recording says {is_c} °C"));
            }
        }
        Ok(Self { species, pressure_pa, temperature, uncertainty, last: None, has_begun: false, warnings })
    }

    /// Pressure, Pa, and temperature, °C, where no element measures it, if they have changed since
    /// the last tick.
    pub fn changed(&mut self, moment: &Moment) -> Option<(f32, Option<f32>)> {
        let now = match &self.temperature {
            TemperatureSource::Constant(celsius) => Some(*celsius as f32),
            TemperatureSource::Column(_) => moment.gas_c.map(|celsius| celsius as f32),
            TemperatureSource::Element(_) => None,
        };
        let is_as_before = self.has_begun && now == self.last;
        (self.has_begun, self.last) = (true, now);
        (!is_as_before).then_some((self.pressure_pa as f32, now))
    }

    /// Its pressure, Pa.
    pub fn pressure_pa(&self) -> f64 {
        self.pressure_pa
    }

    /// Metadata of a file of wind estimates.
    pub fn metadata(&self) -> Metadata {
        let (key, value) = match self.constant_c() {
            Some(celsius) => (GAS_TEMPERATURE, celsius.to_string()),
            None => ("gas_temperature_from", self.from().unwrap_or_default()),
        };
        let pairs =
            [("gas_species", self.species.to_owned()), ("gas_pressure_pa", self.pressure_pa.to_string()), (key, value)];
        let GasUncertainty { pressure_pa, temperature_k } = self.uncertainty;
        let uncertain =
            [("gas_pressure_uncertainty_pa", pressure_pa), ("gas_temperature_uncertainty_k", temperature_k)];
        let uncertain = uncertain.into_iter().filter_map(|(key, value)| Some((key, value?.to_string())));
        pairs.into_iter().chain(uncertain).map(|(key, value)| (key.to_owned(), value)).collect()
    }

    /// Its temperature, where it is one number, °C.
    pub fn constant_c(&self) -> Option<f64> {
        if let TemperatureSource::Constant(celsius) = self.temperature { Some(celsius) } else { None }
    }

    fn from(&self) -> Option<String> {
        match &self.temperature {
            TemperatureSource::Constant(_) => None,
            TemperatureSource::Column(name) => Some(name.clone()),
            TemperatureSource::Element(name) => Some(format!("element {name}")),
        }
    }
}

impl Serialize for GasInput {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("species", self.species)?;
        map.serialize_entry("pressure_pa", &self.pressure_pa)?;
        map.serialize_entry("pressure_uncertainty_pa", &self.uncertainty.pressure_pa)?;
        map.serialize_entry("temperature_c", &self.constant_c())?;
        map.serialize_entry("temperature_uncertainty_k", &self.uncertainty.temperature_k)?;
        map.serialize_entry("temperature_from", &self.from())?;
        map.end()
    }
}

impl fmt::Display for GasInput {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let GasUncertainty { pressure_pa, temperature_k } = self.uncertainty;
        let with = |uncertainty: Option<f64>| uncertainty.map_or_else(String::new, |of| format!(" ± {of}"));
        write!(f, "{} of {}{} Pa, ", self.species, self.pressure_pa, with(pressure_pa))?;
        let kelvin = temperature_k.map_or_else(String::new, |of| format!(" ± {of} K"));
        match &self.temperature {
            TemperatureSource::Constant(celsius) => write!(f, "{celsius}{} °C", with(temperature_k)),
            TemperatureSource::Column(name) => write!(f, "its temperature from column `{name}`{kelvin}"),
            TemperatureSource::Element(name) => write!(f, "its temperature by element `{name}`{kelvin}"),
        }
    }
}
