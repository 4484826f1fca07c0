//! Reading tables of text: recordings of ours, and what loggers write.
//!
//! A first line of values alone names no columns: their names are given, or the table is refused.
//! A second line of words above numbers holds the units. A separator may stand behind the last
//! cell of every row.

use std::fs::File;
use std::path::Path;

use crate::column::{CHUNK, ChunkSource, ColumnValues, Metadata, RowCell, TableHead};
use crate::csv_lines::{BLANK, CsvLines, Dialect, without_runs};
use crate::error::RecordingError;
use crate::names::{EVENT, STATE, UTC};
use crate::utc;

/// Lines that show how a table is written: so many, or those of the first bytes if there are a few.
const LINES: usize = 34;
const FEW: usize = 4;
const BYTES: usize = 1 << 16;
/// A longer word in the second line is no unit.
const LONGEST_UNIT: usize = 12;
/// Without names, more columns than these are not listed as an example.
const MOST_LISTED: usize = 8;

pub(crate) struct CsvReader {
    csv: csv::Reader<CsvLines>,
    dialect: Dialect,
    record: csv::StringRecord,
    /// Kind of each column, by its first value.
    kinds: Vec<CellKind>,
    /// Units of the line below the names.
    units: Vec<String>,
    /// The next row was looked at and has not been handed out.
    pending: bool,
    rows: u64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum CellKind {
    /// No cell has told yet.
    Unknown,
    Number,
    Moment,
    Text,
}

impl CsvReader {
    /// The reader, and the names of the columns; where others are given, the file may have none.
    pub(crate) fn open(
        file: File,
        path: &Path,
        may_be_torn: bool,
        given: &[String],
    ) -> Result<(Box<dyn ChunkSource>, Vec<String>), RecordingError> {
        let damaged = |error: &dyn std::fmt::Display| RecordingError::damaged(path, error);
        let mut lines = CsvLines::new(file, may_be_torn).map_err(|error| damaged(&error))?;
        // A journal is ours, and its end may be at once.
        let first =
            if may_be_torn { Vec::new() } else { lines.look_ahead(LINES, FEW, BYTES).map_err(|e| damaged(&e))? };
        let dialect = Dialect::of(&first);
        let has_runs = dialect.delimiter == BLANK;
        if has_runs {
            lines.replace_runs();
        }
        let mut builder = csv::ReaderBuilder::new();
        let delimiter = if has_runs { b'\t' } else { dialect.delimiter };
        builder.has_headers(false).flexible(true).trim(csv::Trim::All).delimiter(delimiter);
        let probe = probe(&builder, first, has_runs);
        let mut reader = Self {
            csv: builder.from_reader(lines),
            dialect,
            record: csv::StringRecord::new(),
            kinds: Vec::new(),
            units: Vec::new(),
            pending: false,
            rows: 0,
        };
        let names = reader.take_names(path, given)?;
        let above = usize::from(!reader.pending);
        reader.take_units(probe.get(above..).unwrap_or_default()).map_err(|error| damaged(&reworded(&error)))?;
        let known = if given.len() == names.len() { given } else { &names };
        reader.kinds = known.iter().map(|name| CellKind::of_name(name)).collect();
        let rows = probe.get(above + usize::from(!reader.units.is_empty())..).unwrap_or_default();
        rows.iter().for_each(|row| reader.learn_kinds(row));
        Ok((Box::new(reader), names))
    }

    /// The names in the first row, which is one of values where others are given.
    fn take_names(&mut self, path: &Path, given: &[String]) -> Result<Vec<String>, RecordingError> {
        let refuse = |sentence: String| Err(RecordingError::new(path, sentence));
        let more = self.csv.read_record(&mut self.record);
        more.map_err(|error| RecordingError::damaged(path, reworded(&error)))?;
        let mut names: Vec<String> = self.record.iter().map(str::to_owned).collect();
        if names.len() > 1 && names.last().is_some_and(String::is_empty) {
            names.pop();
        }
        if names.is_empty() {
            return refuse("is empty: a line with the columns' names belongs first".to_owned());
        }
        self.pending = names.iter().all(|name| self.dialect.is_value(name));
        if !given.is_empty() {
            return Ok(names);
        }
        if self.pending {
            let example = example_names(names.len());
            return refuse(format!(
                "begins with numbers: a line with the columns' names belongs first, or say their {} names, such as --columns {example}",
                names.len()
            ));
        }
        // pandas writes its index so.
        if names.len() > 1 && names[0].is_empty() && !names.iter().any(|name| name == "index") {
            "index".clone_into(&mut names[0]);
        }
        match names.iter().position(String::is_empty) {
            Some(at) => refuse(format!("column {} has no name", at + 1)),
            None => Ok(names),
        }
    }

    /// Passes over a line of units below the names: words where the next row has numbers.
    fn take_units(&mut self, rows: &[csv::StringRecord]) -> csv::Result<()> {
        let [units, row, ..] = rows else { return Ok(()) };
        let is_value = |cell: &str| self.dialect.is_value(cell);
        let is_unit = |cell: &str| cell.is_empty() || !is_value(cell) && cell.chars().count() <= LONGEST_UNIT;
        let stands_above = |(unit, cell): (&str, &str)| !unit.is_empty() && !cell.is_empty() && is_value(cell);
        if !self.pending && units.iter().all(is_unit) && units.iter().zip(row).any(stands_above) {
            self.csv.read_record(&mut self.record)?;
            self.units = self.record.iter().map(str::to_owned).collect();
        }
        Ok(())
    }

