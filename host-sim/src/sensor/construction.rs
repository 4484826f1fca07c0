//! Bodies of a simulated sensor: those of a head file, its own or of one of the project's heads.
//! The elements of a head must be those of the sensor that simulates it.

use std::path::PathBuf;
use std::sync::Arc;

use anemometry::gas::{IdealGas, ZERO_CELSIUS_K};
use anemometry::head::Head;
use anemometry::head::body::{Body, BodyElement};
use recording::REFERENCE;
use recording::text::suggest;
use recording::toml_file::{FileError, TomlSource};

use super::assembly::assemble;
use super::body::ThermalBody;
use super::convection::validity;
use super::error::{SensorError, require};
use super::specimen;

/// The project's heads that a `sensor` may name.
const SPHERE_A: &str = include_str!("../../../heads/sphere-a.toml");
const SPHERE_B: &str = include_str!("../../../heads/sphere-b.toml");
const REMS: &str = include_str!("../../../heads/rems.toml");
/// A film in the stream beside a sphere.
const BESIDE: &str = include_str!("../../data/reference.toml");

/// A body with all of its numbers. [`Construction::named`] gives the sensors of the project.
#[derive(Clone, Debug, PartialEq)]
pub struct Construction {
    name: String,
    elements: Vec<BodyElement>,
    /// The body, and what is beside it.
    bodies: Arc<Vec<Body>>,
}

impl Construction {
    /// Names that a head file may give its `sensor`.
    pub const NAMES: [&str; 3] = ["sphere-a", "sphere-b", "rems"];

    /// A sensor of the project.
    pub fn named(name: &str) -> Option<Construction> {
        let texts = Self::NAMES.into_iter().zip([SPHERE_A, SPHERE_B, REMS]);
        let (_, text) = texts.into_iter().find(|(known, _)| *known == name)?;
        let mut construction = Self::of(&built_in(name, text))?;
        construction.name = name.to_owned();
        Some(construction)
    }

    /// The body of a head that has its own.
    pub fn of(head: &Head) -> Option<Construction> {
        let body = head.body.clone()?;
        let elements = head.elements.iter().map(|of| BodyElement { name: of.name.clone(), normal: of.normal });
        Some(Construction { name: head.name.clone(), elements: elements.collect(), bodies: Arc::new(vec![body]) })
    }

    /// The same with a reference beside it, where the project knows one.
    pub fn with_reference(&self) -> Option<Construction> {
        if !self.name.starts_with("sphere-") {
            return None;
        }
        let mut with = self.clone();
        Arc::make_mut(&mut with.bodies).extend(built_in(REFERENCE, BESIDE).body);
        with.elements.push(BodyElement { name: REFERENCE.to_owned(), normal: None });
        Some(with)
    }

    /// Its name in head files.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its elements, in the order of heater bits and codes.
    pub fn elements(&self) -> &[BodyElement] {
        &self.elements
    }

    /// Bodies that it is made of.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// Where its convection ends, as in "the wind was beyond …".
    pub fn validity(&self) -> &'static str {
        let first = self.bodies.iter().flat_map(|body| &body.convection).next();
        first.map_or("what is known of convection", |group| validity(&group.correlation))
    }

    /// The body in equilibrium with the gas, its rods between gas and support; the seed draws a
    /// specimen where there are tolerances.
    ///
    /// # Errors
    /// If the support has no temperature, or the gas is too thin.
    pub(super) fn body(&self, gas: &IdealGas, support_k: f64, seed: u64) -> Result<ThermalBody, SensorError> {
        possible(support_k)?;
        match specimen::drawn(&self.bodies, seed) {
            Some(drawn) => assemble(&drawn, gas, support_k),
            None => assemble(&self.bodies, gas, support_k),
        }
    }

    /// The same with the numbers of the file, whatever its tolerances.
    ///
    /// # Errors
    /// As [`body`](Self::body).
    pub(super) fn nominal_body(&self, gas: &IdealGas, support_k: f64) -> Result<ThermalBody, SensorError> {
        possible(support_k)?;
        assemble(&self.bodies, gas, support_k)
    }
}

fn possible(support_k: f64) -> Result<(), SensorError> {
    let is_possible = support_k.is_finite() && support_k > 0.0;
    require(is_possible, "support.temperature_c", support_k - ZERO_CELSIUS_K, "above -273.15")
}

/// A head file of the project; all of them are read by its tests.
fn built_in(name: &str, text: &str) -> Head {
    let path = PathBuf::from(format!("{name}.toml"));
    let head = Head::from_source(TomlSource { path, text: text.to_owned() });
    head.unwrap_or_else(|error| unreachable!("a head of the project: {error}"))
}

impl Default for Construction {
    fn default() -> Construction {
        Self::of(&built_in("sphere-b", SPHERE_B)).unwrap_or_else(|| unreachable!("sphere B has a body"))
    }
}

