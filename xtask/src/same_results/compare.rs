//! CommandResults side by side.

use super::json::Leaf;
use super::renamed;
use std::collections::{BTreeMap, BTreeSet};

/// What a command has come to.
pub struct CommandResult {
    pub exit_code: Option<i32>,
    pub leaves: BTreeMap<String, Leaf>,
    pub errors: String,
}

/// What was done, by name, and what it has come to.
pub type CommandResults = Vec<(String, CommandResult)>;

/// How two outcomes differ.
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
    /// What both have, without the numbers of rows and entries.
    names: BTreeSet<String>,
}

/// What the places of tables' cells begin with.
const COLUMN: &str = "column.";

/// Cells of a table of comma-separated values by column and row. Lines of comment are left out.
pub fn cells(text: &str) -> BTreeMap<String, Leaf> {
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let columns: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let mut cells = BTreeMap::new();
    for (row, line) in lines.enumerate() {
        for (column, cell) in columns.iter().zip(line.split(',')) {
            let is_number = cell.parse::<f64>().is_ok();
            let leaf = if is_number { Leaf::Number(cell.into()) } else { Leaf::Word(cell.into()) };
            cells.insert(format!("{COLUMN}{column}.{row}"), leaf);
        }
    }
    cells
}

impl ResultComparison {
    pub fn of(old: &CommandResult, new: &CommandResult) -> ResultComparison {
        let mut comparison = ResultComparison::default();
        if old.exit_code != new.exit_code {
            comparison.different.push(format!(
                "exit code {:?} → {:?}: {}{}",
                old.exit_code,
                new.exit_code,
                old.errors.trim(),
                new.errors.trim()
            ));
        }
        let mut new_left: BTreeMap<&str, &Leaf> =
            new.leaves.iter().map(|(place, leaf)| (place.as_str(), leaf)).collect();
        // A column's older name may be another one's newer name.
        let columns_as_before =
            old.leaves.keys().filter(|place| is_column(place)).all(|place| new.leaves.contains_key(place));
        for (place, leaf) in &old.leaves {
            let translated = if is_column(place) && columns_as_before { place.clone() } else { translated(place) };
            // A key that has not been renamed yet has its older name.
            let found = new_left.remove_entry(translated.as_str()).or_else(|| new_left.remove_entry(place.as_str()));
            match found {
                Some((new_place, new_leaf)) => {
                    comparison.names.extend([without_numbers(place), without_numbers(new_place)]);
                    comparison.value(new_place, leaf, new_leaf);
                }
                None => drop(comparison.only_old.insert(without_numbers(place))),
            }
        }
        comparison.only_new = new_left.keys().map(|place| without_numbers(place)).collect();
        let missing = comparison.only_old.union(&comparison.only_new);
        let lists: Vec<_> = missing.filter(|name| comparison.names.contains(*name)).cloned().collect();
        comparison.different.extend(lists.iter().map(|name| format!("{name}: another number of entries")));
        if comparison.compared == 0 && !old.leaves.is_empty() {
            comparison.different.push(format!("the newer one has nothing to compare: {}", new.errors.trim()));
        }
        comparison
    }

    fn value(&mut self, place: &str, old: &Leaf, new: &Leaf) {
        if let (Leaf::Text(old), Leaf::Text(new)) = (old, new) {
            // Sentences may be put otherwise; names and hashes may not.
            if old.contains(' ') || new.contains(' ') || old.contains('/') {
                return;
            }
            self.compared += 1;
            if old != new && renamed::column(old) != *new {
                self.different.push(format!("{place}: {old} → {new}"));
            }
            return;
        }
        self.compared += 1;
        if old == new {
            return;
        }
        let (Leaf::Number(a) | Leaf::Word(a) | Leaf::Text(a)) = old;
        let (Leaf::Number(b) | Leaf::Word(b) | Leaf::Text(b)) = new;
        self.different.push(format!("{place}: {a} → {b}"));
        if let (Ok(a), Ok(b)) = (a.parse::<f64>(), b.parse::<f64>()) {
            let largest = a.abs().max(b.abs());
            let difference = if largest > 0.0 { (a - b).abs() / largest } else { 0.0 };
            self.largest_difference = self.largest_difference.max(difference);
        }
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

/// All comparisons, to be shown.
#[derive(Default)]
pub struct ResultTable {
    rows: Vec<(String, ResultComparison)>,
}

impl ResultTable {
    /// Compares what has the same name in both.
    pub fn add(&mut self, kind: &str, source: &str, old: &CommandResults, new: &CommandResults) {
        for (name, old) in old {
            let comparison = match new.iter().find(|(other, _)| other == name) {
                Some((_, new)) => ResultComparison::of(old, new),
                None => {
                    ResultComparison { different: vec!["the newer one has none".into()], ..ResultComparison::default() }
                }
            };
            let source = if source.is_empty() { String::new() } else { format!(", {source}") };
            self.rows.push((format!("{kind}: {name}{source}"), comparison));
        }
    }

    /// How many outcomes differ.
    pub fn different(&self) -> usize {
        self.rows.iter().filter(|(_, comparison)| !comparison.different.is_empty()).count()
    }

    pub fn print(&self) {
        println!("{:<60} {:>8} {:>10} {:>20}", "what", "compared", "different", "largest difference");
        for (name, comparison) in &self.rows {
            let (count, largest) = (comparison.different.len(), comparison.largest_difference);
            let verdict = if count == 0 { "equal".to_owned() } else { count.to_string() };
            println!("{name:<60} {:>8} {verdict:>10} {largest:>20.1e}", comparison.compared);
            for difference in comparison.different.iter().take(SHOWN) {
                println!("    {difference}");
            }
        }
        let all = |only: fn(&ResultComparison) -> &BTreeSet<String>| -> BTreeSet<&String> {
            self.rows.iter().flat_map(|(_, comparison)| only(comparison)).collect()
        };
        for (which, places) in [("older", all(|row| &row.only_old)), ("newer", all(|row| &row.only_new))] {
            if !places.is_empty() {
                println!("only the {which} one has:");
            }
            places.iter().for_each(|place| println!("    {place}"));
        }
    }
}

/// How many differences of one outcome are shown.
const SHOWN: usize = 5;

#[cfg(test)]
mod tests {
    use super::super::json;
    use super::*;

    fn outcome(exit_code: i32, text: &str) -> CommandResult {
        CommandResult {
            exit_code: Some(exit_code),
            leaves: json::leaves(text).unwrap_or_default(),
            errors: String::new(),
        }
    }

    fn compare(old: &str, new: &str) -> ResultComparison {
        ResultComparison::of(&outcome(0, old), &outcome(0, new))
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
        let table = |text: &str| CommandResult { exit_code: Some(0), leaves: cells(text), errors: String::new() };
        let old = table("# head: x\ntime_s,wind_x_m_s,answer_x_m_s,state\n0,1,2,running\n1,1,2.5,running\n");
        let new = table("time_s,true_wind_x_m_s,wind_x_m_s,state\n0,1,2,running\n1,1,2.25,running\n");
        let comparison = ResultComparison::of(&old, &new);
        assert_eq!(comparison.different, ["column.wind_x_m_s.1: 2.5 → 2.25"]);
        assert_eq!(comparison.compared, 8);
        assert!(ResultComparison::of(&old, &old).different.is_empty(), "before anything was renamed");
    }
}
