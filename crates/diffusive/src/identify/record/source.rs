//! What identification asks of a record: named columns, rows in blocks, and labels of the
//! conditions.
//!
//! Row n holds the outputs y(t_n) and the inputs u held over [t_n, t_{n+1}), with t_n = t_0 + n·T, or
//! with times of its own.

use std::fmt::Display;
use std::ops::Range;
use std::path::PathBuf;

use super::error::RecordError;
use super::times::TimeUnit;
use crate::model::Conditions;

/// Rows of a block, at most.
pub const BLOCK: usize = recording::CHUNK;

/// Which columns play which part. Empty is the default; an element's name stands for its power as
/// an input and for its temperature as an output or as the gas.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Selection {
    /// Heating powers, in the order wanted.
    pub inputs: Vec<String>,
    /// Temperatures, in the order wanted.
    pub outputs: Vec<String>,
    /// The column whose value is the event class.
    pub event: Option<String>,
    /// The column with the temperature of the gas.
    pub gas: Option<String>,
    /// Names of all columns, for a table that has none, or in place of its own.
    pub columns: Vec<String>,
    /// The unit of the times; by default what their column's name says, or seconds.
    pub time_unit: Option<TimeUnit>,
    /// Distance of the rows in time, s, for a table without times.
    pub sample_period_s: Option<f64>,
}

/// What is known of a record before its rows are handed out.
#[derive(Debug, Clone, PartialEq)]
pub struct Survey {
    /// The file, or what a table in memory is called.
    pub path: PathBuf,
    /// All files, in the order of their rows.
    pub paths: Vec<PathBuf>,
    /// Name of the column of times; none if the rows are counted.
    pub time_column: String,
    /// Names of the columns, in the order of a block's.
    pub inputs: Vec<String>,
    /// Likewise.
    pub outputs: Vec<String>,
    /// The column with the labels of the conditions.
    pub event_column: Option<String>,
    /// The column with the temperature of the gas.
    pub gas_column: Option<String>,
    /// Over all segments.
    pub rows: u64,
    /// Stretches of rows that follow each other in time: one more than there are gaps.
    pub segments: u64,
    /// Rows of the longest of them.
    pub longest_rows: u64,
    /// When the first row was taken, in RFC 3339, if the record tells.
    pub start_utc: Option<String>,
    /// Time of the first row.
    pub first_time_s: f64,
    /// Time of the last row, in its file.
    pub last_time_s: f64,
    /// Mean distance of rows in time; of an uneven record the shortest after a move of an input.
    pub sample_period_s: f64,
    /// Rows stand at times of their own, on no uniform grid.
    pub is_uneven: bool,
    /// The gas in which it was taken, if it tells.
    pub conditions: Option<Conditions>,
    /// What was decided by default, and, once the record has been read, what was remarkable in it:
    /// sentences for the user.
    pub notes: Vec<String>,
}

impl Survey {
    /// How long the record is, without its gaps.
    pub fn duration_s(&self) -> f64 {
        if self.is_uneven { self.last_time_s - self.first_time_s } else { self.rows as f64 * self.sample_period_s }
    }

    /// How long its longest segment is. Each begins with anything, so that nothing slower shows in
    /// a record, however many there are.
    pub fn longest_s(&self) -> f64 {
        if self.is_uneven { self.duration_s() } else { self.longest_rows as f64 * self.sample_period_s }
    }

    /// Banks of relaxations that inputs drive in so many classes, and measured surroundings.
    pub(in crate::identify) fn driven_banks(&self, classes: usize) -> usize {
        self.inputs.len() * classes + usize::from(self.gas_column.is_some())
    }

    /// Why the record cannot be used: a sentence that goes on behind its name.
    pub(crate) fn refuse(&self, sentence: impl Into<String>) -> RecordError {
        RecordError::content(&self.path, sentence)
    }

    /// Refuses the record where something is as it must not be.
    pub(crate) fn refuse_if(&self, wrong: bool, sentence: impl Display) -> Result<(), RecordError> {
        if wrong { Err(self.refuse(sentence.to_string())) } else { Ok(()) }
    }
}

