//! A whole recording in memory: its columns by name, and its sample period.

use std::path::{Path, PathBuf};

use crate::column::{ColumnValues, ColumnWords, Metadata, RecordingColumn};
use crate::error::RecordingError;
use crate::names::{EVENT, HEATER, POWER, TEMPERATURE, TIME};
use crate::reader::RecordingReader;
use crate::text::{suggest, tidy};

/// A whole recording in memory.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// The file.
    pub path: PathBuf,
    /// Metadata of the file.
    pub metadata: Metadata,
    /// The columns, in the file's order.
    pub columns: Vec<RecordingColumn>,
}

impl Recording {
    /// Reads a whole file.
    ///
    /// # Errors
    /// If it is missing, damaged, without rows, or no table.
    pub fn read(path: &Path) -> Result<Self, RecordingError> {
        let mut reader = RecordingReader::open(path)?;
        let mut columns: Vec<RecordingColumn> = Vec::new();
        while let Some(chunk) = reader.next_chunk()? {
            if columns.is_empty() {
                columns = chunk;
                continue;
            }
            for (all, more) in columns.iter_mut().zip(chunk) {
                all.values.append(more.values).map_err(|()| RecordingError::mixed(path, &all.name))?;
            }
        }
        if columns.is_empty() {
            return Err(RecordingError::no_rows(path));
        }
        Ok(Self { path: path.to_owned(), metadata: reader.metadata(), columns })
    }

    /// The rows whose time is at least `from_s` and at most `to_s`.
    ///
    /// # Errors
    /// If it has no time.
    pub fn between(mut self, from_s: f64, to_s: f64) -> Result<Self, RecordingError> {
        let time_s = self.time_s()?;
        let rows = time_s.partition_point(|time_s| *time_s < from_s)..time_s.partition_point(|time_s| *time_s <= to_s);
        for column in &mut self.columns {
            column.values.keep(rows.start.min(rows.end)..rows.end);
        }
        Ok(self)
    }

    /// Number of rows; what is read from a file has one at least.
    pub fn len(&self) -> usize {
        self.columns.first().map_or(0, |column| column.values.len())
    }

    /// Tells whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Tells whether there is a column of that name.
    pub fn has(&self, name: &str) -> bool {
        self.columns.iter().any(|column| column.name == name)
    }

    /// Metadata of the file under a key.
    pub fn metadata(&self, key: &str) -> Option<&str> {
        self.metadata.iter().rev().find(|(known, _)| known == key).map(|(_, value)| value.as_str())
    }

    /// A column of numbers, NaN where one is missing.
    pub fn numbers(&self, name: &str) -> Result<&[f64], RecordingError> {
        match &self.column(name)?.values {
            ColumnValues::Numbers(numbers) => Ok(numbers),
            ColumnValues::Words(_) => {
                Err(RecordingError::new(&self.path, format!("column `{name}` holds text where numbers belong")))
            }
        }
    }

    /// A column of numbers of which every one is there and finite.
    pub fn finite(&self, name: &str) -> Result<&[f64], RecordingError> {
        let numbers = self.numbers(name)?;
        match numbers.iter().position(|number| !number.is_finite()) {
            None => Ok(numbers),
            Some(at) => {
                let (row, value) = (at + 1, numbers[at]);
                let sentence = format!(
                    "row {row}, column `{name}`: {value} is no value to work with; cut the record there or fill the gap"
                );
                Err(RecordingError::new(&self.path, sentence))
            }
        }
    }

    /// A column of text.
    pub fn words(&self, name: &str) -> Result<&ColumnWords, RecordingError> {
        match &self.column(name)?.values {
            ColumnValues::Words(words) => Ok(words),
            ColumnValues::Numbers(_) => {
                Err(RecordingError::new(&self.path, format!("column `{name}` holds numbers where text belongs")))
            }
        }
    }

    /// The labels of the conditions.
    pub fn events(&self) -> Option<&ColumnWords> {
        self.words(EVENT).ok()
    }

    /// The elements of a recording of ours, as their columns name them: whatever has a temperature,
    /// power or heater column.
    pub fn elements(&self) -> Vec<&str> {
        let mut elements = Vec::new();
        for column in &self.columns {
            let element = [TEMPERATURE, POWER, HEATER].iter().find_map(|prefix| column.name.strip_prefix(prefix));
            elements.extend(element.filter(|element| !elements.contains(element)));
        }
        elements
    }

    /// Parts behind a prefix in the names of columns, in their order.
    pub fn behind<'a>(&'a self, prefix: &'a str) -> impl Iterator<Item = &'a str> {
        self.columns.iter().filter_map(move |column| column.name.strip_prefix(prefix))
    }

    /// The name of the time column: `time_s`, or the first one in a foreign table.
    pub fn time_name(&self) -> &str {
        if self.has(TIME) { TIME } else { &self.columns[0].name }
    }

    /// Times of the rows in s, checked to ascend.
    pub fn time_s(&self) -> Result<&[f64], RecordingError> {
        let name = self.time_name();
        let time_s = self.finite(name)?;
        match time_s.windows(2).position(|pair| pair[1] <= pair[0]) {
            None => Ok(time_s),
            Some(at) => {
                let (row, before, after) = (at + 2, time_s[at], time_s[at + 1]);
                let sentence = format!("row {row}: `{name}` goes from {before} s to {after} s, but time must ascend");
                Err(RecordingError::new(&self.path, sentence))
            }
        }
    }

    /// The sample period in s of a uniform recording.
    ///
    /// Uniform means that no step is off the median step by more than 10 %: a written time may be
    /// rounded, a lost row may not pass.
    pub fn sample_period_s(&self) -> Result<f64, RecordingError> {
        let time_s = self.time_s()?;
        let mut steps: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        if steps.is_empty() {
            return Err(RecordingError::new(&self.path, "has one row: a sample period takes at least two"));
        }
        let middle = steps.len() / 2;
        let median = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
        if let Some(at) = time_s.windows(2).position(|pair| (pair[1] - pair[0] - median).abs() > 0.1 * median) {
            let (row, name, step) = (at + 2, self.time_name(), time_s[at + 1] - time_s[at]);
            let sentence = format!(
                "row {row}: `{name}` moves on by {} s, by {} s elsewhere; resample the record or cut it there",
                tidy(step),
                tidy(median)
            );
            return Err(RecordingError::new(&self.path, sentence));
        }
        Ok((time_s[time_s.len() - 1] - time_s[0]) / (time_s.len() - 1) as f64)
    }

    fn column(&self, name: &str) -> Result<&RecordingColumn, RecordingError> {
        self.columns.iter().find(|column| column.name == name).ok_or_else(|| {
            let names = self.columns.iter().map(|column| column.name.as_str());
            RecordingError::new(&self.path, format!("there is no column `{name}`; {}", suggest(name, names)))
        })
    }
}
