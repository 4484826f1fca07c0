//! Recordings as CSV (RFC 4180) with `# key: value` lines around the table.
//!
//! Numbers are written with the fewest digits that give the same f32 back (f64 for the time). A
//! missing number is an empty field, a moment (`utc`) is in RFC 3339. A line break in a metadata
//! value is written `\n`, a backslash `\\`.

use std::fs::File;
use std::io::{self, BufRead, BufReader, BufWriter, Write as _};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use crate::column::{CHUNK, ChunkSource, ColumnKind, ColumnValues, Metadata, RowCell, RowSink, TableHead, length};
use crate::error::RecordingError;
use crate::names::{EVENT, STATE, UTC};
use crate::utc;

/// Key of the `#` lines by which a journal shows damage: the CRC-32 of all bytes before.
const CHECKSUM: &str = "crc32";

/// Bytes on their way into a file, and the checksum of those that are there.
struct Summed {
    file: File,
    sum: Arc<AtomicU32>,
}

impl io::Write for Summed {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.file.write(bytes)?;
        self.sum.store(checksum(self.sum.load(Relaxed), &bytes[..written]), Relaxed);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// The CRC-32 (of IEEE 802.3, as zip has it) of bytes that follow others, whose own is given.
pub(crate) fn checksum(before: u32, bytes: &[u8]) -> u32 {
    let mut sum = crc32fast::Hasher::new_with_initial(before);
    sum.update(bytes);
    sum.finalize()
}

/// What a line says that is a checksum.
pub(crate) fn stated_checksum(line: &[u8]) -> Option<u32> {
    let (key, value) = metadata_of(std::str::from_utf8(line).ok()?.trim_end())?;
    (key == CHECKSUM).then(|| u32::from_str_radix(&value, 16).ok())?
}

pub(crate) struct CsvWriter {
    csv: csv::Writer<BufWriter<Summed>>,
    sum: Arc<AtomicU32>,
    field: String,
    kinds: Vec<ColumnKind>,
    bytes: u64,
    frame_bytes: u64,
}

impl CsvWriter {
    pub(crate) fn new(file: File, columns: &[(String, ColumnKind)], metadata: &Metadata) -> io::Result<Self> {
        let sum = Arc::new(AtomicU32::new(0));
        let mut file = BufWriter::new(Summed { file, sum: Arc::clone(&sum) });
        write_metadata(&mut file, metadata)?;
        // A checksum is one field where rows have several.
        let mut csv = csv::WriterBuilder::new().flexible(true).from_writer(file);
        csv.write_record(columns.iter().map(|(name, _)| name)).map_err(plain)?;
        let kinds = columns.iter().map(|(_, kind)| *kind).collect();
        Ok(Self { csv, sum, field: String::new(), kinds, bytes: 0, frame_bytes: length(metadata) })
    }

    /// Hands all rows to the file, and a line by which a reader sees whether they are as they were.
    /// It waits in memory like a row where the disk has no room for it.
    pub(crate) fn push_checksum(&mut self) -> io::Result<()> {
        self.csv.flush()?;
        self.csv.write_record([format!("# {CHECKSUM}: {:08x}", self.sum.load(Relaxed))]).map_err(plain)?;
        self.csv.flush()
    }
}

impl RowSink for CsvWriter {
    fn push(&mut self, cells: &mut dyn Iterator<Item = RowCell<'_>>) -> io::Result<()> {
        use std::fmt::Write as _;
        for (kind, cell) in self.kinds.iter().zip(cells) {
            self.field.clear();
            // Formatting into a String cannot fail.
            let _ = match cell {
                RowCell::Number(number) if number.is_nan() => Ok(()),
                RowCell::Number(number) => match kind {
                    ColumnKind::Wide => write!(self.field, "{number}"),
                    ColumnKind::Utc => self.field.write_str(&utc::rfc3339(number)),
                    _ => write!(self.field, "{}", number as f32),
                },
                RowCell::Text(text) => self.field.write_str(text),
            };
            self.bytes += self.field.len() as u64 + 1;
            self.csv.write_field(&self.field).map_err(plain)?;
        }
        self.csv.write_record(None::<&[u8]>).map_err(plain)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.csv.flush()
    }

