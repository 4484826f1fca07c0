//! Results of commands side by side, value by value.
//!
//! A value has a place: a key of JSON such as `elements.sector1.mean_power_w`, or line and cell of
//! a text. Numbers keep all digits that are written: read as `f64`, two of them might be taken for
//! one.

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::hash::{DefaultHasher, Hash, Hasher};

/// Values by their places.
pub type Values = BTreeMap<String, String>;

/// Keys that hold the time at which a command ran.
const TIMES: [&str; 2] = ["date", "utc"];
/// Number of differences of one result that are shown.
const SHOWN: usize = 5;

/// Values of a file.
pub fn of_file(path: &str, content: &[u8]) -> Values {
    match (path.rsplit('.').next(), str::from_utf8(content)) {
        (Some("json"), Ok(text)) => of_json(text),
        (_, Ok(text)) => {
            let lines = text.lines().filter(|line| !line.starts_with('#')).enumerate();
            let cells = lines.flat_map(|(line, text)| text.split(',').enumerate().map(move |cell| (line, cell)));
            cells.map(|(line, (cell, text))| (format!("line {line}, cell {cell}"), text.to_owned())).collect()
        }
        (_, Err(_)) => [("content".to_owned(), digest(content))].into(),
    }
}

/// Length and hash of bytes.
pub fn digest(content: &[u8]) -> String {
    let mut hasher = DefaultHasher::new();
    content.hash(&mut hasher);
    format!("{} bytes, {:x}", content.len(), hasher.finish())
}

/// Values of a text of JSON but those of [`TIMES`]. Nothing if the text is none.
pub fn of_json(text: &str) -> Values {
    let mut values = Values::new();
    if let Ok(json) = serde_json::from_str(text) {
        collect("", &json, &mut values);
    }
    values
}

fn collect(place: &str, value: &Value, values: &mut Values) {
    let below = |name: &str| if place.is_empty() { name.to_owned() } else { format!("{place}.{name}") };
    match value {
        Value::Object(entries) => {
            let entries = entries.iter().filter(|(name, _)| !TIMES.contains(&name.as_str()));
            entries.for_each(|(name, entry)| collect(&below(name), entry, values));
        }
        Value::Array(entries) => {
            entries.iter().enumerate().for_each(|(at, entry)| collect(&below(&at.to_string()), entry, values));
        }
        leaf => drop(values.insert(place.to_owned(), leaf.to_string())),
    }
}

/// Shows how a result differs, and the size of the largest difference. Returns whether it does.
pub fn differs(name: &str, old: &Values, new: &Values) -> bool {
    let places: BTreeSet<&String> = old.keys().chain(new.keys()).collect();
    let different: Vec<_> = places.into_iter().filter(|place| old.get(*place) != new.get(*place)).collect();
    if different.is_empty() {
        return false;
    }
    let number = |values: &Values, place: &String| values.get(place)?.parse::<f64>().ok();
    let sizes = different.iter().filter_map(|place| relative(number(old, place)?, number(new, place)?));
    let largest = sizes.fold(0.0, f64::max);
    println!("{name}\n    {} of {} differ, by {largest:.1e} of themselves at most", different.len(), old.len());
    let shown = |values: &Values, place: &String| values.get(place).map_or("nothing", String::as_str).to_owned();
    for place in different.into_iter().take(SHOWN) {
        println!("    {place}: {} → {}", shown(old, place), shown(new, place));
    }
    true
}

/// Difference of two numbers, relative to the larger one.
fn relative(old: f64, new: f64) -> Option<f64> {
    let largest = old.abs().max(new.abs());
    (largest > 0.0).then(|| (old - new).abs() / largest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_all_their_digits_and_their_places_and_times_are_left_out() {
        let text = r#" {"a": 0.10000000000000001, "b": [1, {"c": "x, \"y\"}"}, []], "d": {}, "e": null, "utc": 1, "f": -1e-9} "#;
        let written: Vec<_> = of_json(text).iter().map(|(place, value)| format!("{place}: {value}")).collect();
        assert_eq!(written, ["a: 0.10000000000000001", "b.0: 1", r#"b.1.c: "x, \"y\"}""#, "e: null", "f: -1e-9"]);
    }

    #[test]
    fn what_is_no_json_is_nothing() {
        for text in ["", "a summary", "{\"a\": 1", "{\"a\": what}", "[1 2]", "1 2"] {
            assert!(of_json(text).is_empty(), "{text}");
        }
    }

    #[test]
    fn a_last_digit_a_word_and_a_missing_entry_are_differences() {
        let differs = |old: &str, new: &str| differs("", &of_json(old), &of_json(new));
        assert!(!differs(r#"{"a": 0.30000000000000004}"#, r#"{"a": 0.30000000000000004}"#));
        assert!(differs(r#"{"a": 0.30000000000000004}"#, r#"{"a": 0.3}"#));
        assert!(differs(r#"{"hash": "ab"}"#, r#"{"hash": "ac"}"#));
        assert!(differs(r#"{"rows": [1, 2, 3]}"#, r#"{"rows": [1, 2]}"#));
        assert!(differs(r#"{"rows": [1, 2]}"#, r#"{"rows": [1, 2, 3]}"#));
        assert!(differs(r#"{"n": 1}"#, "a summary"));
        assert!(relative(0.30000000000000004, 0.3).is_some_and(|size| size > 1e-16 && size < 2e-16));
    }

    #[test]
    fn tables_and_texts_are_compared_cell_by_cell_without_comments_and_bytes_as_a_whole() {
        let file = |path: &str, text: &str| of_file(path, text.as_bytes());
        let old = file("a.csv", "# head: x\ntime_s,wind_x_m_s\n0,2\n1,2.5\n");
        let new = file("a.csv", "time_s,wind_x_m_s\n0,2\n1,2.25\n");
        let different: Vec<_> = old.keys().filter(|place| old.get(*place) != new.get(*place)).collect();
        assert_eq!(different, ["line 2, cell 1"]);
        assert!(differs("", &file("a.svg", "<a b>\n<c d>"), &file("a.svg", "<a b>\n<c e>")));
        assert!(differs("", &of_file("a.png", &[0xff, 1]), &of_file("a.png", &[0xff, 2])));
    }
}
