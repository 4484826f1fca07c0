//! Reading and writing a model's JSON: checked in full, written whole or not at all.

use std::path::{Path, PathBuf};

use super::{Following, Gas, Model, Structure};
use crate::recording::{Temporary, one_line};

/// Counts changes that an older reader would misunderstand.
pub const VERSION: u32 = 1;

pub const FORMAT: &str = "anemo-model";

#[derive(Debug, thiserror::Error)]
pub enum ModelError {
    #[error("{}: there is no such file", .0.display())]
    Missing(PathBuf),
    #[error("{}: cannot be {doing}: {reason}", path.display())]
    Io { path: PathBuf, doing: &'static str, reason: String },
    #[error("{}: {sentence}", path.display())]
    Content { path: PathBuf, sentence: String },
}

impl Model {
    pub fn read(path: &Path) -> Result<Self, ModelError> {
        let text = std::fs::read_to_string(path).map_err(|error| match error.kind() {
            std::io::ErrorKind::NotFound => ModelError::Missing(path.to_owned()),
            _ => ModelError::Io { path: path.to_owned(), doing: "read", reason: error.to_string() },
        })?;
        Self::from_json(&text).map_err(|sentence| ModelError::Content { path: path.to_owned(), sentence })
    }

    /// # Errors
    /// A sentence that names the key and what would be right.
    pub fn from_json(text: &str) -> Result<Self, String> {
        Self::parse(text).map_err(one_line)
    }

    fn parse(text: &str) -> Result<Self, String> {
        let value: serde_json::Value =
            serde_json::from_str(text).map_err(|error| format!("is no JSON, or cut short: {error}"))?;
        if value.get("format").and_then(serde_json::Value::as_str) != Some(FORMAT) {
            return Err(format!("is no model: its key `format` is not \"{FORMAT}\"; `anemo identify` writes models"));
        }
        match value.get("version").and_then(serde_json::Value::as_u64) {
            Some(version) if version == u64::from(VERSION) => {}
            Some(version) => {
                return Err(format!(
                    "is a model of version {version}, and this anemo reads version {VERSION}: identify it again, or use the anemo that wrote it"
                ));
            }
            None => return Err("has no `version`: identify it again".to_owned()),
        }
        if let Some(key) = beyond_f64(&value) {
            return Err(format!("`{key}` is a number too large to compute with"));
        }
        let model: Self = serde_json::from_value(value).map_err(|error| format!("is not a whole model: {error}"))?;
        model.check()?;
        Ok(model)
    }

    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("a model holds nothing that JSON does not")
    }

    pub fn write(&self, path: &Path) -> Result<(), ModelError> {
        Temporary::write(path, format!("{}\n", self.to_json()).as_bytes()).map_err(|error| ModelError::Io {
            path: path.to_owned(),
            doing: "written",
            reason: error.to_string(),
        })
    }

