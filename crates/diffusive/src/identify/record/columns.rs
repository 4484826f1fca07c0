//! The columns of a file, while they are given their parts.

use std::collections::HashMap;
use std::path::Path;

use super::error::RecordError;
use recording::text::{listed, suggest};
use recording::{ColumnValues, POWER, RecordingReader, TEMPERATURE};

/// What people call the columns in which they number conditions.
const CLASS_NAMES: [&str; 6] = ["event", "class", "wind", "condition", "phase", "label"];
/// Different numbers that such a column holds at most.
const MOST_CLASSES: usize = 16;
/// More names are counted in a sentence.
const MOST_LISTED: usize = 20;

pub(super) struct FileColumns<'a> {
    path: &'a Path,
    /// Names in place of the file's own; none if it keeps them.
    given: &'a [String],
    pub names: Vec<String>,
    /// Whether each holds text.
    pub text: Vec<bool>,
    /// What a line below the names says of each, if there is one.
    pub units: Vec<String>,
    places: HashMap<String, usize>,
}

impl<'a> FileColumns<'a> {
    pub(super) fn is_called_a_class(&self, column: usize) -> bool {
        CLASS_NAMES.iter().any(|name| self.names[column].eq_ignore_ascii_case(name))
    }

    pub(super) fn of(path: &'a Path, given: &'a [String]) -> Result<Self, RecordError> {
        // Closed again before others are opened: a long file's table of contents takes megabytes.
        let mut reader = RecordingReader::open_named(path, given)?;
        let names = reader.names().to_vec();
        let places = names.iter().enumerate().map(|(at, name)| (name.clone(), at)).collect();
        Ok(Self { path, given, text: reader.holds_text()?, units: reader.units().to_vec(), names, places })
    }

    /// The first rows of a column; the text of one that holds such.
    pub(super) fn first_rows(&self, column: usize) -> Result<ColumnValues, RecordError> {
        let mut reader = RecordingReader::open_named(self.path, self.given)?;
        reader.select(&[column]);
        let values = reader.next_chunk()?.and_then(|mut columns| columns.pop()).map(|column| column.values);
        Ok(values.unwrap_or_else(|| ColumnValues::Numbers(Vec::new())))
    }

    pub(super) fn refuse(&self, sentence: impl Into<String>) -> RecordError {
        RecordError::content(self.path, sentence)
    }

    pub(super) fn position(&self, name: &str) -> Option<usize> {
        self.places.get(name).copied()
    }

    /// Power and temperature of every element that has both, in the order of the powers.
    pub(super) fn elements(&self) -> Vec<(usize, usize)> {
        let temperature = |name: &String| self.position(&format!("{TEMPERATURE}{}", name.strip_prefix(POWER)?));
        let pair = |(power, name)| Some((power, temperature(name)?));
        self.names.iter().enumerate().filter_map(pair).collect()
    }

    /// The column of that name, or of the element of that name.
    pub(super) fn named(&self, name: &str, prefixes: &[&str]) -> Result<usize, RecordError> {
        let of_element = || prefixes.iter().find_map(|prefix| self.position(&recording::column_name(prefix, name)));
        self.position(name).or_else(of_element).ok_or_else(|| {
            let columns = self.names.iter().map(String::as_str);
            let elements =
                columns.clone().filter_map(|column| prefixes.iter().find_map(|part| column.strip_prefix(part)));
            let known: Vec<&str> = elements.chain(columns).collect();
            if name.ends_with(".json") {
                return self
                    .refuse(format!("there is no column `{name}`; to write a model to that file, say -o {name}"));
            }
            self.refuse(format!("there is no column `{name}`; {}", suggest(name, known)))
        })
    }

    /// Whether a column numbers conditions, as far as its first rows tell.
    pub(super) fn holds_few_whole_numbers(&self, column: usize) -> Result<bool, RecordError> {
        let ColumnValues::Numbers(numbers) = self.first_rows(column)? else { return Ok(false) };
        let mut met: Vec<f64> = Vec::new();
        for number in numbers {
            if number.fract() != 0.0 || met.len() > MOST_CLASSES {
                return Ok(false);
            }
            if !met.contains(&number) {
                met.push(number);
            }
        }
        Ok(met.len() > 1 && met.len() <= MOST_CLASSES)
    }

    pub(super) fn all_named(&self, names: &[String], prefix: &str) -> Result<Vec<usize>, RecordError> {
        names.iter().map(|name| self.named(name, &[prefix])).collect()
    }

    pub(super) fn list(&self, columns: &[usize]) -> String {
        let names: Vec<String> = columns.iter().map(|&column| format!("`{}`", self.names[column])).collect();
        listed(&names, MOST_LISTED)
    }

    /// The candidates whose range is above `part` of the largest range; reads on until all are, or
    /// to the end.
    pub(super) fn varying(&self, candidates: &[usize], part: f64) -> Result<Vec<usize>, RecordError> {
        let mut reader = RecordingReader::open_named(self.path, self.given)?;
        reader.select(candidates);
        let mut ranges = vec![(f64::INFINITY, f64::NEG_INFINITY); candidates.len()];
        let mut varies = vec![false; candidates.len()];
        while let (false, Some(chunk)) = (varies.iter().all(|&varies| varies), reader.next_chunk()?) {
            for ((low, high), column) in ranges.iter_mut().zip(&chunk) {
                if let ColumnValues::Numbers(numbers) = &column.values {
                    *low = numbers.iter().copied().fold(*low, f64::min);
                    *high = numbers.iter().copied().fold(*high, f64::max);
                }
            }
            let largest = ranges.iter().map(|(low, high)| high - low).fold(0.0, f64::max);
            for (varies, (low, high)) in varies.iter_mut().zip(&ranges) {
                *varies = high - low > part * largest;
            }
        }
        let varying: Vec<usize> =
            candidates.iter().zip(varies).filter(|(_, varies)| *varies).map(|(&column, _)| column).collect();
        if varying.is_empty() {
            let sentence = format!(
                "{} never change{}: a model is found from the answer to changes, so record with an input that changes",
                self.list(candidates),
                if candidates.len() == 1 { "s" } else { "" }
            );
            return Err(self.refuse(sentence));
        }
        Ok(varying)
    }
}

/// The beginning of a text from a file.
pub(super) fn shown(text: &str) -> String {
    text.chars().take(40).collect()
}