    fn bytes(&self) -> u64 {
        self.bytes
    }

    fn frame_bytes(&self) -> u64 {
        self.frame_bytes
    }

    fn finish(self: Box<Self>, metadata: &Metadata) -> io::Result<()> {
        let mut file = self.csv.into_inner().map_err(|error| io::Error::other(error.to_string()))?;
        write_metadata(&mut file, metadata)?;
        file.flush()
    }
}

/// The system's own error, whose kind tells a disk without room from others.
fn plain(error: csv::Error) -> io::Error {
    match error.into_kind() {
        csv::ErrorKind::Io(error) => error,
        other => io::Error::other(format!("{other:?}")),
    }
}

fn write_metadata(file: &mut impl io::Write, metadata: &Metadata) -> io::Result<()> {
    for (key, value) in metadata {
        writeln!(file, "# {key}: {}", value.replace('\\', "\\\\").replace('\r', "\\r").replace('\n', "\\n"))?;
    }
    Ok(())
}

/// What a `#` line says.
pub(crate) fn metadata_of(line: &str) -> Option<(String, String)> {
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
    /// Whether the file may end in the middle of a row, which is then none: a journal whose
    /// program was killed, or whose last blocks the disk has not got.
    may_be_torn: bool,
    metadata: Metadata,
}

impl Uncommented {
    /// The next line, or a whole row where the end may be torn; none at the end.
    fn next_line(&mut self) -> io::Result<bool> {
        self.line.clear();
        self.taken = 0;
        loop {
            let start = self.line.len();
            let read = self.file.read_until(b'\n', &mut self.line)?;
            let line = &self.line[start..];
            if self.may_be_torn && line.ends_with(b"\n") && line.contains(&0) {
                return Err(io::Error::new(io::ErrorKind::InvalidData, "zeros stand before the last row"));
            }
            if read == 0 || self.may_be_torn && !line.ends_with(b"\n") {
                // What stands before belongs to a row that is not whole.
                self.line.truncate(if self.may_be_torn { 0 } else { start });
                return Ok(!self.line.is_empty());
            }
            if !self.quoted && line.starts_with(b"#") {
                let line = String::from_utf8_lossy(line);
                let said = metadata_of(line.trim_end_matches(['\r', '\n']));
                self.metadata.extend(said.filter(|(key, _)| !(self.may_be_torn && key == CHECKSUM)));
                self.line.truncate(start);
                continue;
            }
            self.quoted ^= line.iter().filter(|&&byte| byte == b'"').count() % 2 == 1;
            if !(self.quoted && self.may_be_torn) {
                return Ok(true);
            }
        }
    }
}

impl io::Read for Uncommented {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        if self.taken == self.line.len() && !self.next_line()? {
            return Ok(0);
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
    rows: u64,
}

impl CsvReader {
    /// The reader, and the names of the columns.
    pub(crate) fn open(
        file: File,
        path: &Path,
        may_be_torn: bool,
    ) -> Result<(Box<dyn ChunkSource>, Vec<String>), RecordingError> {
        let file = Uncommented {
            file: BufReader::with_capacity(1 << 16, file),
            line: Vec::new(),
            taken: 0,
            quoted: false,
            may_be_torn,
            metadata: Metadata::new(),
        };
        let mut csv = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(file);
        let header = csv.headers().map_err(|error| RecordingError::damaged(path, reworded(&error)))?;
        let names: Vec<String> = header.iter().map(str::to_owned).collect();
        let refuse = |sentence: &str| Err(RecordingError::new(path, sentence));
        if names.is_empty() {
            return refuse("is empty: a line with the columns' names belongs first");
        }
        if let ([only], Some(separator)) = (names.as_slice(), names[0].find([';', '\t'])) {
            let separator = &only[separator..=separator];
            return refuse(&format!("separates its columns by {separator:?}: commas belong there"));
        }
        if let Some(at) = names.iter().position(String::is_empty) {
            return refuse(&format!("column {} has no name", at + 1));
        }
        if names.iter().all(|name| name.parse::<f64>().is_ok()) {
            return refuse("begins with numbers: a line with the columns' names belongs first");
        }
        let reader =
            Self { csv, record: csv::StringRecord::new(), text: None, forced: Vec::new(), pending: false, rows: 0 };
        Ok((Box::new(reader), names))
    }

