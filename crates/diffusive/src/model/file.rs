//! Reading and writing a model's JSON: checked in full, written whole or not at all.

use std::path::Path;

use super::ModelError;
use super::content::{FORMAT, Model, VERSION};
use recording::Temporary;
use recording::text::one_line;

/// Beyond it, squares and products of a model's numbers are no longer numbers.
const GREATEST: f64 = 1e100;

impl Model {
    /// Reads a model's file and checks it.
    ///
    /// # Errors
    /// If there is none, or what it holds is no model.
    pub fn read(path: &Path) -> Result<Self, ModelError> {
        let text = recording::regular::read_text(path).map_err(|error| match error.kind() {
            std::io::ErrorKind::NotFound => model_error!("there is no such file"),
            std::io::ErrorKind::InvalidData => model_error!(
                "is no text: a model (.json, from `anemo identify`) belongs here, and comes before a recording"
            ),
            _ => model_error!("cannot be read: {error}"),
        });
        text.and_then(|text| Self::from_json(&text)).map_err(|error| error.about(path.display()))
    }

    /// Reads a model from a text and checks it.
    ///
    /// # Errors
    /// The key and what would be right.
    pub fn from_json(text: &str) -> Result<Self, ModelError> {
        // Some editors put a byte order mark before a text that they save.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let value: serde_json::Value = serde_json::from_str(text)
            .map_err(|error| model_error!("is no JSON, or cut short: {}", one_line(error.to_string())))?;
        refuse_if!(
            value.get("format").and_then(serde_json::Value::as_str) != Some(FORMAT),
            model_error!("is no model: its key `format` is not \"{FORMAT}\"; `anemo identify` writes models")
        );
        match value.get("version").and_then(serde_json::Value::as_u64) {
            Some(version) if version == u64::from(VERSION) => {}
            Some(version) => {
                return Err(model_error!(
                    "is a model of version {version}, and this anemo reads version {VERSION}: identify it again, or use the anemo that wrote it"
                ));
            }
            None => return Err(model_error!("has no `version`: identify it again")),
        }
        if let Some(key) = too_large(&value) {
            return Err(model_error!("`{}` is a number too large to compute with", one_line(key)));
        }
        let model: Self = serde_json::from_value(value)
            .map_err(|error| model_error!("is not a whole model: {}", one_line(error.to_string())))?;
        model.check()?;
        Ok(model)
    }

    /// The text of its file.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("a model holds nothing that JSON does not")
    }

    /// Writes its file, in whole or not at all.
    pub fn write(&self, path: &Path) -> Result<(), ModelError> {
        let text = format!("{}\n", self.to_json());
        let failed = |error| model_error!("{}: cannot be written: {error}", path.display());
        Temporary::write(path, text.as_bytes()).map_err(failed)
    }
}

/// The key of a number whose products are none any more, or that f64 does not hold, such as 1e999.
fn too_large(value: &serde_json::Value) -> Option<String> {
    use serde_json::Value;
    let below = |key: String, value| {
        let rest = too_large(value)?;
        Some(if rest.is_empty() || rest.starts_with('[') { key + &rest } else { format!("{key}.{rest}") })
    };
    match value {
        Value::Number(number) => {
            let good = number.as_f64().is_some_and(|number| number.abs() <= GREATEST);
            (!good).then(String::new)
        }
        Value::Array(items) => items.iter().enumerate().find_map(|(at, item)| below(format!("[{at}]"), item)),
        Value::Object(keys) => keys.iter().find_map(|(key, item)| below(key.clone(), item)),
        Value::Null | Value::Bool(_) | Value::String(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::super::content::{Following, ModelGas};
    use super::super::testing;
    use super::*;

    fn model() -> Model {
        let mut model = testing::model(&[0.5], &[10.0]);
        testing::add_wind(&mut model, "gust", 0.2);
        testing::follow_gas(&mut model, 18.0);
        model
    }

    #[test]
    fn a_model_that_follows_its_gas_is_read_as_it_was_written() {
        assert_eq!(Model::from_json(&model().to_json()).unwrap(), model());
    }

    #[test]
    fn what_does_not_fit_the_gas_is_refused_by_its_key() {
        let refused = |change: &dyn Fn(&mut Following)| {
            let mut model = model();
            change(model.wind.as_mut().unwrap().following.as_mut().unwrap());
            Model::from_json(&model.to_json()).unwrap_err().to_string()
        };
        for (sentence, key) in [
            (refused(&|following| following.mesh_rad_s[0] = 0.0), "`mesh_rad_s` must hold ascending"),
            (refused(&|following| following.outputs.clear()), "`outputs` has 0 entries for the model's 1"),
            (refused(&|following| following.outputs[0].f_k_per_k.clear()), "one value for each of the 1 rates"),
            (refused(&|following| following.from_c = 30.0), "`from_c` is 30, which is not within `range_c`, 17 to 19"),
        ] {
            assert!(sentence.starts_with("`wind.following`") && sentence.contains(key), "{sentence}");
        }
        let mut constant = model();
        constant.wind.as_mut().unwrap().gas = ModelGas::ConstantC(18.0);
        assert!(Model::from_json(&constant.to_json()).unwrap_err().to_string().contains("needs the gas as a column"));
    }
}
