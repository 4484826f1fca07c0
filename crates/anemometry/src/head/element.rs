//! An element of a head, one platinum resistor that heats and senses, with its data sheet in f64.

use std::collections::BTreeMap;

use dr_core::ConfigError;
use dr_core::control::{ElementConfig, EnergyLimit, Limits};
use dr_core::sensor::{Channel, Level, Platinum};
use recording::text::suggest;
use recording::toml_file::{FileError, TomlSource, exactly_if_any};
use serde::Deserialize;

use crate::vector::length;

/// More layers than a record can tell apart.
const MOST_LAYERS: u8 = 3;

/// An element, or what the elements of a kind share.
#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct ElementTable {
    pub name: Option<String>,
    pub kind: Option<String>,
    #[serde(default, deserialize_with = "exactly_if_any")]
    pub normal: Option<[f64; 3]>,
    pub platinum: Option<PlatinumKind>,
    pub current_low_a: Option<f64>,
    pub current_high_a: Option<f64>,
    pub current_high_nominal_a: Option<f64>,
    pub resistance_min_ohm: Option<f64>,
    pub resistance_max_ohm: Option<f64>,
    pub temperature_max_c: Option<f64>,
    pub sustained_power_w: Option<f64>,
    pub energy_j: Option<f64>,
    pub layers: Option<u8>,
    pub only_senses: Option<bool>,
}

/// A checked element.
#[derive(Debug, Clone, PartialEq)]
pub struct HeadElement {
    /// Name, as in columns.
    pub name: String,
    /// Elements of one kind share settings and models.
    pub kind: Option<String>,
    /// Unit vector away from the sensor, for a surface in the wind.
    pub normal: Option<[f64; 3]>,
    /// Layers between it and the surface of the sensor, each of some capacity and a resistance
    /// towards the next; 0 where it is the surface.
    pub layers: usize,
    /// It is never driven: a thermocouple, or the reading that stands for one. It has a `normal`
    /// only to be simulated.
    pub only_senses: bool,
    /// Resistor and currents in f64, for the simulation.
    pub nominal: NominalElement,
    /// The same for the controller, with the limits.
    pub config: ElementConfig,
}

impl HeadElement {
    /// The outward direction of a surface that the wind cools, and that a calibration is of.
    pub fn surface_normal(&self) -> Option<[f64; 3]> {
        self.normal.filter(|_| !self.only_senses)
    }

    /// Tells whether a head may drive it: it neither only senses nor measures the gas.
    pub fn may_be_driven(&self) -> bool {
        !self.only_senses && self.name != recording::REFERENCE
    }

    /// Tells whether it is such a surface.
    pub fn is_surface(&self) -> bool {
        self.surface_normal().is_some()
    }

    /// Slope of its resistance around a temperature, Ω/K.
    pub fn ohm_per_k(&self, temperature_c: f64) -> f64 {
        let resistance_ohm = |celsius: f64| f64::from(self.config.channel.platinum().resistance_ohm(celsius as f32));
        resistance_ohm(temperature_c + 0.5) - resistance_ohm(temperature_c - 0.5)
    }

    /// Heating power in W at a temperature in °C with the current at a level: I²R.
    pub fn power_w(&self, temperature_c: f64, level: Level) -> f64 {
        f64::from(self.config.channel.power_at_w(temperature_c as f32, level))
    }
}

pub(super) struct HeadAdc {
    pub volt_per_code: f64,
    pub code_max: i32,
}

/// Keys of an element, its own before those of its kind, with the place of each in the file for
/// errors.
struct ElementKeys<'a> {
    source: &'a TomlSource,
    key: String,
    own: &'a ElementTable,
    /// The kind's key and table.
    shared: Option<(String, &'a ElementTable)>,
}

impl ElementKeys<'_> {
    fn get<T>(&self, name: &str, of: impl Fn(&ElementTable) -> Option<T>) -> Result<(T, String), FileError> {
        if let Some(value) = of(self.own) {
            return Ok((value, format!("{}.{name}", self.key)));
        }
        let Some((kind_key, shared)) = &self.shared else {
            return Err(self.source.refuse(&self.key, format!("has no `{name}`, and no `kind` that could give it")));
        };
        match of(shared) {
            Some(value) => Ok((value, format!("{kind_key}.{name}"))),
            None => Err(self.source.refuse(&self.key, format!("has no `{name}`: give it there or in [{kind_key}]"))),
        }
    }

    fn number(&self, name: &str, of: impl Fn(&ElementTable) -> Option<f64>) -> Result<f64, FileError> {
        let (number, key) = self.get(name, of)?;
        if !number.is_finite() {
            return Err(self.source.refuse(&key, format!("is {number}: it must be finite")));
        }
        Ok(number)
    }

    fn layers(&self) -> Result<usize, FileError> {
        // Neither the element nor its kind has to give any.
        let Ok((layers, key)) = self.get("layers", |table| table.layers) else { return Ok(0) };
        if layers > MOST_LAYERS {
            let sentence = format!("is {layers}: between an element and its surface are 0 to {MOST_LAYERS}");
            return Err(self.source.refuse(&key, sentence));
        }
        Ok(usize::from(layers))
    }

    fn only_senses(&self) -> bool {
        self.get("only_senses", |table| table.only_senses).is_ok_and(|(only, _)| only)
    }

    /// Energy that the element bears, if it or its kind says so.
    fn energy(&self) -> Result<Option<EnergyLimit>, FileError> {
        let power_w = || self.number("sustained_power_w", |table| table.sustained_power_w);
        if self.get("energy_j", |table| table.energy_j.or(table.sustained_power_w)).is_err() {
            return Ok(None);
        }
        let energy_j = || self.number("energy_j", |table| table.energy_j);
        Ok(Some(EnergyLimit { sustained_power_w: power_w()? as f32, energy_j: energy_j()? as f32 }))
    }

    /// The error of dr-core for one of this element's numbers.
    fn refuse(&self, key: &str, error: &ConfigError) -> FileError {
        let name = self.own.name.as_deref().unwrap_or("an element");
        self.source.refuse(key, format!("of {name} cannot be used: {error}"))
    }

    fn refuse_named(&self, error: &ConfigError) -> FileError {
        let (name, own) = (error.parameter.name(), self.own);
        let own = match name {
            "current_low_a" => own.current_low_a,
            "current_high_a" => own.current_high_a,
            "resistance_min_ohm" => own.resistance_min_ohm,
            "resistance_max_ohm" => own.resistance_max_ohm,
            "sustained_power_w" => own.sustained_power_w,
            "energy_j" => own.energy_j,
            _ => own.temperature_max_c,
        };
        let key = self.shared.as_ref().filter(|_| own.is_none()).map_or(&self.key, |(kind_key, _)| kind_key);
        self.refuse(&format!("{key}.{name}"), error)
    }
}

