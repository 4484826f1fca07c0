//! Sensor heads: which elements there are, how they are wired and what is plausible for them.
//!
//! A head file is TOML. An element takes what it does not say itself from the table of its kind:
//!
//! | table | keys |
//! |---|---|
//! | top | `name`, optionally `sensor` ("sphere-a", "sphere-b" or "rems"): what simulates it |
//! | `[adc]` | `full_scale_v` (the code's end), `bits` (two's complement, 8 … 24) |
//! | `[guard]` | `missing_limit_ticks`, `unreachable_limit_s`, `stuck_limit_ticks` |
//! | `[kinds.…]` | defaults for the elements of that kind, which may be any word |
//! | `[[elements]]` | `name`, optionally `kind` and `normal` (outward), `platinum`, `current_low_a`, `current_high_a`, `resistance_min_ohm`, `resistance_max_ohm`, `temperature_max_c`, optionally `layers` (0 … 3, between element and surface) |
//! | `[calibration]` | optional, see [`calibration`] |
//!
//! One code is full_scale_v / 2^(bits−1) V. Elements of a simulated head are those of its sensor, by name and in order; a sphere's may be
//! followed by one more, `reference`. Numbers are checked by dr-core's own constructors, as the board will.

pub mod calibration;
mod matching;
mod setup;
mod table;

use std::collections::BTreeMap;
use std::path::Path;

use dr_core::ConfigError;
use dr_core::control::{ElementConfig, GuardConfig, Limits};
use dr_core::sensor::{Channel, Level, Platinum};

use crate::sensor::{self, Construction, PlatinumKind};
use crate::toml_file::{FileError, Source, suggest};
pub use calibration::{Answering, Calibration};
use table::{ElementTable, HeadTable};

/// Heaters of more elements would not fit the masks on the wire.
const MOST_ELEMENTS: usize = 16;
/// More layers than a record can tell apart.
const MOST_LAYERS: u8 = 3;

/// A checked head.
#[derive(Debug, Clone, PartialEq)]
pub struct Head {
    pub source: Source,
    pub name: String,
    /// What simulates it; without it, only a real sensor can be run.
    pub sensor: Option<Construction>,
    pub volt_per_code: f64,
    pub missing_limit_ticks: u32,
    pub unreachable_limit_s: f64,
    /// 0: never.
    pub stuck_limit_ticks: u32,
    pub elements: Vec<Element>,
    /// What it takes to answer with the wind.
    pub calibration: Option<Calibration>,
}

/// A checked element.
#[derive(Debug, Clone, PartialEq)]
pub struct Element {
    pub name: String,
    /// What it shares settings and models with.
    pub kind: Option<String>,
    /// Unit vector away from the sensor, for what looks into the wind.
    pub normal: Option<[f64; 3]>,
    /// Layers between it and the surface of the sensor, each of some capacity and a resistance towards the next; 0 where it is the surface.
    pub layers: usize,
    /// Calibration and currents in f64, as the simulation wants them.
    pub nominal: sensor::ElementConfig,
    /// The same for the controller, with the limits.
    pub config: ElementConfig,
}

impl Head {
    pub fn read(path: &Path) -> Result<Self, FileError> {
        Self::from_source(Source::read(path)?)
    }

    pub fn from_source(source: Source) -> Result<Self, FileError> {
        let table: HeadTable = source.parse()?;
        let full_scale_v = source.positive("adc.full_scale_v", table.adc.full_scale_v, "V")?;
        source.within("adc.bits", f64::from(table.adc.bits), 8.0..=24.0, "bit")?;
        let half_range = f64::from(1_u32 << (table.adc.bits - 1));
        let adc = Adc { volt_per_code: full_scale_v / half_range, code_max: half_range as i32 - 1 };
        let unreachable_limit_s = source.positive("guard.unreachable_limit_s", table.guard.unreachable_limit_s, "s")?;

        if table.elements.is_empty() || table.elements.len() > MOST_ELEMENTS {
            let count = table.elements.len();
            return Err(source.refuse("elements", format!("are {count}: a head has 1 to {MOST_ELEMENTS}")));
        }
        for (kind, shared) in &table.kinds {
            if shared.name.is_some() || shared.kind.is_some() || shared.normal.is_some() {
                return Err(source.refuse(
                    &format!("kinds.{kind}"),
                    "cannot give `name`, `kind` or `normal`: they belong to one element",
                ));
            }
        }
        let mut elements: Vec<Element> = Vec::new();
        for (index, own) in table.elements.iter().enumerate() {
            let element = element(&source, format!("elements[{index}]"), own, &table.kinds, &adc)?;
            if elements.iter().any(|before| before.name == element.name) {
                let sentence = format!("is `{}`, but another element has that name", element.name);
                return Err(source.refuse(&format!("elements[{index}].name"), sentence));
            }
            elements.push(element);
        }
        let sensor = table.sensor.map(|name| matching::sensor(&source, &name, &elements)).transpose()?;
        let calibration =
            table.calibration.map(|table| Calibration::from_table(&source, table, &elements)).transpose()?;
        Ok(Self {
            name: table.name,
            sensor,
            volt_per_code: adc.volt_per_code,
            missing_limit_ticks: table.guard.missing_limit_ticks,
            unreachable_limit_s,
            stuck_limit_ticks: table.guard.stuck_limit_ticks.unwrap_or(0),
            calibration,
            elements,
            source,
        })
    }

