//! A board's settings beside their defaults, as a table for people, and as JSON.

use std::collections::BTreeMap;
use std::fmt;

use serde::Serialize;
use serde_json::Value;

use super::board::StoredSettings;
use super::edit::{KEYS, Settings};
use recording::text::columns;

/// Characters of a value that a line of the table has room for.
const MOST_SHOWN: usize = 60;

/// All settings of a board.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SettingsReport {
    /// Name and version of the board's firmware.
    pub firmware: String,
    /// Why the board does not use its settings.
    pub unused: Option<String>,
    /// Values by their keys, as far as there are any.
    pub settings: BTreeMap<&'static str, SettingReport>,
}

/// One setting.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SettingReport {
    /// Value that the settings have.
    pub value: Option<Value>,
    /// Value that holds where the settings have none.
    pub default: Option<Value>,
    /// Whether the settings have another value than the default.
    pub stored: bool,
}

impl SettingsReport {
    /// Reports the settings of a board.
    pub fn of(firmware: &str, stored: &StoredSettings) -> Self {
        let (settings, defaults) = (stored.settings.clone().unwrap_or_default(), Settings::defaults());
        let report = |key| {
            let default = defaults.value(key);
            let value = settings.value(key).or_else(|| default.clone());
            let setting = SettingReport { stored: value != default, value, default };
            let always = setting.value.is_some() || key == "sample_period_s";
            always.then_some((key, setting))
        };
        let unused = stored.unused.map(|why| why.to_string());
        Self { firmware: firmware.to_owned(), unused, settings: KEYS.into_iter().filter_map(report).collect() }
    }
}

impl fmt::Display for SettingsReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut lines = vec![["key", "value", "default", "state"].map(str::to_owned).to_vec()];
        for (key, setting) in KEYS.iter().filter_map(|key| self.settings.get_key_value(key)) {
            setting.flatten(key, &mut lines);
        }
        write!(f, "{}\n\n{}", self.firmware, columns(&lines, &[]))?;
        match &self.unused {
            Some(why) => writeln!(f, "\n{why}: bring them back with `anemo board settings restore`"),
            None => Ok(()),
        }
    }
}

impl SettingReport {
    /// The lines of a value: a line for each of a few plain numbers, one line for the others.
    fn flatten(&self, key: &str, lines: &mut Vec<Vec<String>>) {
        let state = || if self.stored { "stored" } else { "default" }.to_owned();
        let default = self.default.as_ref();
        if let Some(Value::Object(parts)) = &self.value {
            for (name, part) in parts {
                let default = default.and_then(|default| default.get(name));
                lines.push(vec![format!("{key}.{name}"), brief(Some(part)), brief(default), state()]);
            }
            return;
        }
        lines.push(vec![key.to_owned(), brief(self.value.as_ref()), brief(default), state()]);
    }
}

fn brief(value: Option<&Value>) -> String {
    let text = match value {
        None | Some(Value::Null) => return "–".to_owned(),
        Some(Value::String(text)) if text.is_empty() => return "–".to_owned(),
        Some(Value::String(text)) => text.clone(),
        Some(other) => other.to_string().replace('"', ""),
    };
    match text.char_indices().nth(MOST_SHOWN) {
        Some((end, _)) => format!("{}…", text.get(..end).unwrap_or(&text)),
        None => text,
    }
}