    /// Learns from a row about the columns of which nothing was known.
    fn learn_kinds(&mut self, row: &csv::StringRecord) {
        for (kind, cell) in self.kinds.iter_mut().zip(row) {
            if *kind == CellKind::Unknown {
                *kind = match self.dialect.number(cell) {
                    Some(number) if number.is_nan() => CellKind::Unknown,
                    Some(_) => CellKind::Number,
                    None => CellKind::Text,
                };
            }
        }
    }

    /// Takes the next row into `record`.
    fn next_row(&mut self, head: &TableHead) -> Result<bool, RecordingError> {
        if !std::mem::take(&mut self.pending) {
            let more = self.csv.read_record(&mut self.record).map_err(|error| head.damaged(reworded(&error)))?;
            if !more {
                return Ok(false);
            }
        }
        self.rows += 1;
        let (found, wanted) = (self.record.len(), head.names.len());
        if found != wanted && !(found == wanted + 1 && self.record[wanted].is_empty()) {
            let line = at_line(self.record.position());
            return Err(head.damaged(format!("a row has {found} fields where the header names {wanted} columns{line}")));
        }
        Ok(true)
    }

    /// A cell that is no plain number.
    fn unusual(&self, kind: CellKind, cell: &str) -> Option<f64> {
        let moment = || utc::from_text(cell).filter(|_| kind == CellKind::Moment).map(|(seconds, _)| seconds);
        self.dialect.number(cell).or_else(moment)
    }
}

impl CellKind {
    /// Where the name tells.
    fn of_name(name: &str) -> Self {
        match name {
            EVENT | STATE => Self::Text,
            UTC => Self::Moment,
            _ => Self::Unknown,
        }
    }
}

impl ChunkSource for CsvReader {
    /// Metadata so far; complete after the last chunk.
    fn metadata(&self) -> Metadata {
        self.csv.get_ref().metadata().clone()
    }

    fn units(&self) -> &[String] {
        &self.units
    }

    fn read_as_text(&mut self, column: usize) {
        self.kinds[column] = CellKind::Text;
    }

    fn read_as_time(&mut self, column: usize) {
        self.kinds[column] = CellKind::Moment;
    }

    /// Tells whether each column holds text, as far as the first rows tell.
    fn holds_text(&mut self, _head: &TableHead) -> Result<Vec<bool>, RecordingError> {
        Ok(self.kinds.iter().map(|kind| *kind == CellKind::Text).collect())
    }

    /// Passes over rows; fewer than asked for when the table ends before.
    fn skip(&mut self, rows: u64, head: &TableHead) -> Result<u64, RecordingError> {
        for skipped in 0..rows {
            if !self.next_row(head)? {
                return Ok(skipped);
            }
        }
        Ok(rows)
    }

    fn next_chunk(&mut self, head: &TableHead) -> Result<Option<Vec<ColumnValues>>, RecordingError> {
        let mut chunk: Vec<ColumnValues> = Vec::new();
        for _ in 0..CHUNK {
            if !self.next_row(head)? {
                break;
            }
            if chunk.is_empty() {
                let is_text = |&at: &usize| ColumnValues::empty(self.kinds[at] == CellKind::Text);
                chunk = head.selected.iter().map(is_text).collect();
            }
            for (column, &at) in chunk.iter_mut().zip(&head.selected) {
                let field = self.record.get(at).unwrap_or_default();
                let cell = match column {
                    ColumnValues::Words(_) => RowCell::Text(field),
                    ColumnValues::Numbers(_) => {
                        let number = field.parse().ok().or_else(|| self.unusual(self.kinds[at], field));
                        RowCell::Number(number.ok_or_else(|| {
                            let (row, name, line) = (self.rows, &head.names[at], at_line(self.record.position()));
                            let sentence = format!("row {row}{line}, column `{name}`: `{field}` is not a number");
                            RecordingError::new(&head.path, sentence)
                        })?)
                    }
                };
                column.push(cell);
            }
        }
        Ok((!chunk.is_empty()).then_some(chunk))
    }
}

/// The first rows; those from one on that cannot be read are left to the reader, which says why.
fn probe(builder: &csv::ReaderBuilder, mut first: Vec<Vec<u8>>, has_runs: bool) -> Vec<csv::StringRecord> {
    if has_runs {
        first.iter_mut().for_each(without_runs);
    }
    builder.from_reader(first.concat().as_slice()).records().map_while(Result::ok).collect()
}

/// So many names as --columns takes them.
fn example_names(columns: usize) -> String {
    let inputs = match columns {
        ..=2 => String::new(),
        3 => "power,".to_owned(),
        4..=MOST_LISTED => (1..columns - 1).map(|n| format!("power{n},")).collect(),
        _ => "power1,…,".to_owned(),
    };
    format!("time,{inputs}temperature")
}

/// Remarks are not counted by the parser, so its line numbers are those of the table only; without
/// remarks they are the file's.
fn at_line(position: Option<&csv::Position>) -> String {
    let line = position.map(csv::Position::line).filter(|&line| line > 0);
    line.map_or(String::new(), |line| format!(" (line {line} of the table)"))
}

fn reworded(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::Utf8 { pos, .. } => format!("a row is not UTF-8 text{}", at_line(pos.as_ref())),
        _ => error.to_string(),
    }
}
