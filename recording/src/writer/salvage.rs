//! What can be read of a journal, whose end may be torn and whose bytes damaged.
//!
//! Only whole rows: as many fields as there are columns, and a number wherever one belongs. Where
//! none begins, the search goes on with the next line. A digit that became another digit is not
//! seen.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{self, BufRead as _, BufReader};
use std::path::Path;

use super::table::TableWriter;
use crate::column::{ColumnKind, Metadata, RowCell};
use crate::csv::{metadata_of, number};
use crate::error::RecordingError;

/// A row spans no more of them: line breaks in the words of an event.
const MOST_LINES: usize = 16;

pub(super) struct Salvage {
    file: BufReader<File>,
    pub columns: Vec<(String, ColumnKind)>,
    pub metadata: Metadata,
    /// Read, and not yet a row.
    lines: VecDeque<Vec<u8>>,
}

impl Salvage {
    /// Reads what stands above the rows. `before` are the columns' names in the file before this
    /// one, which a damaged line with them cannot take away.
    pub fn open(journal: &Path, before: Option<Vec<String>>) -> io::Result<Self> {
        let file = BufReader::new(File::open(journal)?);
        let mut salvage = Self { file, columns: Vec::new(), metadata: Metadata::new(), lines: VecDeque::new() };
        while let Some(line) = salvage.next_line()? {
            if line.starts_with(b"#") {
                salvage.metadata.extend(metadata_of(String::from_utf8_lossy(&line).trim_end()));
                continue;
            }
            let stated = fields_of(&line).map(|names| names.iter().map(str::to_owned).collect());
            salvage.columns = ColumnKind::of_each(before.or(stated).unwrap_or_default());
            break;
        }
        Ok(salvage)
    }

    /// Hands the rows that can be read to a file; returns how many there are, and how many lines
    /// are of none.
    pub fn write(mut self, journal: &Path, table: &mut TableWriter) -> Result<(u64, u64), RecordingError> {
        let (mut rows, mut unread) = (0, 0);
        loop {
            while self.lines.len() < MOST_LINES {
                let Some(line) = self.next_line().map_err(|error| RecordingError::io(journal, "read", error))? else {
                    break;
                };
                self.lines.push_back(line);
            }
            if self.lines.is_empty() {
                return Ok((rows, unread));
            }
            if let Some((count, record)) = self.next_record() {
                let cells = cells_of(&record, &self.columns).unwrap_or_default();
                table.push(&mut cells.into_iter())?;
                self.lines.drain(..count);
                rows += 1;
            } else if self.is_torn() {
                return Ok((rows, unread));
            } else {
                self.lines.pop_front();
                unread += 1;
            }
        }
    }

    /// The row that begins with the next line, and of how many lines it is.
    fn next_record(&self) -> Option<(usize, csv::StringRecord)> {
        let mut row = Vec::new();
        self.lines.iter().enumerate().find_map(|(at, line)| {
            row.extend(line);
            let is_ended = row.iter().filter(|&&byte| byte == b'"').count().is_multiple_of(2);
            let record = is_ended.then(|| fields_of(&row))??;
            cells_of(&record, &self.columns).is_some().then_some((at + 1, record))
        })
    }

    /// Whether a row begins that nothing ends: quotes that the end of the file leaves open.
    fn is_torn(&self) -> bool {
        self.lines.len() < MOST_LINES
            && !self.lines.iter().flatten().filter(|&&byte| byte == b'"').count().is_multiple_of(2)
    }

    /// The next line that is whole, with its end.
    fn next_line(&mut self) -> io::Result<Option<Vec<u8>>> {
        let mut line = Vec::new();
        self.file.read_until(b'\n', &mut line)?;
        Ok(line.ends_with(b"\n").then_some(line))
    }
}

fn fields_of(line: &[u8]) -> Option<csv::StringRecord> {
    let mut csv = csv::ReaderBuilder::new().has_headers(false).trim(csv::Trim::All).from_reader(line);
    csv.records().next()?.ok()
}

fn cells_of<'a>(record: &'a csv::StringRecord, columns: &[(String, ColumnKind)]) -> Option<Vec<RowCell<'a>>> {
    let cell = |(field, (name, kind)): (&'a str, &(String, ColumnKind))| match kind {
        ColumnKind::Text => Some(RowCell::Text(field)),
        _ => number(name, field).map(RowCell::Number),
    };
    (record.len() == columns.len()).then(|| record.iter().zip(columns).map(cell).collect())?
}
