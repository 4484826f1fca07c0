//! Writing a recording row by row, in memory that does not grow with its length; and whole tables
//! of numbers.

mod journal;
mod options;
mod recorder;
mod recover;
mod table;

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::column::{ColumnKind, Metadata, RowCell, overlay};
use crate::error::RecordingError;
use crate::file_format::check_name;
use crate::format1::FORMAT;
use crate::names::TIME;
use crate::parts::{SEGMENT_NUMBER, journal_in, journal_of, segment_in, segments_in};
use crate::row::{RecordingLayout, RecordingRow};
use journal::Journal;
use table::{TableWriter, unwritten};

pub use options::{SegmentLength, SegmentLengthError, WriterOptions};
pub use recorder::Recorder;
pub use recover::{Recovered, recover};

/// A recording that is being written: one file, or a folder of segments.
///
/// With a journal, what has been pushed survives the end of this program by any cause, but for a
/// quarter of a second: [`recover`] makes a file of it. Dropped before [`RecordingWriter::finish`],
/// it leaves its journal, and no file otherwise.
pub struct RecordingWriter {
    layout: RecordingLayout,
    columns: Vec<(String, ColumnKind)>,
    metadata: Metadata,
    table: TableWriter,
    journal: Option<Journal>,
    /// Of a folder.
    segments: Option<Segments>,
    rows: u64,
}

/// Where the next segment begins, and which it is.
struct Segments {
    folder: PathBuf,
    length: SegmentLength,
    number: u32,
    /// Time of the segment's first row, s.
    begin_s: Option<f64>,
}

impl Segments {
    /// Whether a row belongs into the next segment.
    fn ends_before(&self, time_s: f64, table: &TableWriter) -> bool {
        self.begin_s.is_some_and(|begin_s| match self.length {
            // A row's time may be rounded.
            SegmentLength::Seconds(length_s) => time_s - begin_s >= length_s * (1.0 - 1e-9),
            SegmentLength::Bytes(length) => table.bytes() >= length,
        })
    }
}

impl RecordingWriter {
    /// Starts a recording with the metadata that are known at its start; the format is added. A
    /// name without extension is a folder's.
    ///
    /// # Errors
    /// If the file cannot be made, two elements would share a column, or a recording is there that
    /// goes on or was cut short.
    pub fn create(path: &Path, layout: RecordingLayout, metadata: &Metadata) -> Result<Self, RecordingError> {
        Self::with_options(path, layout, metadata, &WriterOptions::default())
    }

    /// As [`RecordingWriter::create`], and says how the recording is kept while it grows.
    ///
    /// # Errors
    /// As [`RecordingWriter::create`].
    pub fn with_options(
        path: &Path,
        layout: RecordingLayout,
        metadata: &Metadata,
        options: &WriterOptions,
    ) -> Result<Self, RecordingError> {
        layout.check_elements(path)?;
        let columns = ColumnKind::of_each(layout.columns());
        let mut metadata = with_format(metadata);
        let segments = if is_folder(path) { Some(first_segment(path, options.segment)?) } else { None };
        let (file, journal) = match &segments {
            Some(segments) => (segment_in(path, segments.number), Some(journal_in(path))),
            None => (path.to_owned(), options.has_journal.then(|| journal_of(path))),
        };
        set_number(&mut metadata, segments.as_ref());
        check_name(&file)?;
        let table = TableWriter::create(&file, &columns, &metadata)?;
        let journal = journal.map(|journal| {
            Journal::create(journal.clone(), columns.clone(), &metadata).map_err(|error| match error.kind() {
                ErrorKind::AlreadyExists => held(path, &journal),
                _ => unwritten(&journal)(error),
            })
        });
        let journal = journal.transpose()?;
        Ok(Self { layout, columns, metadata, table, journal, segments, rows: 0 })
    }

    /// What the rows consist of.
    pub fn layout(&self) -> &RecordingLayout {
        &self.layout
    }

    /// Writes a row.
    ///
    /// # Errors
    /// If it does not fit the layout, or the file cannot be written.
    pub fn push(&mut self, row: &RecordingRow) -> Result<(), RecordingError> {
        self.layout.check(row)?;
        self.push_cells(row.time_s, &mut || Box::new(row.cells()))
    }

