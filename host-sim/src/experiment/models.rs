//! Self-heating of the elements under an experiment's conditions: what its set-points are judged
//! by.
//!
//! A model belongs to gas, pressure and whatever else surrounds an element, and so to an experiment
//! rather than to a head. The file:
//!
//! | table | keys |
//! |---|---|
//! | top | `conditions`: for which gas the models hold, in words |
//! | `[kinds.…]` | the model of every element of that kind |
//! | `[elements.NAME]` | the model of one element, in place of its kind's |
//!
//! Each model is `reference_c`, and `mesh_rad_s` and `r_k_per_w` of 8 each. An element without one
//! is not judged.

use std::collections::BTreeMap;
use std::path::Path;

use dr_core::ConfigError;
use dr_core::model::{ORDER, SelfHeating, SelfHeatingConfig};
use serde::Deserialize;

use anemometry::head::Head;
use recording::text::suggest;
use recording::toml_file::{FileError, TomlSource};

/// The period does not matter for what is checked here.
const ANY_PERIOD_S: f32 = 0.01;

/// Checked models.
#[derive(Debug, Clone, PartialEq)]
pub struct Models {
    /// The file, which errors name.
    pub source: TomlSource,
    /// For which gas they hold.
    pub conditions: String,
    /// One an element of the head, in its order.
    pub elements: Vec<Option<SelfHeatingConfig>>,
}

impl Models {
    /// Reads a file of models for the elements of a head.
    ///
    /// # Errors
    /// File, line and what is wrong.
    pub fn read(path: &Path, head: &Head) -> Result<Self, FileError> {
        Self::from_source(TomlSource::read(path)?, head)
    }

