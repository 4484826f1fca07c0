//! Readable part of a journal, whose end may be torn and whose bytes damaged.
//!
//! Only whole rows: as many fields as there are columns, and a number wherever one belongs. Where
//! none begins, the search goes on with the next line. Whether a digit became another digit, the
//! journal's checksums tell.
//!
//! Each checksum of a journal is of all bytes before it. From one right checksum to the next the
//! bytes are sound; what stands behind the last was on its way to the disk, and nothing speaks for
//! or against it.

use std::collections::VecDeque;
use std::fs::File;
use std::io;
use std::io::{BufRead as _, BufReader};
use std::path::Path;

use super::table::TableWriter;
use crate::column::{ColumnKind, Metadata, RowCell};
use crate::csv::{checksum, metadata_of, number, stated_checksum};
use crate::error::RecordingError;
use crate::names::{TIME, duplicate};

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
    pub fn open(journal: &Path, before: Option<Vec<String>>, head_is_damaged: bool) -> io::Result<Self> {
        let file = BufReader::new(File::open(journal)?);
        let mut salvage = Self { file, columns: Vec::new(), metadata: Metadata::new(), lines: VecDeque::new() };
        let mut stated: Option<Vec<String>> = None;
        while let Some(line) = salvage.next_line()? {
            if line.starts_with(b"#") {
                salvage.metadata.extend(metadata_of(String::from_utf8_lossy(&line).trim_end()));
                continue;
            }
            // Whatever the lines before have become, a row begins with its time.
            if head_is_damaged && line.split(|&byte| byte == b',').next().is_some_and(is_time) {
                salvage.lines.push_back(line);
                salvage.look_ahead()?;
                let row = salvage.fields_from(0, |_| true).map(|(_, row)| row).unwrap_or_default();
                let names = before.or(stated.filter(|names| are_names(names, row.len())));
                salvage.columns = names.map_or_else(|| unnamed(&row), ColumnKind::of_each);
                break;
            }
            stated = fields_of(&line).map(|names| names.iter().map(str::to_owned).collect());
            if !head_is_damaged {
                salvage.columns = ColumnKind::of_each(before.or(stated).unwrap_or_default());
                break;
            }
        }
        Ok(salvage)
    }

    /// Hands the rows that can be read to a file; returns how many there are, and how many lines
    /// are of none.
    pub fn write(mut self, journal: &Path, table: &mut TableWriter) -> Result<(u64, u64), RecordingError> {
        let (mut rows, mut unread) = (0, 0);
        loop {
            self.look_ahead().map_err(|error| RecordingError::io(journal, "read", error))?;
            let Some(next) = self.lines.front() else { return Ok((rows, unread)) };
            if stated_checksum(next).is_some() {
                self.lines.pop_front();
                continue;
            }
            if let Some((count, record)) = self.row_from(0) {
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

    /// Has as many lines at hand as a row may have.
    fn look_ahead(&mut self) -> io::Result<()> {
        while self.lines.len() < MOST_LINES {
            let Some(line) = self.next_line()? else { break };
            self.lines.push_back(line);
        }
        Ok(())
    }

    /// The row that begins with one of the lines, and of how many lines it is.
    fn row_from(&self, first: usize) -> Option<(usize, csv::StringRecord)> {
        self.fields_from(first, |fields| cells_of(fields, &self.columns).is_some())
    }

    /// The fields of the fewest lines from `first` on that are `fit` and leave no quote open, and
    /// how many lines these are.
    fn fields_from(
        &self,
        first: usize,
        fit: impl Fn(&csv::StringRecord) -> bool,
    ) -> Option<(usize, csv::StringRecord)> {
        let mut row = Vec::new();
        self.lines.range(first..).enumerate().find_map(|(at, line)| {
            row.extend(line);
            let is_ended = row.iter().filter(|&&byte| byte == b'"').count().is_multiple_of(2);
            let fields = is_ended.then(|| fields_of(&row))??;
            fit(&fields).then_some((at + 1, fields))
        })
    }

    /// Tells whether the lines begin a row that the end of the file cuts off in a quoted text: then
    /// no other row begins in them.
    fn is_torn(&self) -> bool {
        self.lines.len() < MOST_LINES
            && !self.lines.iter().flatten().filter(|&&byte| byte == b'"').count().is_multiple_of(2)
            && (1..self.lines.len()).all(|line| self.row_from(line).is_none())
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

fn is_time(field: &[u8]) -> bool {
    std::str::from_utf8(field).is_ok_and(|field| field.trim().parse::<f64>().is_ok())
}

/// Tells whether these can be the names of so many columns.
fn are_names(names: &[String], columns: usize) -> bool {
    names.len() == columns
        && duplicate(names.iter().map(String::as_str)).is_none()
        && !names.iter().any(String::is_empty)
}

/// Columns whose names are lost: the time, and the others by their place.
fn unnamed(row: &csv::StringRecord) -> Vec<(String, ColumnKind)> {
    let of = |(at, field): (usize, &str)| match field.parse::<f64>() {
        Ok(_) if at == 0 => (TIME.to_owned(), ColumnKind::Wide),
        Ok(_) => (format!("column_{}", at + 1), ColumnKind::Number),
        Err(_) => (format!("column_{}", at + 1), ColumnKind::Text),
    };
    row.iter().enumerate().map(of).collect()
}

fn cells_of<'a>(record: &'a csv::StringRecord, columns: &[(String, ColumnKind)]) -> Option<Vec<RowCell<'a>>> {
    let cell = |(field, (name, kind)): (&'a str, &(String, ColumnKind))| match kind {
        ColumnKind::Text => Some(RowCell::Text(field)),
        _ => number(name, field).map(RowCell::Number),
    };
    (record.len() == columns.len()).then(|| record.iter().zip(columns).map(cell).collect())?
}

pub(super) struct Soundness {
    /// Text above the rows is as it was written; none without any checksum, as in a journal of an
    /// earlier version.
    pub head: Option<bool>,
    /// Stretches between two checksums that are not.
    pub damaged: u64,
}

impl Soundness {
    pub fn of(journal: &Path) -> io::Result<Self> {
        let mut file = BufReader::new(File::open(journal)?);
        let mut found = Self { head: None, damaged: 0 };
        let (mut sum, mut line) = (0, Vec::new());
        while file.read_until(b'\n', &mut line)? > 0 {
            // A line that the end has cut may have lost digits.
            if let Some(stated) = stated_checksum(&line).filter(|_| line.ends_with(b"\n")) {
                found.head.get_or_insert(stated == sum);
                found.damaged += u64::from(stated != sum);
                // So that one damaged stretch does not put the following in doubt.
                sum = stated;
            }
            sum = checksum(sum, &line);
            line.clear();
        }
        Ok(found)
    }
}
