//! A head file: as it is written, checked by dr-core's own constructors as the board will check it,
//! and with another name or other values of the numbers that nobody has published.

use std::collections::BTreeMap;
use std::path::Path;

use dr_core::control::{GuardConfig, MOST_ELEMENTS};
use dr_core::sensor::Channel;
use recording::head_mounting::HeadMounting;
use recording::text::suggest;
use recording::toml_file::{FileError, TomlSource, exactly_if_any};
use serde::Deserialize;
use toml::Value;
use toml::de::DeTable;

use super::body::Body;
use super::body::checked::place;
use super::body::table::BodyTable;
use super::calibration::checked::Calibration;
use super::calibration::table::CalibrationTable;
use super::element::{ElementTable, HeadAdc, HeadElement, element};

/// A checked head.
#[derive(Debug, Clone, PartialEq)]
pub struct Head {
    /// Path and text of the file.
    pub source: TomlSource,
    /// Name of the head.
    pub name: String,
    /// Name of the project's sensor that simulates it.
    pub sensor: Option<String>,
    /// Body that simulates it in place of such a sensor; without either, only a real sensor can be
    /// run.
    pub body: Option<Body>,
    /// Compass direction in which its x axis points where it is mounted, degrees clockwise from
    /// north.
    pub heading_deg: Option<f64>,
    /// Direction that points up in its frame where it is mounted; by default the z axis.
    pub up: Option<[f64; 3]>,
    /// Voltage of one code, V.
    pub volt_per_code: f64,
    /// Voltage of the highest code, V.
    pub full_scale_v: f64,
    /// Voltage that the current sources can give, V.
    pub compliance_v: Option<f64>,
    /// When readings trip.
    pub guard: GuardTable,
    /// Its elements.
    pub elements: Vec<HeadElement>,
    /// Without it the head outputs no wind.
    pub calibration: Option<Calibration>,
}