    /// The kinds that its elements are of.
    pub fn kinds(&self) -> Vec<&str> {
        let mut kinds: Vec<_> = self.elements.iter().filter_map(|element| element.kind.as_deref()).collect();
        kinds.sort_unstable();
        kinds.dedup();
        kinds
    }

    /// Names of the elements, in the head's order.
    pub fn names(&self) -> Vec<&str> {
        self.elements.iter().map(|element| element.name.as_str()).collect()
    }

    /// Gives an element other levels than the file does, A.
    ///
    /// # Errors
    /// A sentence: no such element, or currents that dr-core refuses.
    pub fn set_currents(&mut self, name: &str, low_a: f64, high_a: f64) -> Result<usize, String> {
        let known = self.names();
        let Some(place) = known.iter().position(|own| *own == name) else {
            return Err(format!("is no element of head `{}`; {}", self.name, suggest(name, known.iter().copied())));
        };
        let element = &mut self.elements[place];
        let platinum = *element.config.channel.platinum();
        element.config.channel = Channel::new(platinum, self.volt_per_code as f32, low_a as f32, high_a as f32)
            // Resistor and converter are the head's, and were found right when it was read.
            .map_err(|_| {
                format!(
                    "is {{ low_a = {low_a}, high_a = {high_a} }}: high_a must be above low_a, and both above 0 and at most 1 A"
                )
            })?;
        (element.nominal.current_low_a, element.nominal.current_high_a) = (low_a, high_a);
        Ok(place)
    }

    /// The guard's patience in ticks of a sample period.
    pub fn guard_config(&self, sample_period_s: f64) -> GuardConfig {
        let unreachable_limit_ticks =
            (self.unreachable_limit_s / sample_period_s).round().clamp(1.0, f64::from(u32::MAX)) as u32;
        GuardConfig {
            missing_limit_ticks: self.missing_limit_ticks,
            unreachable_limit_ticks,
            stuck_limit_ticks: self.stuck_limit_ticks,
        }
    }
}

impl Element {
    /// Heating power in W at a temperature in °C with the current at a level: I²R.
    pub fn power_w(&self, temperature_c: f64, level: Level) -> f64 {
        let channel = &self.config.channel;
        f64::from(channel.power_w(channel.platinum().resistance_ohm(temperature_c as f32), level))
    }
}

struct Adc {
    volt_per_code: f64,
    code_max: i32,
}

/// The keys of an element: its own where it has them, its kind's otherwise; and where each of them stands, for errors.
struct Keys<'a> {
    source: &'a Source,
    key: String,
    own: &'a ElementTable,
    /// The kind's key and table.
    shared: Option<(String, &'a ElementTable)>,
}

