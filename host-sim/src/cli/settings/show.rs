//! `anemo settings show`: all values with their defaults, as a table or as JSON.

use std::fmt::Write as _;

use wire::settings::{Key, KeyNumber, Kind};

use super::{Board, Failure};
use crate::settings::{self, names};
use crate::table;

/// Characters of a value that a line of the table has room for.
const MOST_SHOWN: usize = 60;

pub fn show(board: &mut Board, json: bool) -> Result<(), Failure> {
    let (kept, whole) = board.read()?;
    let mut numbers: Vec<KeyNumber> = kept.iter().map(|kept| kept.number).collect();
    // What always holds has its line always.
    let always = [Kind::Name, Kind::TelemetryEvery, Kind::SamplePeriod, Kind::Guard, Kind::Observe];
    numbers.extend(always.map(|kind| Key { kind, which: 0 }.number()));
    numbers.sort_unstable();
    numbers.dedup();
    let found = |number| kept.iter().find(|kept| kept.number == number);
    let default = |number| Key::of_number(number).and_then(|key| settings::default_of(key.kind));
    if json {
        let all = numbers.iter().map(|&number| {
            let default = default(number).as_ref().map(settings::content);
            let (value, stored, unusable) = match found(number).map(|kept| &kept.setting) {
                Some(Ok(setting)) => (Some(settings::content(setting)), true, None),
                Some(Err(why)) => (default.clone(), true, Some(why.to_string())),
                None => (default.clone(), false, None),
            };
            let entry =
                serde_json::json!({ "value": value, "default": default, "stored": stored, "unusable": unusable });
            (names::of(number), entry)
        });
        let settings: serde_json::Map<_, _> = all.collect();
        let firmware = board.keeper().firmware().to_owned();
        return super::super::print_json(
            &serde_json::json!({ "firmware": firmware, "whole": whole, "settings": settings }),
        );
    }
    let mut lines = vec![["key", "value", "default", "state"].map(str::to_owned).to_vec()];
    for &number in &numbers {
        let default = default(number).as_ref().map(settings::content);
        let (value, state) = match found(number).map(|kept| &kept.setting) {
            Some(Ok(setting)) => (Some(settings::content(setting)), "stored".to_owned()),
            Some(Err(why)) => (default.clone(), format!("not used: {why}")),
            None => (default.clone(), "default".to_owned()),
        };
        flatten(&names::of(number), value.as_ref(), default.as_ref(), &state, &mut lines);
    }
    let mut text = format!("{}\n\n{}", board.keeper().firmware(), table::columns(&lines, &[]));
    if !whole {
        let _ = writeln!(text, "\n{}: bring them back with `anemo settings restore`", wire::SettingsRefusal::NotWhole);
    }
    super::super::print(&text)
}

/// The lines of a value: one for each of a few plain numbers, one for all of what is longer.
fn flatten(
    key: &str,
    value: Option<&serde_json::Value>,
    default: Option<&serde_json::Value>,
    state: &str,
    lines: &mut Vec<Vec<String>>,
) {
    if let Some(serde_json::Value::Object(parts)) = value
        && parts.values().all(|part| !part.is_object() && !part.is_array())
        && parts.len() <= 4
    {
        for (name, part) in parts {
            let default = default.and_then(|default| default.get(name));
            lines.push(vec![format!("{key}.{name}"), brief(Some(part)), brief(default), state.to_owned()]);
        }
        return;
    }
    lines.push(vec![key.to_owned(), brief(value), brief(default), state.to_owned()]);
}

fn brief(value: Option<&serde_json::Value>) -> String {
    let text = match value {
        None | Some(serde_json::Value::Null) => return "–".to_owned(),
        Some(serde_json::Value::String(text)) if text.is_empty() => return "–".to_owned(),
        Some(serde_json::Value::String(text)) => text.clone(),
        Some(other) => other.to_string().replace('"', ""),
    };
    match text.char_indices().nth(MOST_SHOWN) {
        Some((end, _)) => format!("{}…", text.get(..end).unwrap_or(&text)),
        None => text,
    }
}
