//! Results of commands side by side.

use super::renamed;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

/// What a command has come to.
#[derive(Default)]
pub struct CommandResult {
    pub exit_code: Option<i32>,
    pub values: Values,
    pub errors: String,
}

/// By place, for example `elements.sector1.mean_power_w` or `pairs.0.mesh_rad_s.2`. Numbers of JSON
/// keep all digits that are written: read as `f64`, two of them might be taken for one.
pub type Values = BTreeMap<String, Value>;

/// What the places of tables' cells begin with.
const COLUMN: &str = "column.";
/// How many differences of one result are shown.
const SHOWN: usize = 5;

/// All values of a text of JSON. Nothing if the text is none.
pub fn values(text: &str) -> Values {
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
pub fn cells(text: &str) -> Values {
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let columns: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let of_row = |(row, line): (usize, &str)| {
        let cells = columns.iter().zip(line.split(','));
        cells.map(|(column, cell)| (format!("{COLUMN}{column}.{row}"), cell.into())).collect::<Vec<_>>()
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
        if old.exit_code != new.exit_code {
            let codes = format!("exit code {:?} → {:?}", old.exit_code, new.exit_code);
            comparison.different.push(format!("{codes}: {}{}", old.errors.trim(), new.errors.trim()));
        }
        let mut new_left: BTreeMap<&String, &Value> = new.values.iter().collect();
        // A column's older name may be another one's newer name.
        let columns_as_before =
            old.values.keys().filter(|place| is_column(place)).all(|place| new.values.contains_key(place));
        // What both have, without the numbers of rows and entries.
        let mut names = BTreeSet::new();
        for (place, value) in &old.values {
            let translated = if is_column(place) && columns_as_before { place } else { &translated(place) };
            // A key that has not been renamed yet has its older name.
            match new_left.remove_entry(translated).or_else(|| new_left.remove_entry(place)) {
                Some((new_place, new_value)) => {
                    names.extend([without_numbers(place), without_numbers(new_place)]);
                    comparison.value(new_place, value, new_value);
                }
                None => drop(comparison.only_old.insert(without_numbers(place))),
            }
        }
        comparison.only_new = new_left.keys().map(|place| without_numbers(place)).collect();
        let missing = comparison.only_old.union(&comparison.only_new);
        let lists = missing.filter(|name| names.contains(*name));
        comparison.different.extend(lists.map(|name| format!("{name}: another number of entries")));
        if comparison.compared == 0 && !old.values.is_empty() {
            comparison.different.push(format!("the newer one has nothing to compare: {}", new.errors.trim()));
        }
        comparison
    }

    fn value(&mut self, place: &str, old: &Value, new: &Value) {
        let texts = old.as_str().zip(new.as_str()).filter(|_| !is_column(place));
        // Sentences may be put otherwise; names and hashes may not, unless they were renamed.
        if texts.is_some_and(|(old, new)| old.contains([' ', '/']) || new.contains(' ')) {
            return;
        }
        self.compared += 1;
        if old == new || texts.is_some_and(|(old, new)| renamed::column(old) == new) {
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

fn is_column(place: &str) -> bool {
    place.starts_with(COLUMN)
}

/// A place by its newer names.
fn translated(place: &str) -> String {
    if let Some((column, row)) = place.strip_prefix(COLUMN).and_then(|rest| rest.rsplit_once('.')) {
        return format!("{COLUMN}{}.{row}", renamed::column(column));
    }
    place.split('.').map(renamed::key).collect::<Vec<_>>().join(".")
}

/// A place without the numbers of rows and entries.
fn without_numbers(place: &str) -> String {
    place.split('.').filter(|name| name.parse::<usize>().is_err()).collect::<Vec<_>>().join(".")
}

/// Shows all comparisons with what was compared.
pub fn print(rows: &[(String, ResultComparison)]) {
    println!("{:<60} {:>8} {:>10} {:>20}", "what", "compared", "different", "largest difference");
    for (name, comparison) in rows {
        let (count, largest) = (comparison.different.len(), comparison.largest_difference);
        let verdict = if count == 0 { "equal".to_owned() } else { count.to_string() };
        println!("{name:<60} {:>8} {verdict:>10} {largest:>20.1e}", comparison.compared);
        comparison.different.iter().take(SHOWN).for_each(|difference| println!("    {difference}"));
    }
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

    fn outcome(exit_code: i32, text: &str) -> CommandResult {
        CommandResult { exit_code: Some(exit_code), values: values(text), errors: String::new() }
    }

    fn compare(old: &str, new: &str) -> ResultComparison {
        ResultComparison::of(&outcome(0, old), &outcome(0, new))
    }

    #[test]
    fn numbers_keep_all_their_digits_and_their_places() {
        let text = r#" {"a": 0.10000000000000001, "b": [1, {"c": "x, \"y\"}"}, []], "d": {}, "e": null, "f": -1e-9} "#;
        let written: Vec<_> = values(text).iter().map(|(place, value)| format!("{place}: {value}")).collect();
        assert_eq!(written, ["a: 0.10000000000000001", "b.0: 1", r#"b.1.c: "x, \"y\"}""#, "e: null", "f: -1e-9"]);
    }

    #[test]
    fn what_is_no_json_is_nothing() {
        for text in ["", "a summary", "{\"a\": 1", "{\"a\": what}", "[1 2]", "1 2"] {
            assert!(values(text).is_empty(), "{text}");
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
    fn what_has_been_renamed_is_compared_under_its_newer_name_and_under_its_older_one_until_then() {
        let old = r#"{"doubts": {"cold": 3}, "inputs": ["power_w:card1-die1"]}"#;
        let new = r#"{"quality_flags": {"cold": 3}, "inputs": ["power_w_card1_die1"]}"#;
        for newer in [old, new] {
            let comparison = compare(old, newer);
            assert_eq!((comparison.compared, comparison.different.len()), (2, 0), "{newer}");
            assert!(comparison.only_old.is_empty() && comparison.only_new.is_empty());
        }
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
        assert!(nothing.different[0].starts_with("the newer one has nothing to compare"), "{nothing:?}");
    }

    #[test]
    fn another_exit_code_is_a_difference() {
        let comparison = ResultComparison::of(&outcome(1, ""), &outcome(0, "{}"));
        assert!(comparison.different[0].starts_with("exit code Some(1) → Some(0)"));
    }

    #[test]
    fn columns_of_tables_are_compared_cell_by_cell() {
        let table = |text: &str| CommandResult { exit_code: Some(0), values: cells(text), errors: String::new() };
        let old = table("# head: x\ntime_s,wind_x_m_s,answer_x_m_s,state\n0,1,2,running\n1,1,2.5,running\n");
        let new = table("time_s,true_wind_x_m_s,wind_x_m_s,state\n0,1,2,running\n1,1,2.25,running\n");
        let comparison = ResultComparison::of(&old, &new);
        assert_eq!(comparison.different, ["column.wind_x_m_s.1: 2.5 → 2.25"]);
        assert_eq!(comparison.compared, 8);
        assert!(ResultComparison::of(&old, &old).different.is_empty(), "before anything was renamed");
    }
}