/// The sensor that simulates a head: its own body, or the sensor that it names; none where it has
/// neither.
///
/// # Errors
/// If there is no sensor of that name, or it has other elements.
pub fn construction_of(head: &Head) -> Result<Option<Construction>, FileError> {
    let (source, elements) = (&head.source, &head.elements);
    let Some(name) = head.sensor.as_deref() else { return Ok(Construction::of(head)) };
    let construction = Construction::named(name).ok_or_else(|| {
        let sentence = format!("is `{name}`, which cannot be simulated; {}", suggest(name, Construction::NAMES));
        source.refuse("sensor", sentence)
    })?;
    // One more than the sensor's own may measure the gas beside it.
    let own = construction.elements().len();
    let extended = construction.with_reference();
    let construction = match (elements.get(own), extended.clone()) {
        (Some(element), Some(extended)) if element.name == REFERENCE => extended,
        _ => construction,
    };
    let parts = construction.elements();
    let counts = format!("it has {} elements and the head {}", parts.len(), elements.len());
    for (i, part) in parts.iter().enumerate() {
        let Some(element) = elements.get(i) else {
            let sentence = format!("is `{name}`, but its element `{}` is missing here: {counts}", part.name);
            return Err(source.refuse("sensor", sentence));
        };
        if element.name != part.name {
            let sentence = format!("is `{}`, but element {} of `{name}` is `{}`", element.name, i + 1, part.name);
            return Err(source.refuse(&format!("elements[{i}].name"), sentence));
        }
        if let Some(sentence) = element.normal.and_then(|normal| other_normal(name, part, normal)) {
            return Err(source.refuse(&format!("elements[{i}].normal"), sentence));
        }
    }
    if let Some(surplus) = elements.get(parts.len()) {
        let more = if extended.is_some() && parts.len() == own { "; one more may be its `reference`" } else { "" };
        let sentence = format!("is `{}`, which `{name}` has not: {counts}{more}", surplus.name);
        return Err(source.refuse(&format!("elements[{}].name", parts.len()), sentence));
    }
    Ok(Some(construction))
}