    /// Checks models for the elements of a head.
    ///
    /// # Errors
    /// File, line and what is wrong.
    pub fn from_source(source: TomlSource, head: &Head) -> Result<Self, FileError> {
        let table: ModelsTable = source.parse()?;
        // A drive that is made from a model names elements as its columns do.
        let is_of = |name: &str, element: &str| recording::in_columns(name) == recording::in_columns(element);
        let refuse = |what: &str, unknown: &str, known: Vec<&str>| {
            let sentence = format!("is no {what} of head `{}`; {}", head.name, suggest(unknown, known));
            Err(source.refuse(&format!("{what}s.{unknown}"), sentence))
        };
        let known = head.names();
        if let Some(unknown) = table.elements.keys().find(|name| !known.iter().any(|known| is_of(name, known))) {
            return refuse("element", unknown, known);
        }
        let known = head.kinds();
        if let Some(unknown) = table.kinds.keys().find(|kind| !known.contains(&kind.as_str())) {
            return refuse("kind", unknown, known);
        }
        let checked = |(kind, table): (&String, &ModelTable)| {
            table.checked(&source, &format!("kinds.{kind}")).map(|model| (kind.clone(), model))
        };
        let kinds: BTreeMap<_, _> = table.kinds.iter().map(checked).collect::<Result<_, _>>()?;
        let of_element = |element: &anemometry::head::HeadElement| match table
            .elements
            .iter()
            .find(|(name, _)| is_of(name, &element.name))
        {
            Some((name, own)) => own.checked(&source, &format!("elements.{name}")).map(Some),
            None => Ok(element.kind.as_ref().and_then(|kind| kinds.get(kind)).copied()),
        };
        let elements = head.elements.iter().map(of_element).collect::<Result<_, _>>()?;
        Ok(Self { conditions: table.conditions, elements, source })
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ModelsTable {
    conditions: String,
    #[serde(default)]
    kinds: BTreeMap<String, ModelTable>,
    #[serde(default)]
    elements: BTreeMap<String, ModelTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ModelTable {
    reference_c: f64,
    mesh_rad_s: [f64; ORDER],
    r_k_per_w: [f64; ORDER],
}

impl ModelTable {
    fn checked(&self, source: &TomlSource, key: &str) -> Result<SelfHeatingConfig, FileError> {
        let config = SelfHeatingConfig {
            mesh_rad_s: self.mesh_rad_s.map(|rate| rate as f32),
            r_k_per_w: self.r_k_per_w.map(|resistance| resistance as f32),
            reference_c: self.reference_c as f32,
        };
        let refused = |error: ConfigError| {
            let named = match error.parameter.name() {
                "rate_rad_s" => "mesh_rad_s",
                name => name,
            };
            let error = error.to_string();
            let (_, wanted) = error.split_once("` ").unwrap_or(("", &error));
            let each = if named == "reference_c" { "" } else { "holds a number that cannot be used: each " };
            source.refuse(&format!("{key}.{named}"), format!("{each}{wanted}"))
        };
        SelfHeating::new(&config, ANY_PERIOD_S).map_err(refused)?;
        Ok(config)
    }
}

#[cfg(test)]
mod tests {
    use diffusive::model::reduce::board;
    use diffusive::model::testing;

    use super::*;

    fn path(name: &str) -> std::path::PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../heads").join(name)
    }

    fn with(from: &str, to: &str) -> Result<Models, String> {
        let mut source = TomlSource::read(&path("models/sphere-b-mars-still.toml")).unwrap();
        assert!(source.text.contains(from), "{from}");
        source = TomlSource { path: "m.toml".into(), text: source.text.replacen(from, to, 1) };
        Models::from_source(source, &Head::read(&path("sphere-b.toml")).unwrap()).map_err(|error| error.to_string())
    }

    #[test]
    fn elements_have_the_model_of_their_kind_unless_they_have_their_own() {
        let models = with("", "").unwrap();
        let [sector, .., core] = models.elements[..] else { panic!("six elements") };
        let (sector, core) = (sector.unwrap(), core.unwrap());
        assert_eq!((sector.reference_c, core.reference_c), (-44.83, -43.11));
        assert_eq!((sector.mesh_rad_s[7], core.r_k_per_w[0]), (105.0, 274.5));
        assert!(models.elements[..4].iter().all(|model| *model == Some(sector)));

        let own = "[elements.sector2]\nreference_c = -40.0\nmesh_rad_s = [1, 2, 3, 4, 5, 6, 7, 8]\nr_k_per_w = [1, 1, 1, 1, 1, 1, 1, 1]\n\n[kinds.core]";
        let models = with("[kinds.core]", own).unwrap();
        let references = models.elements.iter().map(|model| model.unwrap().reference_c);
        assert_eq!(references.collect::<Vec<_>>(), [-44.83, -40.0, -44.83, -44.83, -43.11, -43.11]);
    }

    #[test]
    fn an_element_without_a_model_has_none() {
        let models = with("[kinds.core]", "[elements.core1]").unwrap();
        assert!(models.elements[4].is_some() && models.elements[5].is_none());
    }

    #[test]
    fn what_cannot_be_a_model_is_refused_with_line_and_key() {
        for (from, to, expected) in [
            (
                "r_k_per_w = [587.1,",
                "r_k_per_v = [587.1,",
                "m.toml, line 13: unknown key `r_k_per_v`; did you mean `r_k_per_w`?",
            ),
            (
                "[kinds.core]",
                "[kinds.kore]",
                "line 15: `kinds.kore` is no kind of head `sphere-b`; did you mean `core`?",
            ),
            (
                "[kinds.core]",
                "[elements.core3]",
                "line 15: `elements.core3` is no element of head `sphere-b`; did you mean `core",
            ),
            ("conditions = ", "condition = ", "line 8: unknown key `condition`; did you mean `conditions`?"),
            (
                "0.0024, 0.004, 0.01,",
                "0.0024, 0.004, 0.004,",
                "line 12: `kinds.sector.mesh_rad_s` holds a number that cannot be used: each must be greater than the value before it",
            ),
            ("0.0024, 0.004, 0.01,", "0.0024, 0.004,", "line 12: `mesh_rad_s`: invalid length 7"),
            (
                "274.5",
                "nan",
                "line 18: `kinds.core.r_k_per_w` holds a number that cannot be used: each must be a finite number",
            ),
            ("reference_c = -43.11", "reference_c = inf", "line 16: `kinds.core.reference_c` must be a finite number"),
            ("reference_c = -43.11\n", "", "line 15: the key `reference_c` is missing"),
        ] {
            let sentence = with(from, to).unwrap_err();
            assert!(sentence.contains(expected), "{to}: {sentence}");
            assert!(!sentence.contains('\n'));
        }
    }

    #[test]
    fn the_table_of_a_reduced_model_is_read() {
        let mut model = testing::model(&[0.0025, 0.01, 105.0], &[587.1, 89.4, 0.4]);
        model.inputs[0] = "power_w_sector2".to_owned();
        model.outputs[0].name = "temperature_c_sector2".to_owned();
        model.pairs[0].input.clone_from(&model.inputs[0]);
        model.pairs[0].output.clone_from(&model.outputs[0].name);
        model.provenance.records = vec!["a \"fine\" record.csv".to_owned()];
        let head = Head::read(&path("sphere-b.toml")).unwrap();
        let text = board::toml(&model, "all").unwrap();
        let read = Models::from_source(TomlSource { path: "m.toml".into(), text }, &head).unwrap();
        let second = read.elements[1].unwrap();
        assert_eq!(second.reference_c, 20.0);
        assert_eq!(second.mesh_rad_s, [0.0025, 0.01, 105.0, 210.0, 420.0, 840.0, 1680.0, 3360.0]);
        assert_eq!(second.r_k_per_w, [587.1, 89.4, 0.4, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(read.elements.iter().flatten().count(), 1);
    }
}
