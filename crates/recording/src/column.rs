//! Columns in memory, and what every format of file can do with them.

use std::collections::HashMap;
use std::io;
use std::path::PathBuf;

use crate::error::RecordingError;
use crate::names::{EVENT, HEATER, STATE, TIME, UTC};
use crate::utc;
use crate::wind::QUALITY_FLAGS;

/// Ordered pairs of key and value; a key stands once.
pub type Metadata = Vec<(String, String)>;

/// Adds pairs to metadata; a key that is known gets the new value.
pub(crate) fn overlay(metadata: &mut Metadata, more: impl IntoIterator<Item = (String, String)>) {
    for (key, value) in more {
        match metadata.iter_mut().find(|(known, _)| *known == key) {
            Some((_, old)) => *old = value,
            None => metadata.push((key, value)),
        }
    }
}

/// Bytes that metadata take in a file, at most: no letter takes more than two.
pub(crate) fn length(metadata: &Metadata) -> u64 {
    metadata.iter().map(|(key, value)| 2 * (key.len() + value.len()) as u64 + 16).sum()
}

/// Rows that are handed on at once, at most.
pub const CHUNK: usize = 16_384;

/// A column of a chunk or of a whole recording.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordingColumn {
    /// Name, with the quantity and its unit.
    pub name: String,
    /// One value a row.
    pub values: ColumnValues,
}

/// The values of a column.
#[derive(Debug, Clone, PartialEq)]
pub enum ColumnValues {
    /// A missing number is NaN.
    Numbers(Vec<f64>),
    /// Text.
    Words(ColumnWords),
}

/// Text that repeats: each word once, and which one a row has.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ColumnWords {
    dictionary: Vec<String>,
    rows: Vec<u32>,
    known: HashMap<String, u32>,
}

impl ColumnWords {
    /// Adds a row.
    pub fn push(&mut self, word: &str) {
        // Neighbours are alike most of the time.
        if let Some(&last) = self.rows.last().filter(|&&last| self.dictionary[last as usize] == word) {
            self.rows.push(last);
            return;
        }
        let code = match self.known.get(word) {
            Some(&code) => code,
            None => {
                let code = u32::try_from(self.dictionary.len()).expect("a recording of fewer than 2^32 rows");
                self.dictionary.push(word.to_owned());
                self.known.insert(word.to_owned(), code);
                code
            }
        };
        self.rows.push(code);
    }

    /// Takes the last row away.
    pub(crate) fn drop_last(&mut self) {
        self.rows.pop();
    }

    /// The different words, in the order of their first appearance.
    pub fn dictionary(&self) -> &[String] {
        &self.dictionary
    }

    /// For every row, which word of the dictionary it has.
    pub fn codes(&self) -> &[u32] {
        &self.rows
    }

    /// Seconds since 1970 of moments, NaN of none; or the first row that is no moment.
    pub(crate) fn seconds(&self) -> Result<Vec<f64>, usize> {
        let moment = |word: &String| if word.is_empty() { Some(f64::NAN) } else { Some(utc::from_text(word)?.0) };
        let known: Vec<Option<f64>> = self.dictionary.iter().map(moment).collect();
        let codes = self.rows.iter().enumerate();
        codes.map(|(row, &code)| known[code as usize].ok_or(row)).collect()
    }

    /// The word of a row.
    pub fn word(&self, row: usize) -> &str {
        &self.dictionary[self.rows[row] as usize]
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Tells whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The word of every row.
    pub fn iter(&self) -> impl Iterator<Item = &str> {
        self.rows.iter().map(|&code| self.dictionary[code as usize].as_str())
    }

    /// Stretches of rows with the same word: `(first row, one past the last, word)`.
    pub fn stretches(&self) -> impl Iterator<Item = (usize, usize, &str)> {
        let mut start = 0;
        self.rows.chunk_by(|a, b| a == b).map(move |stretch| {
            let from = start;
            start += stretch.len();
            (from, start, self.dictionary[stretch[0] as usize].as_str())
        })
    }
}

impl ColumnValues {
    /// Number of rows.
    pub fn len(&self) -> usize {
        match self {
            Self::Numbers(numbers) => numbers.len(),
            Self::Words(words) => words.len(),
        }
    }

    /// Some of the rows.
    pub(crate) fn between(&self, rows: std::ops::Range<usize>) -> Self {
        match self {
            Self::Numbers(numbers) => Self::Numbers(numbers[rows].to_vec()),
            Self::Words(ColumnWords { dictionary, rows: all, known }) => Self::Words(ColumnWords {
                dictionary: dictionary.clone(),
                rows: all[rows].to_vec(),
                known: known.clone(),
            }),
        }
    }

    /// Keeps some of the rows only.
    pub(crate) fn keep(&mut self, rows: std::ops::Range<usize>) {
        *self = self.between(rows);
    }

