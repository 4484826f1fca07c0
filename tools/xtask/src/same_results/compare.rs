//! Results of commands side by side.

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::process::Output;

/// What a command prints or a file holds.
#[derive(Default)]
pub struct CommandResult {
    pub values: Values,
    errors: String,
}

/// By place, for example `elements.sector1.mean_power_w` or `pairs.0.mesh_rad_s.2`. Numbers of JSON
/// keep all digits that are written: read as `f64`, two of them might be taken for one.
type Values = BTreeMap<String, Value>;

/// Beginnings of places whose texts have to be equal, sentences included: cells of tables, lines of
/// files.
const EXACT: [&str; 2] = ["column.", "line."];
/// Keys that hold the time at which a command ran.
const TIMES: [&str; 2] = ["date", "utc"];
/// How many differences of one result are shown.
const SHOWN: usize = 5;

impl CommandResult {
    /// What is printed is compared if it is JSON.
    pub fn of_command(output: &Output) -> CommandResult {
        let mut values = json_values(&String::from_utf8_lossy(&output.stdout));
        values.insert("exit code".into(), output.status.code().into());
        CommandResult { values, errors: String::from_utf8_lossy(&output.stderr).into() }
    }

    pub fn of_file(path: &str, content: &[u8]) -> CommandResult {
        let mut result = CommandResult::default();
        match (path.rsplit('.').next(), str::from_utf8(content)) {
            (Some("json"), Ok(text)) => result.values = json_values(text),
            (Some("csv"), Ok(text)) => result.values = cells(text),
            (_, Ok(text)) => {
                let lines = text.lines().enumerate().map(|(at, line)| (format!("line.{at}"), line.into()));
                result.values = lines.collect();
            }
            (_, Err(_)) => result.add_content("content", content),
        }
        result
    }

    pub fn add_content(&mut self, place: &str, content: &[u8]) {
        let mut hasher = DefaultHasher::new();
        content.hash(&mut hasher);
        self.values.insert(place.into(), format!("{}-bytes-{:x}", content.len(), hasher.finish()).into());
    }
}

/// All values of a text of JSON. Nothing if the text is none.
fn json_values(text: &str) -> Values {
    let mut values = Values::new();
    if let Ok(json) = serde_json::from_str(text) {
        collect(String::new(), json, &mut values);
    }
    values
}

fn collect(place: String, value: Value, values: &mut Values) {
    let below = |name: &str| if place.is_empty() { name.to_owned() } else { format!("{place}.{name}") };
    match value {
        Value::Object(entries) => {
            for (name, entry) in entries {
                collect(below(&name), entry, values);
            }
        }
        Value::Array(entries) => {
            for (index, entry) in entries.into_iter().enumerate() {
                collect(below(&index.to_string()), entry, values);
            }
        }
        leaf => drop(values.insert(place, leaf)),
    }
}

/// Cells of a table of comma-separated values by column and row. Lines of comment are left out.
fn cells(text: &str) -> Values {
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let columns: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let of_row = |(row, line): (usize, &str)| {
        let cells = columns.iter().zip(line.split(','));
        cells.map(|(column, cell)| (format!("column.{column}.{row}"), cell.into())).collect::<Vec<_>>()
    };
    lines.enumerate().flat_map(of_row).collect()
}

/// How two results differ.
#[derive(Debug, Default, PartialEq)]
pub struct ResultComparison {
    /// Values that both have.
    pub compared: usize,
    /// Places whose values are not the same.
    pub different: Vec<String>,
    /// Of numbers, relative to the larger one.
    pub largest_difference: f64,
    pub only_old: BTreeSet<String>,
    pub only_new: BTreeSet<String>,
}

impl ResultComparison {
    pub fn of(old: &CommandResult, new: &CommandResult) -> ResultComparison {
        let mut comparison = ResultComparison::default();
        let mut new_left: BTreeMap<&String, &Value> = new.values.iter().collect();
        // What both have, without the numbers of rows and entries.
        let mut names = BTreeSet::new();
        for (place, value) in &old.values {
            match new_left.remove(place) {
                Some(new_value) => {
                    names.insert(without_numbers(place));
                    comparison.value(place, value, new_value);
                }
                None => drop(comparison.only_old.insert(without_numbers(place))),
            }
        }
        comparison.only_new = new_left.keys().map(|place| without_numbers(place)).collect();
        let missing = comparison.only_old.union(&comparison.only_new);
        let lists = missing.filter(|name| names.contains(*name));
        comparison.different.extend(lists.map(|name| format!("{name}: another number of entries")));
        for (which, values) in [("older", &old.values), ("newer", &new.values)] {
            if values.is_empty() {
                comparison.different.push(format!("the {which} one has nothing of this"));
            }
        }
        if old.values.get("exit code") != new.values.get("exit code") {
            comparison.different.push(format!("{} → {}", old.errors.trim(), new.errors.trim()));
        }
        comparison
    }

    fn value(&mut self, place: &str, old: &Value, new: &Value) {
        let is_exact = EXACT.iter().any(|beginning| place.starts_with(beginning));
        let texts = old.as_str().zip(new.as_str()).filter(|_| !is_exact);
        let is_time = place.rsplit('.').next().is_some_and(|key| TIMES.contains(&key));
        // Sentences may be put otherwise; names and hashes may not.
        if is_time || texts.is_some_and(|(old, new)| old.contains([' ', '/']) || new.contains(' ')) {
            return;
        }
        self.compared += 1;
        if old == new {
            return;
        }
        let written = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        let (old, new) = (written(old), written(new));
        if let (Ok(a), Ok(b)) = (old.parse::<f64>(), new.parse::<f64>()) {
            let largest = a.abs().max(b.abs());
            let difference = if largest > 0.0 { (a - b).abs() / largest } else { 0.0 };
            self.largest_difference = self.largest_difference.max(difference);
        }
        self.different.push(format!("{place}: {old} → {new}"));
    }
}

