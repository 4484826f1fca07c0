//! Recordings as CSV (RFC 4180) with `# key: value` lines around the table.
//!
//! Numbers are written with the fewest digits that give the same f32 back (f64 for the time). A
//! missing number is an empty field. A line break in a metadata value is written `\n`, a backslash
//! `\\`.

use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter, Write as _};
use std::path::Path;

use crate::column::{
    CHUNK, ChunkSource, ColumnKind, ColumnValues, ColumnWords, Metadata, RecordingColumn, RowCell, RowSink,
};
use crate::error::RecordingError;
use crate::names::{EVENT, STATE};

pub(crate) struct CsvWriter {
    csv: csv::Writer<BufWriter<File>>,
    field: String,
    /// Whether a column's numbers are f64.
    wide: Vec<bool>,
}

impl CsvWriter {
    pub(crate) fn new(
        file: File,
        columns: &[(String, ColumnKind)],
        metadata: &Metadata,
        path: &Path,
    ) -> Result<Self, RecordingError> {
        let failed = |error: &dyn std::fmt::Display| RecordingError::io(path, "written", error);
        let mut file = BufWriter::new(file);
        write_metadata(&mut file, metadata).map_err(|error| failed(&error))?;
        let mut csv = csv::Writer::from_writer(file);
        csv.write_record(columns.iter().map(|(name, _)| name)).map_err(|error| failed(&error))?;
        Ok(Self {
            csv,
            field: String::new(),
            wide: columns.iter().map(|(_, kind)| *kind == ColumnKind::Wide).collect(),
        })
    }

    fn write(&mut self, cells: &mut dyn Iterator<Item = RowCell<'_>>) -> csv::Result<()> {
        use std::fmt::Write as _;
        for (&wide, cell) in self.wide.iter().zip(cells) {
            self.field.clear();
            // Formatting into a String cannot fail.
            let _ = match cell {
                RowCell::Number(number) if number.is_nan() => Ok(()),
                RowCell::Number(number) if wide => write!(self.field, "{number}"),
                RowCell::Number(number) => write!(self.field, "{}", number as f32),
                RowCell::Text(text) => self.field.write_str(text),
            };
            self.csv.write_field(&self.field)?;
        }
        self.csv.write_record(None::<&[u8]>)
    }
}

impl RowSink for CsvWriter {
    fn push(&mut self, cells: &mut dyn Iterator<Item = RowCell<'_>>, path: &Path) -> Result<(), RecordingError> {
        self.write(cells).map_err(|error| RecordingError::io(path, "written", &error))
    }

    fn finish(self: Box<Self>, metadata: &Metadata, path: &Path) -> Result<(), RecordingError> {
        let failed = |error: &dyn std::fmt::Display| RecordingError::io(path, "written", error);
        let mut file = self.csv.into_inner().map_err(|error| failed(error.error()))?;
        write_metadata(&mut file, metadata).and_then(|()| file.flush()).map_err(|error| failed(&error))
    }
}

fn write_metadata(file: &mut impl std::io::Write, metadata: &Metadata) -> std::io::Result<()> {
    for (key, value) in metadata {
        writeln!(file, "# {key}: {}", value.replace('\\', "\\\\").replace('\r', "\\r").replace('\n', "\\n"))?;
    }
    Ok(())
}

fn metadata_of(line: &str) -> Option<(String, String)> {
    let (key, value) = line.strip_prefix('#')?.split_once(':')?;
    let mut plain = String::with_capacity(value.len());
    let mut letters = value.trim().chars();
    while let Some(letter) = letters.next() {
        match letter {
            '\\' => match letters.next() {
                Some('n') => plain.push('\n'),
                Some('r') => plain.push('\r'),
                Some(other) => plain.push(other),
                None => plain.push('\\'),
            },
            _ => plain.push(letter),
        }
    }
    Some((key.trim().to_owned(), plain))
}

/// Takes the `#` lines out of the stream and keeps what they say; everything else passes to the CSV
/// parser.
struct Uncommented {
    file: BufReader<File>,
    line: Vec<u8>,
    taken: usize,
    /// A line break inside quotes does not start a line.
    quoted: bool,
    metadata: std::rc::Rc<std::cell::RefCell<Metadata>>,
}

impl std::io::Read for Uncommented {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        while self.taken == self.line.len() {
            self.line.clear();
            self.taken = 0;
            if self.file.read_until(b'\n', &mut self.line)? == 0 {
                return Ok(0);
            }
            if !self.quoted && self.line.starts_with(b"#") {
                self.metadata
                    .borrow_mut()
                    .extend(metadata_of(String::from_utf8_lossy(&self.line).trim_end_matches(['\r', '\n'])));
                self.line.clear();
            } else {
                self.quoted ^= self.line.iter().filter(|&&byte| byte == b'"').count() % 2 == 1;
            }
        }
        let count = into.len().min(self.line.len() - self.taken);
        into[..count].copy_from_slice(&self.line[self.taken..self.taken + count]);
        self.taken += count;
        Ok(count)
    }
}

pub(crate) struct CsvReader {
    csv: csv::Reader<Uncommented>,
    record: csv::StringRecord,
    /// Whether a column holds text; known from its first row on.
    text: Option<Vec<bool>>,
    /// Columns to read as text whatever their first row looks like.
    forced: Vec<usize>,
    /// The first row was looked at and has not been handed out.
    pending: bool,
    names: Vec<String>,
    /// The columns that are handed out, in their order.
    selected: Vec<usize>,
    rows: u64,
    metadata: std::rc::Rc<std::cell::RefCell<Metadata>>,
}

