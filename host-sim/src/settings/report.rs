//! What a board keeps beside its defaults, as a table for people, and as JSON.

use std::collections::BTreeMap;
use std::fmt;

use serde::Serialize;
use serde_json::Value;
use wire::settings::{KeyNumber, SettingKey, SettingKind};

use super::kept::{KeptSetting, content, default_of};
use super::names;
use recording::text::columns;

/// Characters of a value that a line of the table has room for.
const MOST_SHOWN: usize = 60;

/// All settings of a board.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SettingsReport {
    /// Name and version of the board's firmware.
    pub firmware: String,
    /// Whether the flash holds what was written to it.
    pub whole: bool,
    /// By the name of their key.
    pub settings: BTreeMap<String, SettingReport>,
    /// The same names, in the order of the table.
    #[serde(skip)]
    order: Vec<String>,
}

/// One setting.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SettingReport {
    /// The value that holds; none where nothing is kept and there is no default.
    pub value: Option<Value>,
    /// The value that holds where nothing is kept.
    pub default: Option<Value>,
    /// Whether the board keeps a value.
    pub stored: bool,
    /// Why the kept value is not used.
    pub unusable: Option<String>,
}

impl SettingsReport {
    /// What a board keeps, and the settings that always hold.
    pub fn of(firmware: &str, kept: &[KeptSetting], whole: bool) -> Self {
        let mut numbers: Vec<KeyNumber> = kept.iter().map(|kept| kept.number).collect();
        let always = [
            SettingKind::Name,
            SettingKind::TelemetryEvery,
            SettingKind::SamplePeriod,
            SettingKind::Guard,
            SettingKind::Observe,
            SettingKind::HostTimeout,
        ];
        numbers.extend(always.map(|kind| SettingKey { kind, which: 0 }.number()));
        numbers.sort_unstable();
        numbers.dedup();
        let report = |number| {
            let default = SettingKey::of_number(number).and_then(|key| default_of(key.kind)).as_ref().map(content);
            let (value, stored, unusable) =
                match kept.iter().find(|kept| kept.number == number).map(|kept| &kept.setting) {
                    Some(Ok(setting)) => (Some(content(setting)), true, None),
                    Some(Err(why)) => (default.clone(), true, Some(why.to_string())),
                    None => (default.clone(), false, None),
                };
            SettingReport { value, default, stored, unusable }
        };
        Self {
            firmware: firmware.to_owned(),
            whole,
            settings: numbers.iter().map(|&number| (names::of(number), report(number))).collect(),
            order: numbers.iter().map(|&number| names::of(number)).collect(),
        }
    }
}

impl fmt::Display for SettingsReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut lines = vec![["key", "value", "default", "state"].map(str::to_owned).to_vec()];
        for (key, setting) in self.order.iter().filter_map(|key| self.settings.get_key_value(key)) {
            setting.flatten(key, &mut lines);
        }
        write!(f, "{}\n\n{}", self.firmware, columns(&lines, &[]))?;
        if self.whole {
            return Ok(());
        }
        writeln!(f, "\n{}: bring them back with `anemo settings restore`", wire::SettingsRefusal::NotWhole)
    }
}

impl SettingReport {
    fn state(&self) -> String {
        match &self.unusable {
            Some(why) => format!("not used: {why}"),
            None if self.stored => "stored".to_owned(),
            None => "default".to_owned(),
        }
    }

    /// The lines of a value: one for each of a few plain numbers, one for all of what is longer.
    fn flatten(&self, key: &str, lines: &mut Vec<Vec<String>>) {
        let default = self.default.as_ref();
        if let Some(Value::Object(parts)) = &self.value
            && parts.values().all(|part| !part.is_object() && !part.is_array())
            && parts.len() <= 4
        {
            for (name, part) in parts {
                let default = default.and_then(|default| default.get(name));
                lines.push(vec![format!("{key}.{name}"), brief(Some(part)), brief(default), self.state()]);
            }
            return;
        }
        lines.push(vec![key.to_owned(), brief(self.value.as_ref()), brief(default), self.state()]);
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