/// A place without the numbers of rows and entries.
fn without_numbers(place: &str) -> String {
    place.split('.').filter(|name| name.parse::<usize>().is_err()).collect::<Vec<_>>().join(".")
}

/// Shows what differs, and how much was compared.
pub fn print(rows: &[(String, ResultComparison)]) {
    for (name, comparison) in rows.iter().filter(|(_, comparison)| !comparison.different.is_empty()) {
        let (count, largest) = (comparison.different.len(), comparison.largest_difference);
        println!("{name}\n    {count} of {} differ, by {largest:.1e} of themselves at most", comparison.compared);
        comparison.different.iter().take(SHOWN).for_each(|difference| println!("    {difference}"));
    }
    let compared: usize = rows.iter().map(|(_, comparison)| comparison.compared).sum();
    println!("{compared} values of {} commands, files and images compared", rows.len());
    let only_old: BTreeSet<&String> = rows.iter().flat_map(|(_, comparison)| &comparison.only_old).collect();
    let only_new: BTreeSet<&String> = rows.iter().flat_map(|(_, comparison)| &comparison.only_new).collect();
    for (which, places) in [("older", only_old), ("newer", only_new)] {
        if !places.is_empty() {
            println!("only the {which} one has:");
        }
        places.iter().for_each(|place| println!("    {place}"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn json(text: &str) -> CommandResult {
        CommandResult { values: json_values(text), errors: String::new() }
    }

    fn compare(old: &str, new: &str) -> ResultComparison {
        ResultComparison::of(&json(old), &json(new))
    }

    #[test]
    fn numbers_keep_all_their_digits_and_their_places() {
        let text = r#" {"a": 0.10000000000000001, "b": [1, {"c": "x, \"y\"}"}, []], "d": {}, "e": null, "f": -1e-9} "#;
        let written: Vec<_> = json_values(text).iter().map(|(place, value)| format!("{place}: {value}")).collect();
        assert_eq!(written, ["a: 0.10000000000000001", "b.0: 1", r#"b.1.c: "x, \"y\"}""#, "e: null", "f: -1e-9"]);
    }

    #[test]
    fn what_is_no_json_is_nothing() {
        for text in ["", "a summary", "{\"a\": 1", "{\"a\": what}", "[1 2]", "1 2"] {
            assert!(json_values(text).is_empty(), "{text}");
        }
    }

    #[test]
    fn a_difference_in_the_last_digit_is_found_with_its_size() {
        let same = compare(r#"{"a": 0.30000000000000004}"#, r#"{"a": 0.30000000000000004}"#);
        assert_eq!((same.compared, same.different.len()), (1, 0));
        let other = compare(r#"{"a": 0.30000000000000004}"#, r#"{"a": 0.3}"#);
        assert_eq!(other.different, ["a: 0.30000000000000004 → 0.3"]);
        assert!(other.largest_difference > 1e-16 && other.largest_difference < 2e-16);
    }

    #[test]
    fn what_only_one_has_is_named_and_sentences_are_not_compared() {
        let comparison = compare(
            r#"{"hash": "ab", "notes": ["too short a record"], "rows": [1, 2]}"#,
            r#"{"hash": "ac", "notes": ["the record is too short"], "more": [{"x": 1}]}"#,
        );
        assert_eq!(comparison.different, ["hash: ab → ac"]);
        assert_eq!(comparison.only_old, ["rows".to_owned()].into());
        assert_eq!(comparison.only_new, ["more.x".to_owned()].into());
    }

    #[test]
    fn a_shorter_list_and_no_output_at_all_are_differences() {
        let shorter = compare(r#"{"rows": [1, 2, 3], "n": 1}"#, r#"{"rows": [1, 2], "n": 1}"#);
        assert_eq!(shorter.different, ["rows: another number of entries"]);
        let longer = compare(r#"{"rows": [1, 2], "n": 1}"#, r#"{"rows": [1, 2, 3], "n": 1}"#);
        assert_eq!(longer.different, ["rows: another number of entries"]);
        let nothing = compare(r#"{"n": 1}"#, "a summary");
        assert_eq!(nothing.different, ["the newer one has nothing of this"]);
    }

    #[test]
    fn columns_of_tables_are_compared_cell_by_cell_and_texts_line_by_line() {
        let file = |path: &str, text: &str| CommandResult::of_file(path, text.as_bytes());
        let old = file("a.csv", "# head: x\ntime_s,wind_x_m_s,state\n0,2,running\n1,2.5,running\n");
        let new = file("a.csv", "time_s,wind_x_m_s,state\n0,2,running\n1,2.25,running\n");
        let comparison = ResultComparison::of(&old, &new);
        assert_eq!(comparison.different, ["column.wind_x_m_s.1: 2.5 → 2.25"]);
        assert_eq!(comparison.compared, 6);
        let comparison = ResultComparison::of(&file("a.svg", "<a b>\n<c d>"), &file("a.svg", "<a b>\n<c e>"));
        assert_eq!(comparison.different, ["line.1: <c d> → <c e>"]);
        let [old, new] = [[0xff, 1], [0xff, 2]].map(|content| CommandResult::of_file("a.png", &content));
        assert_eq!(ResultComparison::of(&old, &new).different.len(), 1);
    }
}