impl CsvReader {
    pub(crate) fn open(file: File, path: &Path) -> Result<Self, RecordingError> {
        let metadata = std::rc::Rc::default();
        let file = Uncommented {
            file: BufReader::with_capacity(1 << 16, file),
            line: Vec::new(),
            taken: 0,
            quoted: false,
            metadata: std::rc::Rc::clone(&metadata),
        };
        let mut csv = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(file);
        let names: Vec<String> = csv
            .headers()
            .map_err(|error| RecordingError::damaged(path, &reworded(&error)))?
            .iter()
            .map(str::to_owned)
            .collect();
        if names.is_empty() {
            return Err(RecordingError::content(path, "is empty: a line with the columns' names belongs first"));
        }
        if let ([only], Some(separator)) = (names.as_slice(), names[0].find([';', '\t'])) {
            let sentence = format!("separates its columns by {:?}: commas belong there", &only[separator..=separator]);
            return Err(RecordingError::content(path, sentence));
        }
        if let Some(at) = names.iter().position(String::is_empty) {
            return Err(RecordingError::content(path, format!("column {} has no name", at + 1)));
        }
        if names.iter().all(|name| name.parse::<f64>().is_ok()) {
            return Err(RecordingError::content(
                path,
                "begins with numbers: a line with the columns' names belongs first",
            ));
        }
        let selected = (0..names.len()).collect();
        let record = csv::StringRecord::new();
        Ok(Self { csv, record, text: None, forced: Vec::new(), pending: false, names, selected, rows: 0, metadata })
    }

    /// Takes the next row into `record`.
    fn next_row(&mut self, path: &Path) -> Result<bool, RecordingError> {
        if std::mem::take(&mut self.pending) {
            return Ok(true);
        }
        let more =
            self.csv.read_record(&mut self.record).map_err(|error| RecordingError::damaged(path, &reworded(&error)))?;
        if more {
            self.rows += 1;
        }
        if more && self.text.is_none() {
            let is_text = |(at, (name, field)): (usize, (&String, &str))| {
                [EVENT, STATE].contains(&name.as_str()) || self.forced.contains(&at) || number(field).is_none()
            };
            self.text = Some(self.names.iter().zip(&self.record).enumerate().map(is_text).collect());
        }
        Ok(more)
    }
}

impl ChunkSource for CsvReader {
    fn names(&self) -> &[String] {
        &self.names
    }

    fn names_mut(&mut self) -> &mut [String] {
        &mut self.names
    }

    fn rows(&self) -> Option<u64> {
        None
    }

    /// What has been met so far; complete after the last chunk.
    fn metadata(&self) -> Metadata {
        self.metadata.borrow().clone()
    }

    fn select(&mut self, columns: &[usize]) {
        self.selected = columns.to_vec();
    }

    fn read_as_text(&mut self, column: usize) {
        self.forced.push(column);
        self.text.iter_mut().for_each(|text| text[column] = true);
    }

    /// Whether each column holds text, as far as the first row tells.
    fn holds_text(&mut self, path: &Path) -> Result<Vec<bool>, RecordingError> {
        if self.text.is_none() {
            self.pending = self.next_row(path)?;
        }
        Ok(self.text.clone().unwrap_or_else(|| vec![false; self.names.len()]))
    }

    /// Passes over rows; fewer than asked for when the table ends before.
    fn skip(&mut self, rows: u64, path: &Path) -> Result<u64, RecordingError> {
        for skipped in 0..rows {
            if !self.next_row(path)? {
                return Ok(skipped);
            }
        }
        Ok(rows)
    }

    fn next_chunk(&mut self, path: &Path) -> Result<Option<Vec<RecordingColumn>>, RecordingError> {
        let mut chunk: Vec<RecordingColumn> = Vec::new();
        for _ in 0..CHUNK {
            if !self.next_row(path)? {
                break;
            }
            if chunk.is_empty() {
                let text = self.text.as_deref().unwrap_or_default();
                let empty = |&at: &usize| RecordingColumn {
                    name: self.names[at].clone(),
                    values: if text[at] {
                        ColumnValues::Words(ColumnWords::default())
                    } else {
                        ColumnValues::Numbers(Vec::new())
                    },
                };
                chunk = self.selected.iter().map(empty).collect();
            }
            let record = &self.record;
            for (column, &at) in chunk.iter_mut().zip(&self.selected) {
                let field = record.get(at).unwrap_or_default();
                match &mut column.values {
                    ColumnValues::Words(words) => words.push(field),
                    ColumnValues::Numbers(numbers) => numbers.push(number(field).ok_or_else(|| {
                        let line = record.position().map_or(0, csv::Position::line);
                        let (row, name) = (self.rows, &column.name);
                        RecordingError::content(
                            path,
                            format!("row {row}{}, column `{name}`: `{field}` is not a number", at_line(line)),
                        )
                    })?),
                }
            }
        }
        Ok((!chunk.is_empty()).then_some(chunk))
    }
}

/// `#` lines are not counted by the parser, so its line numbers are those of the table only;
/// without such lines they are the file's.
fn at_line(line: u64) -> String {
    if line == 0 { String::new() } else { format!(" (line {line} of the table)") }
}

/// A field's number; an empty field is a missing one.
fn number(field: &str) -> Option<f64> {
    if field.is_empty() { Some(f64::NAN) } else { field.parse().ok() }
}

fn reworded(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::UnequalLengths { pos, expected_len, len } => {
            let line = pos.as_ref().map_or(0, csv::Position::line);
            format!("a row has {len} fields where the header names {expected_len} columns{}", at_line(line))
        }
        csv::ErrorKind::Utf8 { pos, .. } => {
            let line = pos.as_ref().map_or(0, csv::Position::line);
            format!("a row is not UTF-8 text{}", at_line(line))
        }
        _ => error.to_string(),
    }
}
