//! The rows of one or more files as they stand there, again and again.
//!
//! A record that is not too long is kept in memory, so that its text is read once; the memory for
//! it does not grow with its length.

use std::path::PathBuf;

use super::bridge::{BridgedColumn, bridge, insert_rows, unmark};
use super::columns::shown;
use super::error::RecordError;
use super::roles::Roles;
use super::source::Selection;
use super::times::TimeUnit;
use recording::{ColumnValues, Metadata, RecordingReader};

/// Cells that are kept at most: 32 MiB of numbers.
const MOST_CELLS: usize = 1 << 22;

/// Consecutive rows of a file.
#[derive(Debug, Clone)]
pub(super) struct RawRows {
    pub file: usize,
    /// In its file, from 0.
    pub first_row: u64,
    /// NaN where it is missing.
    pub time_s: Vec<f64>,
    /// As [`RecordFiles::slot`] numbers them; that of the times is empty.
    pub columns: Vec<ColumnValues>,
    /// Rows that the file lacks, ascending.
    pub inserted: Vec<usize>,
}

impl RawRows {
    /// Number of a row in its file, from 1.
    pub(super) fn number(&self, row: usize) -> u64 {
        self.first_row + (row - self.inserted.partition_point(|&inserted| inserted <= row)) as u64 + 1
    }
}

pub(super) struct RecordFiles {
    pub paths: Vec<PathBuf>,
    given: Vec<String>,
    pub time_column: String,
    time_is_text: bool,
    unit: TimeUnit,
    /// Of a table without times.
    period_s: Option<f64>,
    event: Option<usize>,
    inputs: Vec<usize>,
    /// Missing rows may be inserted: not where a gas that is an output would lack.
    may_insert: bool,
    /// Columns whose missing values may be filled, and how many were.
    bridged: Vec<(usize, BridgedColumn)>,
    filled: Vec<u64>,
    /// Rows that the files lack and that follow, and their gaps in time.
    pub inserted: u64,
    pub bridged_gaps: u64,
    /// By column that is read: values that a marker makes missing.
    marked: Vec<u64>,
    /// The columns that are read, each once; the time first, if it has one.
    columns: Vec<usize>,
    names: Vec<String>,
    next: usize,
    reader: Option<RecordingReader>,
    row: u64,
    kept: Vec<RawRows>,
    cells: usize,
    /// Whether all rows are kept, or will be.
    is_kept: bool,
    is_whole: bool,
}

impl RecordFiles {
    pub(super) fn new(paths: &[PathBuf], roles: &Roles, selection: &Selection) -> Result<Self, RecordError> {
        let mut columns: Vec<usize> = roles.time.column.into_iter().collect();
        let others =
            roles.inputs.iter().chain(&roles.outputs).chain(&roles.event).chain(&roles.gas).chain(&roles.state);
        for &column in others {
            if !columns.contains(&column) {
                columns.push(column);
            }
        }
        let bridged: Vec<(usize, BridgedColumn)> = roles
            .inputs
            .iter()
            .map(|&input| (input, BridgedColumn::Input))
            .chain(roles.gas.filter(|gas| !roles.outputs.contains(gas)).map(|gas| (gas, BridgedColumn::Gas)))
            .collect();
        let mut files = Self {
            filled: vec![0; bridged.len()],
            inserted: 0,
            bridged_gaps: 0,
            marked: vec![0; columns.len()],
            bridged,
            paths: paths.to_vec(),
            given: selection.columns.clone(),
            time_column: String::new(),
            time_is_text: roles.time.is_text,
            unit: roles.time.unit,
            period_s: selection.sample_period_s,
            event: roles.event,
            inputs: roles.inputs.clone(),
            may_insert: roles.gas.is_none_or(|gas| !roles.outputs.contains(&gas)),
            columns,
            names: Vec::new(),
            next: 0,
            reader: None,
            row: 0,
            kept: Vec::new(),
            cells: 0,
            is_kept: true,
            is_whole: false,
        };
        let first = files.open(0)?;
        files.is_kept =
            first.rows().is_none_or(|rows| rows.saturating_mul(files.columns.len() as u64) < MOST_CELLS as u64);
        files.names = first.names().to_vec();
        files.time_column = roles.time.column.map(|time| files.names[time].clone()).unwrap_or_default();
        for at in 1..paths.len() {
            files.open(at)?;
        }
        Ok(files)
    }

    /// The same without rows that are inserted where they follow.
    pub(super) fn without_insertion(self) -> Self {
        Self { may_insert: false, ..self }
    }

    /// Names of columns in which missing values were filled, and how many.
    pub(super) fn filled(&self) -> impl Iterator<Item = (&str, u64)> {
        let filled = self.bridged.iter().zip(&self.filled).filter(|(_, filled)| **filled > 0);
        filled.map(|((column, _), &filled)| (self.names[*column].as_str(), filled))
    }

    /// Names of columns in which markers stand for missing values, and how many.
    pub(super) fn marked(&self) -> impl Iterator<Item = (&str, u64)> {
        let marked = self.columns.iter().zip(&self.marked).filter(|(_, marked)| **marked > 0);
        marked.map(|(&column, &marked)| (self.names[column].as_str(), marked))
    }