    /// What types alone do not say.
    fn check(&self) -> Result<(), String> {
        let positive = |key: &str, value: f64| {
            let good = value.is_finite() && value > 0.0;
            if good { Ok(()) } else { Err(format!("`{key}` must be a number greater than zero, and is {value}")) }
        };
        positive("sample_period_s", self.sample_period_s)?;
        if self.inputs.is_empty() || self.outputs.is_empty() || self.pairs.is_empty() || self.classes.is_empty() {
            return Err("must have at least one input, output, pair and class".to_owned());
        }
        for pair in &self.pairs {
            let name = format!("pair {} → {}", pair.input, pair.output);
            if !self.inputs.contains(&pair.input) || !self.outputs.iter().any(|output| output.name == pair.output) {
                return Err(format!("{name} names an input or output that the model does not have"));
            }
            if pair.dead_time_samples > 1_000_000 {
                return Err(format!("{name}: `dead_time_samples` is {}, more than a million", pair.dead_time_samples));
            }
            ascending(&name, &pair.mesh_rad_s)?;
            if pair.se_rate_rad_s.as_ref().is_some_and(|se| se.len() != pair.mesh_rad_s.len()) {
                return Err(format!(
                    "{name}: `se_rate_rad_s` must have one value for each of the {} rates, or be absent",
                    pair.mesh_rad_s.len()
                ));
            }
            if pair.classes.is_empty() {
                return Err(format!("{name} has no class"));
            }
            for (label, class) in &pair.classes {
                if !self.classes.contains(label) {
                    return Err(format!("{name}: class `{label}` is none of the model's `classes`"));
                }
                if class.r_k_per_w.len() != pair.mesh_rad_s.len() || class.se_k_per_w.len() != pair.mesh_rad_s.len() {
                    return Err(format!(
                        "{name}, class `{label}`: `r_k_per_w` and `se_k_per_w` must have one value for each of the {} rates",
                        pair.mesh_rad_s.len()
                    ));
                }
                let mut values =
                    class.r_k_per_w.iter().chain([&class.feed_through_k_per_w, &class.steady_gain_k_per_w]);
                if let Some(value) = values.find(|value| !value.is_finite()) {
                    return Err(format!("{name}, class `{label}`: {value} is no resistance"));
                }
            }
        }
        match (self.structure, &self.wind) {
            (Structure::Symbol, None) => Ok(()),
            (Structure::Symbol, Some(_)) => Err("has `wind`, which structure `symbol` does not".to_owned()),
            (Structure::Conductance, None) => Err("has structure `conductance` but no `wind`".to_owned()),
            (Structure::Conductance, Some(wind)) => {
                let elements = wind.elements.len();
                if elements != self.inputs.len() || elements != self.outputs.len() {
                    return Err(
                        "structure `conductance` needs one input, one output and one set of conductances an element"
                            .to_owned(),
                    );
                }
                let missing = self.classes.iter().find(|label| wind.elements.iter().any(|of| !of.contains_key(*label)));
                if let Some(label) = missing {
                    return Err(format!("`wind` has no conductance for class `{label}`"));
                }
                wind.following.as_ref().map_or(Ok(()), |following| following.check(&wind.gas, self.outputs.len()))
            }
        }
    }
}

impl Following {
    fn check(&self, gas: &Gas, outputs: usize) -> Result<(), String> {
        let name = "`wind.following`";
        if !matches!(gas, Gas::Column(_)) {
            return Err(format!("{name} needs the gas as a column, which outputs could follow"));
        }
        ascending(name, &self.mesh_rad_s)?;
        if self.outputs.len() != outputs {
            return Err(format!(
                "{name}: `outputs` has {} entries for the model's {outputs} outputs",
                self.outputs.len()
            ));
        }
        let rates = self.mesh_rad_s.len();
        if self.outputs.iter().any(|of| of.f_k_per_k.len() != rates || of.se_k_per_k.len() != rates) {
            return Err(format!(
                "{name}: `f_k_per_k` and `se_k_per_k` must have one value for each of the {rates} rates"
            ));
        }
        let [least, most] = self.range_c;
        if !(least <= self.from_c && self.from_c <= most) {
            return Err(format!(
                "{name}: `from_c` is {}, which is not within `range_c`, {least} to {most}",
                self.from_c
            ));
        }
        Ok(())
    }
}

fn ascending(name: &str, mesh_rad_s: &[f64]) -> Result<(), String> {
    let mut before = 0.0;
    for &rate in mesh_rad_s {
        if !(rate.is_finite() && rate > before) {
            return Err(format!(
                "{name}: `mesh_rad_s` must hold ascending rates above zero, and has {rate} after {before}"
            ));
        }
        before = rate;
    }
    Ok(())
}

/// The key of a number that f64 cannot hold, such as 1e999, which the parser would make infinite.
fn beyond_f64(value: &serde_json::Value) -> Option<String> {
    use serde_json::Value;
    let below = |key: String, value| {
        let rest = beyond_f64(value)?;
        Some(if rest.is_empty() || rest.starts_with('[') { key + &rest } else { format!("{key}.{rest}") })
    };
    match value {
        Value::Number(number) => (!number.as_f64().is_some_and(f64::is_finite)).then(String::new),
        Value::Array(items) => items.iter().enumerate().find_map(|(at, item)| below(format!("[{at}]"), item)),
        Value::Object(keys) => keys.iter().find_map(|(key, item)| below(key.clone(), item)),
        Value::Null | Value::Bool(_) | Value::String(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::super::export::testing;
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
            Model::from_json(&model.to_json()).unwrap_err()
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
        constant.wind.as_mut().unwrap().gas = Gas::ConstantC(18.0);
        assert!(Model::from_json(&constant.to_json()).unwrap_err().contains("needs the gas as a column"));
    }
}