    /// Keeps the first of two rows; an odd last one stays.
    pub(crate) fn keep_every_second(&mut self) {
        match self {
            Self::Numbers(numbers) => *numbers = numbers.chunks(2).map(|pair| pair[0]).collect(),
            Self::Words(words) => words.rows = words.rows.chunks(2).map(|pair| pair[0]).collect(),
        }
    }

    /// Tells whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub(crate) fn empty(holds_text: bool) -> Self {
        if holds_text { Self::Words(ColumnWords::default()) } else { Self::Numbers(Vec::new()) }
    }

    /// Adds a cell of the column's kind.
    pub(crate) fn push(&mut self, cell: RowCell<'_>) {
        match (self, cell) {
            (Self::Numbers(numbers), RowCell::Number(number)) => numbers.push(number),
            (Self::Words(words), RowCell::Text(word)) => words.push(word),
            (Self::Numbers(_), RowCell::Text(_)) | (Self::Words(_), RowCell::Number(_)) => {}
        }
    }

    pub(crate) fn append(&mut self, more: Self) -> Result<(), ()> {
        match (self, more) {
            (Self::Numbers(all), Self::Numbers(more)) => all.extend(more),
            (Self::Words(all), Self::Words(more)) => more.iter().for_each(|word| all.push(word)),
            _ => return Err(()),
        }
        Ok(())
    }
}

/// Form in which a column is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ColumnKind {
    /// f64.
    Wide,
    /// A moment, in memory the seconds since 1970.
    Utc,
    /// f32.
    Number,
    /// 0 or 1.
    Bit,
    /// A whole number, or none.
    Flags,
    Text,
}

impl ColumnKind {
    /// The kind that a column of a recording has by its name.
    pub(crate) fn of(name: &str) -> Self {
        match name {
            TIME => Self::Wide,
            UTC => Self::Utc,
            EVENT | STATE => Self::Text,
            QUALITY_FLAGS => Self::Flags,
            name if name.starts_with(HEATER) => Self::Bit,
            _ => Self::Number,
        }
    }

    /// Tells whether a missing number is none in the file, and no NaN.
    #[cfg(feature = "parquet")]
    pub(crate) const fn is_optional(self) -> bool {
        matches!(self, Self::Flags)
    }

    /// Columns of a recording with their kinds.
    pub(crate) fn of_each(names: impl IntoIterator<Item = String>) -> Vec<(String, Self)> {
        names.into_iter().map(|name| (name.clone(), Self::of(&name))).collect()
    }

    /// Bytes of a value that is not compressed, about.
    #[cfg(feature = "parquet")]
    pub(crate) const fn bytes(self) -> u64 {
        if matches!(self, Self::Wide | Self::Utc) { 8 } else { 4 }
    }
}

/// A value on its way into a file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum RowCell<'a> {
    /// A missing number is NaN.
    Number(f64),
    Text(&'a str),
}

/// A row of columns.
pub(crate) fn cells_of_row(columns: &[RecordingColumn], row: usize) -> impl Iterator<Item = RowCell<'_>> {
    columns.iter().map(move |column| match &column.values {
        ColumnValues::Numbers(numbers) => RowCell::Number(numbers[row]),
        ColumnValues::Words(words) => RowCell::Text(words.word(row)),
    })
}

/// The writer of a format: rows go in, cell by cell in the order of the columns.
pub(crate) trait RowSink {
    fn push(&mut self, cells: &mut dyn Iterator<Item = RowCell<'_>>) -> io::Result<()>;
    /// Hands what waits in memory to the system, as far as the format can.
    fn flush(&mut self) -> io::Result<()>;
    /// Length of the rows so far, at most.
    fn bytes(&self) -> u64;
    /// Length of what stands around the rows, at most.
    fn frame_bytes(&self) -> u64;
    fn finish(self: Box<Self>, metadata: &Metadata) -> io::Result<()>;
}

/// Knowledge of a reader about its file, whatever the format.
pub(crate) struct TableHead {
    pub path: PathBuf,
    /// Names of the columns, in the file's order.
    pub names: Vec<String>,
    /// The columns that are handed out, in their order.
    pub selected: Vec<usize>,
}

impl TableHead {
    pub fn damaged(&self, reason: impl std::fmt::Display) -> RecordingError {
        RecordingError::damaged(&self.path, reason)
    }
}

/// The reader of a format: what [`crate::RecordingReader`] says of each of these holds here.
pub(crate) trait ChunkSource {
    fn metadata(&self) -> Metadata;
    fn rows(&self) -> Option<u64> {
        None
    }
    fn units(&self) -> &[String] {
        &[]
    }
    fn holds_text(&mut self, head: &TableHead) -> Result<Vec<bool>, RecordingError>;
    /// Parquet and tables in memory have types.
    fn read_as_text(&mut self, _column: usize) {}
    fn read_as_time(&mut self, column: usize);
    fn skip(&mut self, rows: u64, head: &TableHead) -> Result<u64, RecordingError>;
    fn next_chunk(&mut self, head: &TableHead) -> Result<Option<Vec<ColumnValues>>, RecordingError>;
}