impl<'a> Keys<'a> {
    fn get<T>(&self, name: &str, of: impl Fn(&'a ElementTable) -> &'a Option<T>) -> Result<(&'a T, String), FileError> {
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

    fn number(&self, name: &str, of: impl Fn(&'a ElementTable) -> &'a Option<f64>) -> Result<f64, FileError> {
        let (&number, key) = self.get(name, of)?;
        if number.is_finite() {
            Ok(number)
        } else {
            Err(self.source.refuse(&key, format!("is {number}: it must be finite")))
        }
    }

    fn layers(&self) -> Result<usize, FileError> {
        let kind = self.shared.as_ref().and_then(|(_, shared)| shared.layers);
        if self.own.layers.or(kind).is_none() {
            return Ok(0);
        }
        let (&layers, key) = self.get("layers", |table| &table.layers)?;
        if layers > MOST_LAYERS {
            return Err(self
                .source
                .refuse(&key, format!("is {layers}: between an element and its surface are 0 to {MOST_LAYERS}")));
        }
        Ok(usize::from(layers))
    }

    /// The error of dr-core for one of this element's numbers.
    fn refuse(&self, key: &str, error: &ConfigError) -> FileError {
        self.source
            .refuse(key, format!("of {} cannot be used: {error}", self.own.name.as_deref().unwrap_or("an element")))
    }

    fn refuse_named(&self, error: &ConfigError) -> FileError {
        let name = error.parameter.name();
        let own = match name {
            "current_low_a" => self.own.current_low_a.is_some(),
            "current_high_a" => self.own.current_high_a.is_some(),
            "resistance_min_ohm" => self.own.resistance_min_ohm.is_some(),
            "resistance_max_ohm" => self.own.resistance_max_ohm.is_some(),
            _ => self.own.temperature_max_c.is_some(),
        };
        let key = self.shared.as_ref().filter(|_| !own).map_or(&self.key, |(kind_key, _)| kind_key);
        self.refuse(&format!("{key}.{name}"), error)
    }
}

fn element(
    source: &Source,
    key: String,
    own: &ElementTable,
    kinds: &BTreeMap<String, ElementTable>,
    adc: &Adc,
) -> Result<Element, FileError> {
    let name = own.name.clone().ok_or_else(|| source.refuse(&key, "has no `name`"))?;
    if name.is_empty() || name.contains([':', ',', '"']) || name.contains(char::is_whitespace) {
        let sentence = format!(
            "is {name:?}: it becomes part of column names, so a word without `:`, `,` and quotation marks belongs here"
        );
        return Err(source.refuse(&format!("{key}.name"), sentence));
    }
    let shared = match &own.kind {
        None => None,
        Some(kind) => {
            let table = kinds.get(kind).ok_or_else(|| {
                let hint = suggest(kind, kinds.keys().map(String::as_str));
                source.refuse(&format!("{key}.kind"), format!("is `{kind}`, but there is no [kinds.{kind}]; {hint}"))
            })?;
            Some((format!("kinds.{kind}"), table))
        }
    };
    let normal = normal(source, &key, own.normal)?;
    let keys = Keys { source, key, own, shared };

    let (platinum, platinum_key) = keys.get("platinum", |table| &table.platinum)?;
    let platinum_kind = platinum.kind().map_err(|sentence| source.refuse(&platinum_key, sentence))?;
    let current_low_a = keys.number("current_low_a", |table| &table.current_low_a)?;
    let current_high_a = keys.number("current_high_a", |table| &table.current_high_a)?;
    let limits = Limits {
        resistance_min_ohm: keys.number("resistance_min_ohm", |table| &table.resistance_min_ohm)? as f32,
        resistance_max_ohm: keys.number("resistance_max_ohm", |table| &table.resistance_max_ohm)? as f32,
        temperature_max_c: keys.number("temperature_max_c", |table| &table.temperature_max_c)? as f32,
        code_max: adc.code_max,
    };
    let layers = keys.layers()?;
    let platinum = characteristic(platinum_kind).map_err(|error| keys.refuse(&platinum_key, &error))?;
    let channel = Channel::new(platinum, adc.volt_per_code as f32, current_low_a as f32, current_high_a as f32)
        .map_err(|error| keys.refuse_named(&error))?;
    let limits = limits.checked(channel.platinum()).map_err(|error| keys.refuse_named(&error))?;
    Ok(Element {
        name,
        kind: own.kind.clone(),
        normal,
        layers,
        nominal: sensor::ElementConfig { platinum: platinum_kind, current_low_a, current_high_a },
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

fn normal(source: &Source, key: &str, normal: Option<[f64; 3]>) -> Result<Option<[f64; 3]>, FileError> {
    let key = format!("{key}.normal");
    let Some(normal) = normal else { return Ok(None) };
    let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
    if !(length.is_finite() && length > 1e-9) {
        return Err(source.refuse(&key, "is no direction: three finite numbers that are not all 0 belong here"));
    }
    Ok(Some(normal.map(|x| x / length)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sphere_b() -> Source {
        Source::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../heads/sphere-b.toml")).unwrap()
    }

    fn refused(from: &str, to: &str) -> String {
        let mut source = sphere_b();
        assert!(source.text.contains(from), "{from}");
        source.text = source.text.replacen(from, to, 1);
        source.path = "b.toml".into();
        Head::from_source(source).unwrap_err().to_string()
    }

    #[test]
    fn sphere_b_is_read_with_the_numbers_of_the_prototype() {
        let head = Head::from_source(sphere_b()).unwrap();
        assert_eq!(head.names(), ["sector1", "sector2", "sector3", "sector4", "core1", "core2"]);
        assert_eq!(head.volt_per_code, 4.0 / 8_388_608.0);
        let sector = &head.elements[1];
        // R = 175 (1 + 0.0031 T), I²R at 3 and 16 mA: by hand.
        assert!((sector.power_w(-23.15, Level::High) - 0.0415849).abs() < 1e-7);
        assert!((sector.power_w(-23.15, Level::Low) - 0.0014620).abs() < 1e-7);
        assert_eq!(sector.config.limits.code_max, 8_388_607);
        let third = 1.0 / 3.0_f64.sqrt();
        for (x, expected) in sector.normal.unwrap().into_iter().zip([third, -third, -third]) {
            assert!((x - expected).abs() < 1e-15);
        }
        assert_eq!(head.elements[4].kind.as_deref(), Some("core"));
        assert_eq!(head.sensor, Some(Construction::default()));
        assert_eq!(head.kinds(), ["core", "sector"]);
    }

    #[test]
    fn layers_are_an_elements_own_or_its_kinds_and_none_without_a_word() {
        let layers = |source: Source| -> Vec<usize> {
            Head::from_source(source).unwrap().elements.iter().map(|element| element.layers).collect()
        };
        assert_eq!(layers(sphere_b()), [1, 1, 1, 1, 0, 0]);
        let mut other = sphere_b();
        other.text = other.text.replace("name = \"sector2\"", "name = \"sector2\"\nlayers = 3");
        assert_eq!(layers(other), [1, 3, 1, 1, 0, 0]);
        let sentence = refused("layers = 1", "layers = 4");
        assert!(
            sentence.contains("`kinds.sector.layers` is 4: between an element and its surface are 0 to 3"),
            "{sentence}"
        );
    }

    #[test]
    fn sector_normals_add_up_to_nothing() {
        let head = Head::from_source(sphere_b()).unwrap();
        for axis in 0..3 {
            let sum: f64 = head.elements.iter().filter_map(|element| element.normal).map(|normal| normal[axis]).sum();
            assert!(sum.abs() < 1e-15);
        }
    }

    #[test]
    fn the_guards_patience_is_in_ticks_of_the_sample_period() {
        let head = Head::from_source(sphere_b()).unwrap();
        let ticks = |sample_period_s| head.guard_config(sample_period_s).unreachable_limit_ticks;
        assert_eq!(f64::from(ticks(0.01)), (head.unreachable_limit_s * 100.0).round());
        assert_eq!(ticks(0.001), ticks(0.01) * 10);
    }

    #[test]
    fn a_head_that_cannot_be_is_refused_with_key_and_line() {
        let sentence = refused("current_low_a = 0.003", "current_low_a = 0.030");
        assert!(
            sentence.starts_with("b.toml, line ") && sentence.contains("`kinds.sector.current_high_a` of sector1"),
            "{sentence}"
        );
        assert!(refused("bits = 24", "bits = 32").contains("`adc.bits` is 32 bit: it must lie between 8 and 24 bit"));
        assert!(
            refused("current_low_a = 0.003 ", "#")
                .contains("has no `current_low_a`: give it there or in [kinds.sector]")
        );
        assert!(refused("full_scale_v = 4.0", "full_scale_v = nan").contains("`adc.full_scale_v` is NaN V"));
        assert!(refused("name = \"sector2\"", "name = \"sector1\"").contains("another element has that name"));
        assert!(refused("name = \"sector2\"", "name = \"a:b\"").contains("becomes part of column names"));
        assert!(refused("kind = \"core\"", "kind = \"kore\"").contains("did you mean `core`?"));
        assert!(
            refused("temperature_max_c = 70.0", "temperature_maxc = 70.0")
                .contains("did you mean `temperature_max_c`?")
        );
    }
}