    /// Takes the next row into `record`.
    fn next_row(&mut self, head: &TableHead) -> Result<bool, RecordingError> {
        if std::mem::take(&mut self.pending) {
            return Ok(true);
        }
        let more = self.csv.read_record(&mut self.record).map_err(|error| head.damaged(reworded(&error)))?;
        self.rows += u64::from(more);
        if more && self.text.is_none() {
            let is_text = |(at, (name, field)): (usize, (&String, &str))| {
                [EVENT, STATE].contains(&name.as_str()) || self.forced.contains(&at) || number(name, field).is_none()
            };
            self.text = Some(head.names.iter().zip(&self.record).enumerate().map(is_text).collect());
        }
        Ok(more)
    }
}

impl ChunkSource for CsvReader {
    fn rows(&self) -> Option<u64> {
        None
    }

    /// What has been met so far; complete after the last chunk.
    fn metadata(&self) -> Metadata {
        self.csv.get_ref().metadata.clone()
    }

    fn read_as_text(&mut self, column: usize) {
        self.forced.push(column);
        self.text.iter_mut().for_each(|text| text[column] = true);
    }

    /// Whether each column holds text, as far as the first row tells.
    fn holds_text(&mut self, head: &TableHead) -> Result<Vec<bool>, RecordingError> {
        if self.text.is_none() {
            self.pending = self.next_row(head)?;
        }
        Ok(self.text.clone().unwrap_or_else(|| vec![false; head.names.len()]))
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
                let text = self.text.as_deref().unwrap_or_default();
                chunk = head.selected.iter().map(|&at| ColumnValues::empty(text[at])).collect();
            }
            for (column, &at) in chunk.iter_mut().zip(&head.selected) {
                let field = self.record.get(at).unwrap_or_default();
                let cell = match column {
                    ColumnValues::Words(_) => RowCell::Text(field),
                    ColumnValues::Numbers(_) => RowCell::Number(number(&head.names[at], field).ok_or_else(|| {
                        let (row, name, line) = (self.rows, &head.names[at], at_line(self.record.position()));
                        let sentence = format!("row {row}{line}, column `{name}`: `{field}` is not a number");
                        RecordingError::new(&head.path, sentence)
                    })?),
                };
                column.push(cell);
            }
        }
        Ok((!chunk.is_empty()).then_some(chunk))
    }
}

/// `#` lines are not counted by the parser, so its line numbers are those of the table only;
/// without such lines they are the file's.
fn at_line(position: Option<&csv::Position>) -> String {
    let line = position.map(csv::Position::line).filter(|&line| line > 0);
    line.map_or(String::new(), |line| format!(" (line {line} of the table)"))
}

/// A field's number; an empty field is a missing one.
pub(crate) fn number(column: &str, field: &str) -> Option<f64> {
    if field.is_empty() {
        return Some(f64::NAN);
    }
    field.parse().ok().or_else(|| utc::from_rfc3339(field).filter(|_| column == UTC))
}

fn reworded(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::UnequalLengths { pos, expected_len, len } => {
            let line = at_line(pos.as_ref());
            format!("a row has {len} fields where the header names {expected_len} columns{line}")
        }
        csv::ErrorKind::Utf8 { pos, .. } => format!("a row is not UTF-8 text{}", at_line(pos.as_ref())),
        _ => error.to_string(),
    }
}