    /// What the first file says of itself.
    pub(super) fn metadata(&self) -> Result<Metadata, RecordError> {
        Ok(RecordingReader::open_named(&self.paths[0], &self.given)?.metadata())
    }

    pub(super) fn names(&self) -> &[String] {
        &self.names
    }

    /// Which of the columns that are read one is.
    pub(super) fn slot(&self, column: usize) -> usize {
        self.columns.iter().position(|&read| read == column).unwrap_or_default()
    }

    /// Begins again.
    pub(super) fn restart(&mut self) {
        (self.next, self.row, self.reader) = (0, 0, None);
        if !self.is_whole {
            self.filled.fill(0);
            self.marked.fill(0);
            (self.inserted, self.bridged_gaps) = (0, 0);
            self.kept.clear();
            self.cells = 0;
        }
    }

    fn open(&self, file: usize) -> Result<RecordingReader, RecordError> {
        let path = &self.paths[file];
        let mut reader = RecordingReader::open_named(path, &self.given)?;
        if let Some((name, first)) = reader.names().iter().zip(&self.names).find(|(name, first)| name != first) {
            let first_path = self.paths[0].display();
            let sentence =
                format!("has `{name}` where {first_path} has `{first}`: files of one record have the same columns");
            return Err(RecordError::content(path, sentence));
        }
        let wanted = self.names.len();
        if file > 0 && reader.names().len() != wanted {
            let sentence =
                format!("has {} columns, and {} has {wanted}", reader.names().len(), self.paths[0].display());
            return Err(RecordError::content(path, sentence));
        }
        reader.select(&self.columns);
        if let Some(event) = self.event {
            reader.read_as_text(event);
        }
        if let (true, Some(&time)) = (self.time_is_text, self.columns.first()) {
            reader.read_as_time(time);
        }
        Ok(reader)
    }

    /// The next rows, those of one file; `None` after the last.
    pub(super) fn next_rows(&mut self) -> Result<Option<RawRows>, RecordError> {
        if self.is_whole {
            let rows = self.kept.get(self.next).cloned();
            self.next += 1;
            return Ok(rows);
        }
        loop {
            if self.next == self.paths.len() {
                self.is_whole = self.is_kept;
                return Ok(None);
            }
            let mut reader = match self.reader.take() {
                Some(reader) => reader,
                None => self.open(self.next)?,
            };
            let Some(chunk) = reader.next_chunk()? else {
                refuse_if!(self.row == 0, RecordError::content(&self.paths[self.next], "has columns but no rows"));
                (self.next, self.row) = (self.next + 1, 0);
                continue;
            };
            self.reader = Some(reader);
            let columns = chunk.into_iter().map(|column| column.values).collect();
            let mut rows = self.raw(columns)?;
            let read = rows.time_s.len();
            for (marked, column) in self.marked.iter_mut().zip(&mut rows.columns) {
                if let ColumnValues::Numbers(values) = column {
                    *marked += unmark(values);
                }
            }
            let inputs: Vec<usize> = self.inputs.iter().map(|&input| self.slot(input)).collect();
            if self.may_insert {
                self.bridged_gaps += insert_rows(&mut rows, &inputs);
            }
            self.inserted += rows.inserted.len() as u64;
            for at in 0..self.bridged.len() {
                let (column, how) = self.bridged[at];
                if let ColumnValues::Numbers(values) = &mut rows.columns[self.slot(column)] {
                    self.filled[at] += bridge(values, how);
                }
            }
            self.row += read as u64;
            self.cells += rows.time_s.len() * self.columns.len();
            self.is_kept &= self.cells <= MOST_CELLS;
            if self.is_kept {
                self.kept.push(rows.clone());
            } else {
                self.kept = Vec::new();
            }
            return Ok(Some(rows));
        }
    }

    fn raw(&self, mut columns: Vec<ColumnValues>) -> Result<RawRows, RecordError> {
        let (file, first_row) = (self.next, self.row);
        if let Some(period_s) = self.period_s {
            let rows = columns.first().map_or(0, ColumnValues::len) as u64;
            let time_s = (first_row..first_row + rows).map(|row| row as f64 * period_s).collect();
            return Ok(RawRows { file, first_row, time_s, columns, inserted: Vec::new() });
        }
        let (path, name, unit) = (&self.paths[file], &self.time_column, self.unit);
        let mut time_s = std::mem::take(numbers(path, name, &mut columns[0], first_row)?);
        if unit != TimeUnit::Second {
            time_s.iter_mut().for_each(|time| *time = unit.seconds(*time));
        }
        Ok(RawRows { file, first_row, time_s, columns, inserted: Vec::new() })
    }
}

/// The values of a column that must be numbers.
pub(super) fn numbers<'c>(
    path: &std::path::Path,
    name: &str,
    column: &'c mut ColumnValues,
    first_row: u64,
) -> Result<&'c mut Vec<f64>, RecordError> {
    match column {
        ColumnValues::Numbers(numbers) => Ok(numbers),
        ColumnValues::Words(words) => {
            let text = shown(words.iter().next().unwrap_or_default());
            Err(RecordError::value(path, name, first_row, format!("`{text}` stands where a number belongs")))
        }
    }
}
