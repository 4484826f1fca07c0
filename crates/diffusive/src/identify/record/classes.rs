//! Event classes: the labels of an event column, numbered in the order of their first appearance.

use std::collections::HashMap;
use std::ops::Range;
use std::path::Path;

use recording::ColumnValues;

use super::error::RecordError;

/// More labels than this are measured values, not conditions.
const MOST: usize = 64;

const ALL: &str = "all";
const UNLABELLED: &str = "unlabelled";

pub(super) struct Classes {
    names: Vec<String>,
    known: HashMap<String, u32>,
}

impl Classes {
    /// Of a record without an event column.
    pub(super) fn none() -> Self {
        Self { names: vec![ALL.to_owned()], known: HashMap::new() }
    }

    /// Of a record with one: they grow as its labels are met.
    pub(super) fn growing() -> Self {
        Self { names: Vec::new(), known: HashMap::new() }
    }

    pub(super) fn names(&self) -> &[String] {
        &self.names
    }

    /// The classes of some of the next rows, in place of what `into` held.
    pub(super) fn fill(
        &mut self,
        record: &Path,
        column: &str,
        first_row: u64,
        labels: &ColumnValues,
        rows: Range<usize>,
        into: &mut Vec<u32>,
    ) -> Result<(), RecordError> {
        let refuse = |row: usize, what: &str| RecordError::value(record, column, first_row + row as u64, what);
        into.clear();
        match labels {
            ColumnValues::Words(words) => {
                let mut classes = vec![None; words.dictionary().len()];
                for (row, &code) in rows.clone().zip(&words.codes()[rows]) {
                    let class = match classes[code as usize] {
                        Some(class) => class,
                        None => self.class(&words.dictionary()[code as usize], |what| refuse(row, what))?,
                    };
                    classes[code as usize] = Some(class);
                    into.push(class);
                }
            }
            ColumnValues::Numbers(numbers) => {
                let mut last = None;
                for (row, &number) in rows.clone().zip(&numbers[rows]) {
                    let class = match last {
                        Some((same, class)) if same == number => class,
                        _ if number.is_finite() => self.class(&number.to_string(), |what| refuse(row, what))?,
                        _ => return Err(refuse(row, "a label is missing; fill the gap or cut the record there")),
                    };
                    last = Some((number, class));
                    into.push(class);
                }
            }
        }
        Ok(())
    }

    fn class(&mut self, label: &str, refuse: impl Fn(&str) -> RecordError) -> Result<u32, RecordError> {
        // As in a Parquet file, where 1 and 1.0 are the same number.
        let number = label.parse().ok().filter(|number: &f64| number.is_finite());
        let label = match number {
            Some(number) => number.to_string(),
            None if label.is_empty() => UNLABELLED.to_owned(),
            None => label.to_owned(),
        };
        if let Some(&class) = self.known.get(&label) {
            return Ok(class);
        }
        refuse_if!(
            self.names.len() == MOST,
            refuse(&format!(
                "`{label}` is label number {}: a column of event classes has {MOST} labels at most, so name another column or none",
                MOST + 1
            ))
        );
        // Rows without a label are special only beside others that have one.
        match self.names.as_mut_slice() {
            [] if label == UNLABELLED => self.names.push(ALL.to_owned()),
            [first] if self.known.contains_key(UNLABELLED) => {
                UNLABELLED.clone_into(first);
                self.names.push(label.clone());
            }
            _ => self.names.push(label.clone()),
        }
        let class = self.names.len() as u32 - 1;
        self.known.insert(label, class);
        Ok(class)
    }
}
