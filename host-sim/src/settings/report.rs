//! What a board keeps beside its defaults, as a table for people, and as JSON.

use std::collections::BTreeMap;
use std::fmt;

use dr_core::control::Refusal;
use serde::Serialize;
use serde_json::Value;
use wire::Unusable;
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
                    Some(Err(why)) => (default.clone(), true, Some(reason(number, why))),
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
        writeln!(f, "\n{}: bring them back with `anemo board settings restore`", wire::SettingsRefusal::NotWhole)
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

/// Why a kept value is not used. Elements follow each other without a gap: one that cannot be used
/// keeps out those behind it, which are not at fault.
fn reason(number: KeyNumber, why: &Unusable) -> String {
    let key = SettingKey::of_number(number).filter(|key| key.kind == SettingKind::Element);
    match (key, why) {
        (Some(SettingKey { kind, which }), &Unusable::Refused(Refusal::NotConfigured { element }))
            if element < which =>
        {
            let first = names::of(SettingKey { kind, which: element }.number());
            format!("it comes behind {first}, which is missing or not used")
        }
        _ => why.to_string(),
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

#[cfg(test)]
mod tests {
    use super::*;
    use wire::settings::SettingValue;

    #[test]
    fn an_element_behind_one_that_is_not_used_names_that_one_and_no_fault_of_its_own() {
        let kept = |which, element| {
            let number = SettingKey { kind: SettingKind::Element, which }.number();
            let why = Unusable::Refused(Refusal::NotConfigured { element });
            KeptSetting { number, value: SettingValue::new(), setting: Err(why) }
        };
        let report = SettingsReport::of("firmware", &[kept(1, 0), kept(3, 2)], true);
        let text = report.to_string();
        let state = |key: &str| text.lines().find_map(|line| line.strip_prefix(key)).unwrap().to_owned();
        assert!(state("element.1").ends_with("not used: it comes behind element.0, which is missing or not used"));
        assert!(state("element.3").ends_with("not used: it comes behind element.2, which is missing or not used"));
        assert!(!text.contains("has no configuration"), "{text}");
    }
}