/// Fault of the normal of an element, if it is not that of the sensor's.
fn other_normal(sensor: &str, part: &BodyElement, normal: [f64; 3]) -> Option<String> {
    match part.normal {
        Some(axis) if normal.iter().zip(axis).all(|(a, b)| (a - b).abs() < 1e-6) => None,
        Some(axis) => {
            Some(format!("turns `{}` towards {normal:.3?}, but in `{sensor}` it looks towards {axis:.3?}", part.name))
        }
        None if part.name == REFERENCE => {
            Some(format!("is given for `{}`, which is simulated as meeting every wind alike", part.name))
        }
        None => Some(format!("is given for `{}`, which lies inside `{sensor}`", part.name)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sensor_has_the_name_that_it_is_requested_by() {
        for name in Construction::NAMES {
            let construction = Construction::named(name).unwrap();
            assert_eq!(construction.name(), name);
            for normal in construction.elements().iter().filter_map(|part| part.normal) {
                assert!((normal.iter().map(|v| v * v).sum::<f64>() - 1.0).abs() < 1e-12);
            }
        }
        assert_eq!(Construction::named("sphere-c"), None);
        let count = |name| Construction::named(name).unwrap().elements().len();
        assert_eq!(["sphere-a", "sphere-b", "rems"].map(count), [4, 6, 13]);
        let beside = |name| {
            let with = Construction::named(name).unwrap().with_reference()?;
            Some((with.elements().len(), with.elements().last().unwrap().name.clone()))
        };
        let last = |count| Some((count, "reference".to_owned()));
        assert_eq!(["sphere-a", "sphere-b", "rems"].map(beside), [last(5), last(7), None]);
    }
}

#[cfg(test)]
mod matching_tests {
    use std::path::Path;

    use super::*;
    use recording::toml_file::TomlSource;

    fn file(name: &str) -> TomlSource {
        TomlSource::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../heads").join(name)).unwrap()
    }

    /// A user's head, which names a sensor of the project where that sensor's own file has a body.
    fn naming(name: &str) -> TomlSource {
        let mut source = file(&format!("{name}.toml"));
        if let Some((elements, _)) = source.text.split_once("# What simulates it") {
            let line = format!("name = \"{name}\"");
            source.text = elements.replacen(&line, &format!("{line}\nsensor = \"{name}\""), 1);
        }
        source
    }

    fn refused(name: &str, from: &str, to: &str) -> String {
        let mut source = naming(name);
        assert!(source.text.contains(from), "{from}");
        source.text = source.text.replacen(from, to, 1);
        source.path = "h.toml".into();
        construction_of(&Head::from_source(source).unwrap()).unwrap_err().to_string()
    }

    #[test]
    fn a_head_that_names_a_sensor_of_the_project_is_the_head_of_that_sensor() {
        for name in Construction::NAMES {
            let head = Head::from_source(naming(name)).unwrap();
            assert_eq!((head.sensor.as_deref(), &head.body), (Some(name), &None));
            let sensor = construction_of(&head).unwrap().unwrap();
            let own = Head::from_source(file(&format!("{name}.toml"))).unwrap();
            assert_eq!(construction_of(&own).unwrap(), Some(sensor.clone()));
            assert_eq!((sensor.name(), head.name.as_str()), (name, name));
            for (element, part) in head.elements.iter().zip(sensor.elements()) {
                assert_eq!(element.name, part.name);
                // Each head says where its outer elements look, as the powers of a real one are to
                // be told apart by it.
                assert_eq!(element.normal.is_some(), part.normal.is_some(), "{}", part.name);
            }
        }
    }

    #[test]
    fn a_sphere_may_have_a_reference_as_its_last_element() {
        for (name, count) in [("sphere-a", 5), ("sphere-b", 7)] {
            let head = Head::from_source(file(&format!("{name}-reference.toml"))).unwrap();
            let sensor = construction_of(&head).unwrap().unwrap();
            assert_eq!((sensor.name(), sensor.elements().len(), head.elements.len()), (name, count, count));
            assert_eq!(head.names().last(), Some(&"reference"));
            // The others are those of the head without it.
            let plain = Head::from_source(file(&format!("{name}.toml"))).unwrap();
            assert_eq!(head.elements[..count - 1], plain.elements);
        }
        let file = "sphere-b-reference";
        let sentence = refused(file, "name = \"reference\"", "name = \"gas\"");
        assert!(sentence.contains("`elements[6].name` is `gas`, which `sphere-b` has not"), "{sentence}");
        assert!(sentence.ends_with("; one more may be its `reference`"), "{sentence}");
        let sentence = refused(file, "name = \"reference\"", "name = \"reference\"\nnormal = [1.0, 0.0, 0.0]");
        assert!(
            sentence.contains("`elements[6].normal` is given for `reference`, which is simulated as"),
            "{sentence}"
        );
        let boom = "[[elements]]\nname = \"boom\"\nkind = \"boom\"";
        let sentence = refused("rems", boom, &format!("{boom}\n\n{}", boom.replacen("boom", "reference", 1)));
        assert!(
            sentence.contains("is `reference`, which `rems` has not: it has 13 elements and the head 14"),
            "{sentence}"
        );
        assert!(!sentence.contains("may be"), "{sentence}");
    }

    #[test]
    fn a_head_with_other_elements_than_its_sensor_is_told_which() {
        for (from, to, expected) in [
            (
                "sensor = \"sphere-b\"",
                "sensor = \"sphere-c\"",
                "`sensor` is `sphere-c`, which cannot be simulated; did you",
            ),
            (
                "sensor = \"sphere-b\"",
                "sensor = \"sphere-a\"",
                "`elements[0].name` is `sector1`, but element 1 of `sphere-a` is `hemisphere1`",
            ),
            (
                "name = \"core1\"",
                "name = \"core3\"",
                "`elements[4].name` is `core3`, but element 5 of `sphere-b` is `core1`",
            ),
            (
                "[[elements]]\nname = \"core2\"\nkind = \"core\"",
                "",
                "`sensor` is `sphere-b`, but its element `core2` is missing here: it has 6 elements and the head 5",
            ),
            (
                "[[elements]]\nname = \"core2\"",
                "[[elements]]\nname = \"core2\"\nkind = \"core\"\n\n[[elements]]\nname = \"core3\"",
                "`elements[6].name` is `core3`, which `sphere-b` has not: it has 6 elements and the head 7",
            ),
            (
                "normal = [1.0, -1.0, -1.0]",
                "normal = [1.0, -1.0, 1.0]",
                "`elements[1].normal` turns `sector2` towards [0.577, -0.577, 0.577], but in `sphere-b` it looks towards",
            ),
            (
                "name = \"core1\"",
                "name = \"core1\"\nnormal = [0.0, 0.0, 1.0]",
                "`elements[4].normal` is given for `core1`, which lies inside `sphere-b`",
            ),
        ] {
            let sentence = refused("sphere-b", from, to);
            assert!(sentence.starts_with("h.toml, line ") && sentence.contains(expected), "{to}: {sentence}");
            assert!(!sentence.contains('\n'));
        }
    }

    #[test]
    fn a_head_without_sensor_and_body_may_be_anything() {
        let mut source = naming("sphere-b");
        source.text = source.text.replace("sensor = \"sphere-b\"", "").replace("\"core2\"", "\"inside\"");
        let head = Head::from_source(source).unwrap();
        assert_eq!((construction_of(&head).unwrap(), head.names()[5]), (None, "inside"));
    }
}