/// Consecutive rows.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Block {
    /// A column for each input: held from its row's time to the next row's.
    pub inputs: Vec<Vec<f64>>,
    /// A column for each output, at the time of its row.
    pub outputs: Vec<Vec<f64>>,
    /// For every row, which of [`RecordSource::classes`] it has.
    pub class: Vec<u32>,
    /// Gas temperature; empty without a gas column.
    pub gas: Vec<f64>,
    /// As written in the first and the last row.
    pub time_s: (f64, f64),
    /// Whether nothing is known of the time between the row before and the first of these; false in
    /// a record's first block. A block never goes beyond its segment.
    pub begins_segment: bool,
    /// Rows, ascending, in which an output is missing: it has its last value there.
    pub missing: Vec<u32>,
    /// Time from each row to the next, s, in an uneven record; else empty.
    pub interval_s: Vec<f64>,
}

impl Block {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.class.len()
    }

    /// Whether it has no rows.
    pub fn is_empty(&self) -> bool {
        self.class.is_empty()
    }

    /// Some of its rows; they begin a segment if they are the first of one.
    pub(in crate::identify) fn rows(&self, rows: Range<usize>) -> Self {
        let cut = |columns: &[Vec<f64>]| columns.iter().map(|values| values[rows.clone()].to_vec()).collect();
        let missing = self.missing.iter().map(|row| *row as usize).filter(|row| rows.contains(row));
        Self {
            inputs: cut(&self.inputs),
            outputs: cut(&self.outputs),
            class: self.class[rows.clone()].to_vec(),
            gas: self.gas.get(rows.clone()).map_or(Vec::new(), <[f64]>::to_vec),
            time_s: self.time_s,
            begins_segment: self.begins_segment && rows.start == 0,
            missing: missing.map(|row| (row - rows.start) as u32).collect(),
            interval_s: self.interval_s.get(rows.clone()).map_or(Vec::new(), <[f64]>::to_vec),
        }
    }

    /// Adds the rows of the block that follows.
    pub(in crate::identify) fn append(&mut self, more: &Self) {
        if self.is_empty() {
            *self = more.clone();
            return;
        }
        let rows = self.len() as u32;
        self.missing.extend(more.missing.iter().map(|row| rows + row));
        let columns = self.inputs.iter_mut().chain(&mut self.outputs);
        for (all, more) in columns.zip(more.inputs.iter().chain(&more.outputs)) {
            all.extend(more);
        }
        self.class.extend(&more.class);
        self.gas.extend(&more.gas);
        self.interval_s.extend(&more.interval_s);
        self.time_s.1 = more.time_s.1;
    }
}

/// The values of one row.
pub(in crate::identify) fn copy_row(columns: &[Vec<f64>], at: usize, row: &mut [f64]) {
    for (value, column) in row.iter_mut().zip(columns) {
        *value = column[at];
    }
}

/// A record that can be read from its start to its end, and again.
///
/// ```
/// use diffusive::identify::record::{RecordSource, RecordTable};
/// # fn main() -> Result<(), diffusive::identify::record::RecordError> {
/// let power_w = vec![("power".into(), vec![0.0, 0.1, 0.1, 0.0])];
/// let temperature_c = vec![("temperature".into(), vec![20.0, 20.0, 20.5, 20.7])];
/// let mut table = RecordTable::new(0.01, power_w, temperature_c)?;
/// while let Some(block) = table.next_block()? {
///     for (power_w, temperature_c) in block.inputs[0].iter().zip(&block.outputs[0]) {
///         println!("{power_w} W, {temperature_c} °C");
///     }
/// }
/// table.restart()
/// # }
/// ```
pub trait RecordSource {
    /// What is known of the record.
    fn survey(&self) -> &Survey;

    /// The next rows, [`BLOCK`] of them at most; `None` after the last.
    fn next_block(&mut self) -> Result<Option<&Block>, RecordError>;

    /// Begins again with the first row.
    fn restart(&mut self) -> Result<(), RecordError>;

    /// Labels of the event classes met so far, in the order of their first appearance; complete
    /// once the record has been read. A record without labels has one class, `all`; rows without a
    /// label among others that have one are `unlabelled`.
    fn classes(&self) -> &[String];
}
