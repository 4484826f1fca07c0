//! Recordings as CSV (RFC 4180) with `# key: value` lines around the table.
//!
//! Numbers are written with the fewest digits that give the same f32 back (f64 for the time). A
//! missing number is an empty field, a moment (`utc`) is in RFC 3339. A line break in a metadata
//! value is written `\n`, a backslash `\\`. `csv_read` reads these and others'.

use std::fs::File;
use std::io::{self, BufWriter, Write as _};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use crate::column::{ColumnKind, Metadata, RowCell, RowSink, length};
use crate::names::UTC;
use crate::utc;

/// Key of the `#` lines by which a journal shows damage: the CRC-32 of all bytes before.
pub(crate) const CHECKSUM: &str = "crc32";

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

/// Checksum that a line states.
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

/// Metadata of a `#` line.
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

/// A field's number in a file of ours; an empty field is a missing one.
pub(crate) fn number(column: &str, field: &str) -> Option<f64> {
    if field.is_empty() {
        return Some(f64::NAN);
    }
    field.parse().ok().or_else(|| utc::from_rfc3339(field).filter(|_| column == UTC))
}