    /// Writes the cells of a row that fits the layout.
    fn push_cells<'a>(
        &mut self,
        time_s: f64,
        cells: &mut dyn FnMut() -> Box<dyn Iterator<Item = RowCell<'a>> + 'a>,
    ) -> Result<(), RecordingError> {
        if self.segments.as_ref().is_some_and(|segments| segments.ends_before(time_s, &self.table)) {
            self.next_segment()?;
        }
        // First of all it is kept.
        if let Some(journal) = &mut self.journal {
            journal.push(&mut cells()).map_err(unwritten(&journal.path))?;
        }
        self.table.push(&mut cells())?;
        self.rows += 1;
        if let Some(segments) = &mut self.segments {
            segments.begin_s.get_or_insert(time_s);
        }
        Ok(())
    }

    /// Closes the segment and begins the next one.
    fn next_segment(&mut self) -> Result<(), RecordingError> {
        let Some(segments) = &mut self.segments else { return Ok(()) };
        segments.number += 1;
        segments.begin_s = None;
        set_number(&mut self.metadata, Some(segments));
        let next = segment_in(&segments.folder, segments.number);
        let next = TableWriter::create(&next, &self.columns, &self.metadata)?;
        let complete = ("complete".to_owned(), "true".to_owned());
        std::mem::replace(&mut self.table, next).finish(&vec![complete])?;
        match &mut self.journal {
            Some(journal) => journal.restart(&self.metadata).map_err(unwritten(&journal.path)),
            None => Ok(()),
        }
    }

    /// Has the rows on the disk that have waited long enough, where there is a journal.
    fn sync_if_due(&mut self) -> Result<(), RecordingError> {
        match &mut self.journal {
            Some(journal) => journal.sync_if_due().map_err(unwritten(&journal.path)),
            None => Ok(()),
        }
    }

    /// Completes the file with what is known at the end (losses, hash …) and gives it its name.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(mut self, metadata: &Metadata) -> Result<(), RecordingError> {
        if let Some(journal) = &mut self.journal {
            journal.sync().map_err(unwritten(&journal.path))?;
        }
        self.table.finish(metadata)?;
        match self.journal {
            Some(journal) => {
                let path = journal.path.clone();
                journal.remove().map_err(unwritten(&path))
            }
            None => Ok(()),
        }
    }

    /// Leaves nothing of a recording that has no row.
    fn discard_if_empty(self) {
        if let Some(journal) = self.journal.filter(|_| self.rows == 0) {
            let _ = journal.remove();
            drop(self.table);
            // Only if nothing else is in it.
            let _ = self.segments.map(|segments| std::fs::remove_dir(segments.folder));
        }
    }
}

/// Whether a recording's name is a folder's: without extension, or of one that is there. `.csv` is
/// a name that has been forgotten.
fn is_folder(path: &Path) -> bool {
    let Some(name) = path.file_name() else { return false };
    let hidden = name.to_string_lossy().strip_prefix('.').map(|name| Path::new("r").with_extension(name));
    let is_forgotten = hidden.is_some_and(|recording| check_name(&recording).is_ok());
    !is_forgotten && (path.extension().is_none() || path.is_dir() && check_name(path).is_err())
}

/// Makes a folder for a new recording.
fn first_segment(folder: &Path, length: SegmentLength) -> Result<Segments, RecordingError> {
    match std::fs::create_dir(folder) {
        Ok(()) => {}
        Err(error) if error.kind() == ErrorKind::AlreadyExists && folder.is_dir() => {
            if !segments_in(folder)?.is_empty() {
                return Err(RecordingError::new(folder, "holds a recording already: name another folder"));
            }
        }
        Err(error) => return Err(unwritten(folder)(error)),
    }
    Ok(Segments { folder: folder.to_owned(), length, number: 1, begin_s: None })
}

fn set_number(metadata: &mut Metadata, segments: Option<&Segments>) {
    overlay(metadata, segments.map(|segments| (SEGMENT_NUMBER.to_owned(), segments.number.to_string())));
}

/// A journal is there: of whom?
fn held(path: &Path, journal: &Path) -> RecordingError {
    let sentence = match journal::take_over(journal) {
        Err(error) if error.kind() == ErrorKind::WouldBlock => "another program is recording there".to_owned(),
        _ => format!(
            "a recording there was cut short, and its rows wait in {}: keep them by `anemo recover {}`",
            journal.display(),
            path.display()
        ),
    };
    RecordingError::new(path, sentence)
}

/// The metadata of a file in today's format, which may be copied from one of an older.
pub(crate) fn with_format(metadata: &Metadata) -> Metadata {
    let others = metadata.iter().filter(|(key, _)| key != FORMAT.0).cloned();
    std::iter::once((FORMAT.0.to_owned(), FORMAT.1.to_owned())).chain(others).collect()
}

/// Writes a whole table that no instrument made: `time_s` and named columns in f64. Row n is at n
/// times the sample period. There are as many rows as the shortest column has.
///
/// # Errors
/// If the file cannot be written.
pub fn write_columns(
    path: &Path,
    sample_period_s: f64,
    columns: &[(&str, &[f64])],
    metadata: &Metadata,
) -> Result<(), RecordingError> {
    let names = std::iter::once(TIME).chain(columns.iter().map(|(name, _)| *name));
    let named: Vec<(String, ColumnKind)> = names.map(|name| (name.to_owned(), ColumnKind::Wide)).collect();
    let mut table = TableWriter::create(path, &named, metadata)?;
    for n in 0..columns.iter().map(|(_, values)| values.len()).min().unwrap_or(0) {
        let values = columns.iter().map(|(_, values)| values[n]);
        table.push(&mut std::iter::once(n as f64 * sample_period_s).chain(values).map(RowCell::Number))?;
    }
    table.finish(&Metadata::new())
}

#[cfg(all(test, feature = "parquet"))]
mod tests;