impl Head {
    /// Reads a head file.
    ///
    /// # Errors
    /// The first key that is missing or cannot be used, with its line.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        Self::from_source(TomlSource::read(path)?)
    }

    /// The head in a text.
    ///
    /// # Errors
    /// As [`Head::read`].
    pub fn from_source(source: TomlSource) -> Result<Self, FileError> {
        let table: HeadTable = source.parse()?;
        HeadMounting::new(table.heading_deg.unwrap_or(0.0), table.up)
            .map_err(|error| source.refuse(error.key, error.sentence))?;
        let full_scale_v = source.positive("adc.full_scale_v", table.adc.full_scale_v, "V")?;
        source.within("adc.bits", f64::from(table.adc.bits), 8.0..=24.0, "bit")?;
        let half_range = f64::from(1_u32 << (table.adc.bits - 1));
        let adc = HeadAdc { volt_per_code: full_scale_v / half_range, code_max: half_range as i32 - 1 };
        if let Some(compliance_v) = table.adc.compliance_v {
            source.positive("adc.compliance_v", compliance_v, "V")?;
        }
        source.positive("guard.unreachable_limit_s", table.guard.unreachable_limit_s, "s")?;

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
        let mut elements: Vec<HeadElement> = Vec::new();
        for (index, own) in table.elements.iter().enumerate() {
            let element = element(&source, format!("elements[{index}]"), own, &table.kinds, &adc)?;
            if elements.iter().any(|before| before.name == element.name) {
                let sentence = format!("is `{}`, but another element has that name", element.name);
                return Err(source.refuse(&format!("elements[{index}].name"), sentence));
            }
            elements.push(element);
        }
        if let Some(sentence) = recording::shared_column(elements.iter().map(|element| element.name.as_str())) {
            return Err(source.refuse("elements", format!("do not fit: {sentence}")));
        }
        if table.sensor.is_some() && table.body.is_some() {
            let sentence =
                "is given besides [body]: a head is simulated by one of the project's sensors or by its own body";
            return Err(source.refuse("sensor", sentence));
        }
        let body = table.body.map(|body| Body::from_table(&source, &body, &elements)).transpose()?;
        let calibration =
            table.calibration.map(|table| Calibration::from_table(&source, table, &elements)).transpose()?;
        Ok(Self {
            name: table.name,
            sensor: table.sensor,
            heading_deg: table.heading_deg,
            up: table.up,
            body,
            volt_per_code: adc.volt_per_code,
            full_scale_v,
            compliance_v: table.adc.compliance_v,
            guard: table.guard,
            calibration,
            elements,
            source,
        })
    }

    /// Its frame on the earth; its x axis points north where no heading is given.
    pub fn mounting_or_north(&self) -> HeadMounting {
        // Both were found right when the file was read; an option that replaces them was, too.
        HeadMounting::new(self.heading_deg.unwrap_or(0.0), self.up).unwrap_or_default()
    }

    /// Kinds of its elements.
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

    /// Gives an element other levels than the file does, A; returns its place.
    ///
    /// # Errors
    /// If there is no such element, or dr-core refuses the currents.
    pub fn set_currents(&mut self, name: &str, low_a: f64, high_a: f64) -> Result<usize, CurrentsError> {
        let known = self.names();
        let Some(place) = known.iter().position(|own| *own == name) else {
            let hint = suggest(name, known.iter().copied());
            return Err(CurrentsError(format!("is no element of head `{}`; {hint}", self.name)));
        };
        let element = &mut self.elements[place];
        let platinum = *element.config.channel.platinum();
        element.config.channel = Channel::new(platinum, self.volt_per_code as f32, low_a as f32, high_a as f32)
            // Resistor and converter are the head's, and were found right when it was read.
            .map_err(|_| {
                CurrentsError(format!(
                    "is {{ low_a = {low_a}, high_a = {high_a} }}: high_a must be above low_a, and both above 0 and at most 1 A"
                ))
            })?;
        (element.nominal.current_low_a, element.nominal.current_high_a) = (low_a, high_a);
        Ok(place)
    }

    /// The guard's timeouts in ticks of a sample period.
    pub fn guard_config(&self, sample_period_s: f64) -> GuardConfig {
        let GuardTable { missing_limit_ticks, unreachable_limit_s, stuck_limit_ticks } = self.guard;
        let unreachable_limit_ticks =
            (unreachable_limit_s / sample_period_s).round().clamp(1.0, f64::from(u32::MAX)) as u32;
        GuardConfig { missing_limit_ticks, unreachable_limit_ticks, stuck_limit_ticks }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct HeadTable {
    pub name: String,
    pub sensor: Option<String>,
    pub heading_deg: Option<f64>,
    #[serde(default, deserialize_with = "exactly_if_any")]
    pub up: Option<[f64; 3]>,
    pub adc: AdcTable,
    pub guard: GuardTable,
    /// Any word may be a kind.
    #[serde(default)]
    pub kinds: BTreeMap<String, ElementTable>,
    #[serde(default)]
    pub elements: Vec<ElementTable>,
    pub body: Option<BodyTable>,
    pub calibration: Option<CalibrationTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AdcTable {
    pub full_scale_v: f64,
    pub bits: u8,
    pub compliance_v: Option<f64>,
}

/// When readings trip.
#[derive(Deserialize, Clone, Copy, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct GuardTable {
    /// Fresh readings that may be missing in a row.
    pub missing_limit_ticks: u32,
    /// Time for which a regulated element may request the high level only, s.
    pub unreachable_limit_s: f64,
    /// Equal readings in a row that trip; 0: never.
    #[serde(default)]
    pub stuck_limit_ticks: u32,
}

impl Head {
    /// The same head by another name, its file otherwise to the letter.
    ///
    /// # Errors
    /// If it cannot be read again.
    pub fn named(&self, name: &str) -> Result<Head, FileError> {
        let mut text = self.source.text.clone();
        let place = DeTable::parse(&text).ok().and_then(|of| Some(of.get_ref().get("name")?.span()));
        if let Some(place) = place {
            text.replace_range(place, &Value::from(name).to_string());
        }
        Head::from_source(TomlSource { path: self.source.path.clone(), text })
    }

    /// The same head with other values of its unknown numbers, in their order.
    ///
    /// # Errors
    /// If these make no head.
    pub fn with_unknown(&self, values: &[f64]) -> Result<Head, FileError> {
        let mut document: Value = self.source.parse()?;
        let unknown = self.body.iter().flat_map(|body| &body.unknown);
        for (number, value) in unknown.zip(values) {
            if let Some(place) = place(&mut document, &number.of) {
                *place = Value::Float(*value);
            }
        }
        // The file's own range holds for the file's own value only.
        if let Some(body) = document.get_mut("body").and_then(Value::as_table_mut) {
            body.remove("unknown");
        }
        let path = self.source.path.clone();
        let text = toml::to_string(&document);
        let text = text.map_err(|error| FileError { path: path.clone(), line: None, sentence: error.to_string() })?;
        Head::from_source(TomlSource { path, text })
    }
}

/// Currents that an element cannot have, or an element that the head does not have: the rest of a
/// sentence about the key.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct CurrentsError(pub(super) String);

#[cfg(test)]
mod tests {
    use dr_core::sensor::Level;

    use super::*;

    fn sphere_b() -> TomlSource {
        TomlSource::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../heads/sphere-b.toml")).unwrap()
    }

    fn refused(from: &str, to: &str) -> String {
        let mut source = sphere_b();
        assert!(source.text.contains(from), "{from}");
        source.text = source.text.replacen(from, to, 1);
        source.path = "b.toml".into();
        Head::from_source(source).unwrap_err().to_string()
    }

    #[test]
    fn another_name_changes_one_word_of_the_file() {
        let head = Head::from_source(sphere_b()).unwrap();
        let named = head.named("ball").unwrap();
        assert_eq!((head.name.as_str(), named.name.as_str()), ("sphere-b", "ball"));
        assert_eq!(named.source.text, head.source.text.replacen("\"sphere-b\"", "\"ball\"", 1));
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
        assert_eq!((head.sensor.as_deref(), head.body.as_ref().map(|body| body.nodes.len())), (None, Some(18)));
        assert_eq!(head.kinds(), ["core", "sector"]);
    }

    #[test]
    fn layers_are_an_elements_own_or_its_kinds_and_none_without_a_word() {
        let layers = |source: TomlSource| -> Vec<usize> {
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
    fn the_guards_timeouts_are_in_ticks_of_the_sample_period() {
        let head = Head::from_source(sphere_b()).unwrap();
        let ticks = |sample_period_s| head.guard_config(sample_period_s).unreachable_limit_ticks;
        assert_eq!(f64::from(ticks(0.01)), (head.guard.unreachable_limit_s * 100.0).round());
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

    #[test]
    fn a_platinum_characteristic_that_contradicts_itself_is_refused_with_its_line() {
        for (from, to, said) in [
            (", coefficient_per_c = 0.0031", "", "the key `coefficient_per_c` is missing"),
            ("\"linear\"", "\"iec60751\"", "unknown key `coefficient_per_c`"),
            ("\"linear\"", "\"linaer\"", "unknown choice `linaer`"),
        ] {
            let sentence = refused(from, to);
            assert!(sentence.starts_with("b.toml, line ") && sentence.contains(said), "{sentence}");
        }
    }
}