pub(super) fn element(
    source: &TomlSource,
    key: String,
    own: &ElementTable,
    kinds: &BTreeMap<String, ElementTable>,
    adc: &HeadAdc,
) -> Result<HeadElement, FileError> {
    let name = own.name.clone().ok_or_else(|| source.refuse(&key, "has no `name`"))?;
    if name.is_empty() || name.contains([':', ',', '"']) || name.contains(char::is_whitespace) {
        let sentence = format!(
            "is {name:?}: it becomes part of column names, so a word without `:`, `,` and quotation marks belongs here"
        );
        return Err(source.refuse(&format!("{key}.name"), sentence));
    }
    let shared = own.kind.as_ref().map(|kind| match kinds.get(kind) {
        Some(table) => Ok((format!("kinds.{kind}"), table)),
        None => {
            let hint = suggest(kind, kinds.keys().map(String::as_str));
            let sentence = format!("is `{kind}`, but there is no [kinds.{kind}]; {hint}");
            Err(source.refuse(&format!("{key}.kind"), sentence))
        }
    });
    let shared = shared.transpose()?;
    let normal = own.normal.map(|normal| direction(source, &format!("{key}.normal"), normal)).transpose()?;
    let keys = ElementKeys { source, key, own, shared };

    let (platinum_kind, platinum_key) = keys.get("platinum", |table| table.platinum)?;
    let current_low_a = keys.number("current_low_a", |table| table.current_low_a)?;
    let current_high_a = keys.number("current_high_a", |table| table.current_high_a)?;
    let nominal_high_a = match keys.get("current_high_nominal_a", |table| table.current_high_nominal_a) {
        Ok((nominal_a, key)) => source.positive(&key, nominal_a, "A")?,
        // A value that was not measured is the one that it was made for.
        Err(_) => current_high_a,
    };
    let limits = Limits {
        resistance_min_ohm: keys.number("resistance_min_ohm", |table| table.resistance_min_ohm)? as f32,
        resistance_max_ohm: keys.number("resistance_max_ohm", |table| table.resistance_max_ohm)? as f32,
        temperature_max_c: keys.number("temperature_max_c", |table| table.temperature_max_c)? as f32,
        code_max: adc.code_max,
        energy: keys.energy()?,
    };
    let (layers, only_senses) = (keys.layers()?, keys.only_senses());
    let platinum = characteristic(platinum_kind).map_err(|error| keys.refuse(&platinum_key, &error))?;
    let channel = Channel::new(platinum, adc.volt_per_code as f32, current_low_a as f32, current_high_a as f32)
        .map_err(|error| keys.refuse_named(&error))?;
    let limits = limits.checked(channel.platinum()).map_err(|error| keys.refuse_named(&error))?;
    Ok(HeadElement {
        name,
        kind: own.kind.clone(),
        normal,
        layers,
        only_senses,
        nominal: NominalElement { platinum: platinum_kind, current_low_a, current_high_a: nominal_high_a },
        config: ElementConfig { channel, limits },
    })
}

fn characteristic(kind: PlatinumKind) -> Result<Platinum, ConfigError> {
    match kind {
        PlatinumKind::Linear { resistance_0c_ohm, coefficient_per_c } => {
            Platinum::linear(resistance_0c_ohm as f32, coefficient_per_c as f32)
        }
        PlatinumKind::Iec60751 { resistance_0c_ohm } => Platinum::iec60751(resistance_0c_ohm as f32),
    }
}

/// The unit vector along one that is long enough to have a direction.
pub(super) fn direction(source: &TomlSource, key: &str, vector: [f64; 3]) -> Result<[f64; 3], FileError> {
    let length = length(vector);
    if !(length.is_finite() && length > 1e-9) {
        return Err(source.refuse(key, "is no direction: three finite numbers that are not all 0 belong here"));
    }
    Ok(vector.map(|x| x / length))
}

/// Nominal characteristic of a platinum resistor, as a head file has it.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(tag = "characteristic", rename_all = "lowercase", deny_unknown_fields)]
pub enum PlatinumKind {
    /// R = R0 (1 + αT).
    Linear {
        /// R0, Ω.
        resistance_0c_ohm: f64,
        /// α, 1/°C.
        coefficient_per_c: f64,
    },
    /// IEC 60751, whose coefficients are fixed.
    Iec60751 {
        /// R0, Ω.
        resistance_0c_ohm: f64,
    },
}

/// Nominal values of one element and its two currents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NominalElement {
    /// Resistor.
    pub platinum: PlatinumKind,
    /// Low level, A.
    pub current_low_a: f64,
    /// High level as it was made, A; the controller's may be measured.
    pub current_high_a: f64,
}
