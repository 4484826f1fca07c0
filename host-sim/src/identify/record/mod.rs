//! Records for identification: any uniformly sampled table, as blocks of rows in memory that does not grow with its length.
//!
//! Row n holds the outputs y(t_n) and the inputs u held over [t_n, t_{n+1}), with t_n = t_0 + n·T. A [`Source`] hands out the rows in
//! order, as often as they are asked for: a [`Stream`] from a Parquet or CSV file, a [`Table`] from arrays. What is not uniform,
//! missing or infinite is refused with the row and the column; rows are counted from 1 below the header.
//!
//! Limits: the time written in a row may be off its place t_n by half a period, and a step off the usual one by 10 %; an event
//! column has 64 labels at most.

mod classes;
mod clock;
mod extent;
mod roles;
mod stream;
mod table;

use std::path::{Path, PathBuf};

pub use stream::Stream;
pub use table::Table;

use crate::model::Conditions;
use crate::recording::{RecordingError, one_line};

/// Rows of a block, at most.
pub const BLOCK: usize = crate::recording::CHUNK;

/// Which columns play which part. Empty is the default; an element's name stands for its power as an input and for its
/// temperature as an output or as the gas.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Selection {
    pub inputs: Vec<String>,
    pub outputs: Vec<String>,
    /// The column whose value is the event class.
    pub event: Option<String>,
    /// The column with the temperature of the gas.
    pub gas: Option<String>,
}

/// What is known of a record before its rows are read: from its head and its end.
#[derive(Debug, Clone, PartialEq)]
pub struct Survey {
    /// The file, or what a table in memory is called.
    pub path: PathBuf,
    pub time_column: String,
    /// Names of the columns, in the order of a block's.
    pub inputs: Vec<String>,
    pub outputs: Vec<String>,
    pub event_column: Option<String>,
    pub gas_column: Option<String>,
    /// Follows from the first and the last time in a CSV file until it has been read once; known otherwise.
    pub rows: u64,
    pub first_time_s: f64,
    pub last_time_s: f64,
    pub sample_period_s: f64,
    /// The gas in which it was taken, if it tells.
    pub conditions: Option<Conditions>,
    /// What was decided by default, and, once the record has been read, what was remarkable in it: sentences for the user.
    pub notes: Vec<String>,
}

/// Consecutive rows.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Block {
    /// A column for each input: held from its row's time to the next row's.
    pub inputs: Vec<Vec<f64>>,
    /// A column for each output, at the time of its row.
    pub outputs: Vec<Vec<f64>>,
    /// For every row, which of [`Source::classes`] it has.
    pub class: Vec<u32>,
    /// Gas temperature; empty without a gas column.
    pub gas: Vec<f64>,
    /// How many rows stand before the block.
    pub first_row: u64,
    /// As written in the first and the last row.
    pub time_s: (f64, f64),
}

impl Block {
    pub fn len(&self) -> usize {
        self.class.len()
    }

    pub fn is_empty(&self) -> bool {
        self.class.is_empty()
    }

    fn append(&mut self, more: &Self) {
        if self.is_empty() {
            *self = more.clone();
            return;
        }
        let columns = self.inputs.iter_mut().chain(&mut self.outputs);
        for (all, more) in columns.zip(more.inputs.iter().chain(&more.outputs)) {
            all.extend(more);
        }
        self.class.extend(&more.class);
        self.gas.extend(&more.gas);
        self.time_s.1 = more.time_s.1;
    }
}

/// A record that can be read from its start to its end, and again.
///
/// ```
/// use host_sim::identify::record::{Source, Table};
/// # fn main() -> Result<(), host_sim::identify::record::RecordError> {
/// let power_w = vec![0.0, 0.1, 0.1, 0.0];
/// let temperature_c = vec![20.0, 20.0, 20.5, 20.7];
/// let mut table = Table::new(0.01, vec![("power".into(), power_w)], vec![("temperature".into(), temperature_c)])?;
/// while let Some(block) = table.next_block()? {
///     for (power_w, temperature_c) in block.inputs[0].iter().zip(&block.outputs[0]) {
///         println!("{power_w} W, {temperature_c} °C");
///     }
/// }
/// table.restart()
/// # }
/// ```
pub trait Source {
    fn survey(&self) -> &Survey;

    /// The next rows, [`BLOCK`] of them at most; `None` after the last.
    fn next_block(&mut self) -> Result<Option<&Block>, RecordError>;

    /// Begins again with the first row.
    fn restart(&mut self) -> Result<(), RecordError>;

    /// Labels of the event classes met so far, in the order of their first appearance; complete once the record has been read.
    /// A record without labels has one class, `all`; rows without a label among others that have one are `unlabelled`.
    fn classes(&self) -> &[String];
}

#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    #[error(transparent)]
    File(#[from] RecordingError),
    #[error("{}: {sentence}", record.display())]
    Content { record: PathBuf, sentence: String },
}

impl RecordError {
    fn content(record: &Path, sentence: impl Into<String>) -> Self {
        Self::Content { record: record.to_owned(), sentence: one_line(sentence.into()) }
    }
}

/// A whole record as one block, with the labels of its classes: for records that fit in memory.
pub fn read_all(path: &Path, selection: &Selection) -> Result<(Survey, Block, Vec<String>), RecordError> {
    let mut stream = Stream::open(path, selection)?;
    let mut all = Block::default();
    while let Some(block) = stream.next_block()? {
        all.append(block);
    }
    Ok((stream.survey().clone(), all, stream.classes().to_vec()))
}

/// Refuses a value that is none, in the row counted from 1.
fn finite(record: &Path, column: &str, values: &[f64], first_row: u64) -> Result<(), RecordError> {
    // Without a branch in the loop: this runs over every value of every record.
    if values.iter().fold(true, |all, value| all & value.is_finite()) {
        return Ok(());
    }
    let at = values.iter().position(|value| !value.is_finite()).unwrap_or_default();
    let what = if values[at].is_nan() { "a value is missing" } else { "an infinite value" };
    let row = first_row + at as u64 + 1;
    let sentence = format!("row {row}, column `{column}`: {what}; cut the record there or fill the gap");
    Err(RecordError::content(record, sentence))
}

#[cfg(test)]
mod tests;
