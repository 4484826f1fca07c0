//! Writing a recording row by row, in memory that does not grow with its length; and whole tables
//! of numbers.

mod decimated;
mod journal;
mod recorder;
mod recover;
mod salvage;
mod segments;
mod table;

use std::io::{self, ErrorKind};
use std::path::Path;
use std::time::{Duration, Instant, SystemTime};

use crate::column::{ColumnKind, Metadata, RowCell, overlay};
use crate::error::RecordingError;
use crate::names::{FORMAT, TIME, UTC};
use crate::parts::{SEGMENT_NUMBER, check_name, journal_in, journal_of};
use crate::row::{RecordingLayout, RecordingRow};
use decimated::RowDecimator;
use journal::Journal;
use recorder::stamped;
use recover::incomplete;
use segments::Segments;
use table::{TableWriter, unwritten};

pub use recorder::Recorder;
pub use recover::{Recovered, recover};
pub use segments::{RecordingSoFar, SegmentLength, SegmentLengthError, WriterOptions, is_being_written, so_far};

/// A full disk is asked for room as often.
const ROOM_EVERY: Duration = Duration::from_secs(1);

/// Why a segment ends where it was not meant to.
const FULL: &str = "the disk is full";

/// A recording that is being written: one file, or a folder of segments.
///
/// With a journal, what has been pushed survives the end of this program by any cause, but for a
/// quarter of a second: [`recover`] makes a file of it. Dropped before [`RecordingWriter::finish`],
/// it leaves its journal, and no file otherwise.
pub struct RecordingWriter {
    layout: RecordingLayout,
    options: WriterOptions,
    columns: Vec<(String, ColumnKind)>,
    metadata: Metadata,
    /// None while the disk has no room for a segment.
    table: Option<TableWriter>,
    asked_for_room: Instant,
    journal: Option<Journal>,
    /// Segments of a folder.
    segments: Option<Segments>,
    /// The journal alone has the segment's rows: the disk had no room for its end.
    waits_for_room: bool,
    beside: Option<Box<(RowDecimator, RecordingWriter)>>,
    rows: u64,
    /// Rows for which there was no room.
    left_out: u64,
    last_s: f64,
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

    /// Like [`RecordingWriter::create`], with options.
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
        let mut names = layout.columns();
        if options.has_utc {
            names.insert(1, UTC.to_owned());
        }
        Self::of_columns(path, names, metadata, options).map(|writer| Self { layout, ..writer })
    }

    fn of_columns(
        path: &Path,
        names: Vec<String>,
        metadata: &Metadata,
        options: &WriterOptions,
    ) -> Result<Self, RecordingError> {
        let segments = if is_folder(path) { Some(Segments::new(path, options, &names)?) } else { None };
        let columns = ColumnKind::of_each(names);
        let mut metadata = with_format(metadata);
        let (file, journal) = match &segments {
            Some(segments) => (segments.path(), Some(journal_in(path))),
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
        if let Some(refusal) = segments.as_ref().and_then(|segments| segments.check_number().err()) {
            journal.map(Journal::remove).transpose().map_err(unwritten(path))?;
            return Err(refusal);
        }
        let beside = options.every_s.filter(|_| segments.is_some()).map(|every_s| {
            let options = WriterOptions { keep_s: None, every_s: None, ..*options };
            let path = path.join(decimated::folder(every_s));
            let writer = Self::of_columns(&path, decimated::names(&columns), &metadata, &options)?;
            Ok(Box::new((RowDecimator::new(every_s, &columns), writer)))
        });
        Ok(Self {
            layout: RecordingLayout::default(),
            options: *options,
            columns,
            metadata,
            table: Some(table),
            asked_for_room: Instant::now(),
            journal,
            segments,
            waits_for_room: false,
            beside: beside.transpose()?,
            rows: 0,
            left_out: 0,
            last_s: 0.0,
        })
    }

    /// Writes a row that has just arrived.
    ///
    /// # Errors
    /// If it does not fit the layout, or the file cannot be written.
    pub fn push(&mut self, row: &RecordingRow) -> Result<(), RecordingError> {
        self.layout.check(row)?;
        let arrived = self.options.has_utc.then(SystemTime::now);
        self.push_cells(row.time_s, &mut || Box::new(stamped(row, arrived)))
    }

    /// Writes the cells of a row that fits the layout.
    fn push_cells<'a>(
        &mut self,
        time_s: f64,
        cells: &mut dyn FnMut() -> Box<dyn Iterator<Item = RowCell<'a>> + 'a>,
    ) -> Result<(), RecordingError> {
        if let Some((decimator, writer)) = self.beside.as_deref_mut()
            && let Some(row) = decimator.push(time_s, cells())
        {
            writer.push_cells(row.time_s, &mut || Box::new(row.cells()))?;
        }
        let bytes = self.table.as_ref().map_or(0, TableWriter::bytes);
        if self.table.is_some() && self.segments.as_ref().is_some_and(|segments| segments.ends_before(time_s, bytes)) {
            self.next_segment(true)?;
        }
        if self.table.is_none() && self.asked_for_room.elapsed() >= ROOM_EVERY {
            let outcome = self.begin_segment();
            self.unless_full(outcome)?;
        }
        // The closed file may have made the room that was missing.
        for _ in 0..2 {
            if self.table.is_none() {
                break;
            }
            match self.write(time_s, cells) {
                Err(error) if self.options.outlasts_full_disk && error.lacks_room() && self.segments.is_some() => {
                    self.next_segment(false)?;
                }
                outcome => return outcome,
            }
        }
        if let Some(table) = self.table.take() {
            drop(table);
            self.asked_for_room = Instant::now();
        }
        self.left_out += 1;
        Ok(())
    }

    fn write<'a>(
        &mut self,
        time_s: f64,
        cells: &mut dyn FnMut() -> Box<dyn Iterator<Item = RowCell<'a>> + 'a>,
    ) -> Result<(), RecordingError> {
        let Some(table) = &mut self.table else { return Ok(()) };
        if self.options.outlasts_full_disk {
            table.reserve()?;
        }
        // First of all it is kept.
        in_journal(&mut self.journal, |journal| journal.push(&mut cells()))?;
        table.push(&mut cells())?;
        self.rows += 1;
        self.last_s = time_s;
        self.segments.iter_mut().for_each(|segments| segments.add(time_s));
        Ok(())
    }

    /// Goes on without a segment where only the room for it is missing.
    fn unless_full(&mut self, outcome: Result<(), RecordingError>) -> Result<(), RecordingError> {
        match outcome {
            Err(error) if self.options.outlasts_full_disk && error.lacks_room() => {
                self.table = None;
                self.asked_for_room = Instant::now();
                Ok(())
            }
            outcome => outcome,
        }
    }

    fn next_segment(&mut self, is_complete: bool) -> Result<(), RecordingError> {
        let outcome = self.close_segment(is_complete).and_then(|()| self.begin_segment());
        self.unless_full(outcome)
    }

    /// Closes the segment, in the room that was reserved for that; the journal begins anew.
    fn close_segment(&mut self, is_complete: bool) -> Result<(), RecordingError> {
        let (Some(segments), Some(table)) = (&mut self.segments, self.table.take()) else { return Ok(()) };
        if table.has_rows() {
            let complete = || vec![("complete".to_owned(), "true".to_owned())];
            let outcome = table.finish(&if is_complete { complete() } else { incomplete(FULL.to_owned()) });
            self.waits_for_room = outcome.as_ref().is_err_and(RecordingError::lacks_room);
            outcome?;
            segments.close(self.last_s);
        }
        self.restart_journal()
    }

    /// The rows until now are in closed segments.
    fn restart_journal(&mut self) -> Result<(), RecordingError> {
        set_number(&mut self.metadata, self.segments.as_ref());
        in_journal(&mut self.journal, |journal| journal.restart(&self.metadata))
    }

    /// Closes the segment that the disk had no room for, from the journal.
    fn close_waiting(&mut self) -> Result<(), RecordingError> {
        if let (true, Some(journal), Some(segments)) = (self.waits_for_room, &mut self.journal, &mut self.segments) {
            journal.sync().map_err(unwritten(&journal.path))?;
            let columns = self.columns.iter().map(|(name, _)| name.clone()).collect();
            recover::close(&journal.path, &segments.path(), columns, FULL)?;
            segments.close(self.last_s);
            self.waits_for_room = false;
            self.restart_journal()?;
        }
        Ok(())
    }

    fn begin_segment(&mut self) -> Result<(), RecordingError> {
        self.asked_for_room = Instant::now();
        self.close_waiting()?;
        let Some(segments) = &self.segments else { return Ok(()) };
        in_journal(&mut self.journal, |journal| journal.refresh(&self.metadata))?;
        let mut table = TableWriter::create(&segments.path(), &self.columns, &self.metadata)?;
        if self.options.outlasts_full_disk {
            table.reserve()?;
        }
        self.table = Some(table);
        Ok(())
    }

    /// Tells whether rows are left out, since the disk is full.
    fn lacks_room(&self) -> bool {
        self.table.is_none()
    }

    /// Has the rows on the disk that have waited long enough, where there is a journal.
    fn sync_if_due(&mut self) -> Result<(), RecordingError> {
        match in_journal(&mut self.journal, Journal::sync_if_due) {
            Err(error) if self.options.outlasts_full_disk && error.lacks_room() => self.next_segment(false),
            outcome => outcome,
        }
    }

    /// Completes the file with what is known at the end (losses, hash …) and gives it its name.
    /// Returns how many rows were left out of a full disk.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(mut self, metadata: &Metadata) -> Result<u64, RecordingError> {
        if let Some((mut decimator, mut writer)) = self.beside.take().map(|beside| *beside) {
            if let Some(row) = decimator.take() {
                writer.push_cells(row.time_s, &mut || Box::new(row.cells()))?;
            }
            writer.finish(metadata)?;
        }
        match in_journal(&mut self.journal, Journal::sync) {
            Err(error) if self.options.outlasts_full_disk && error.lacks_room() => {}
            outcome => outcome?,
        }
        self.close_waiting()?;
        let left_out = (self.left_out > 0).then(|| ("left_out_of_full_disk".to_owned(), self.left_out.to_string()));
        let metadata: Metadata = metadata.iter().cloned().chain(left_out).collect();
        // A segment without rows adds nothing to those before.
        if let Some(table) = self.table.take().filter(|table| self.segments.is_none() || table.has_rows()) {
            table.finish(&metadata)?;
        }
        if let Some(journal) = self.journal {
            let path = journal.path.clone();
            journal.remove().map_err(unwritten(&path))?;
        }
        Ok(self.left_out)
    }

    /// Leaves nothing of a recording that has no row.
    fn discard_if_empty(self) {
        if let Some(journal) = self.journal.filter(|_| self.rows == 0) {
            let _ = journal.remove();
            drop(self.table);
            if let Some(beside) = self.beside {
                beside.1.discard_if_empty();
            }
            self.segments.iter().for_each(Segments::remove_folder);
        }
    }
}

/// Works on a journal, if there is one.
fn in_journal(
    journal: &mut Option<Journal>,
    work: impl FnOnce(&mut Journal) -> io::Result<()>,
) -> Result<(), RecordingError> {
    journal.as_mut().map_or(Ok(()), |journal| work(journal).map_err(unwritten(&journal.path)))
}

/// Tells whether a recording's name is a folder's: without extension, or of one that is there.
/// `.csv` is a name that has been forgotten.
fn is_folder(path: &Path) -> bool {
    let Some(name) = path.file_name() else { return false };
    let hidden = name.to_string_lossy().strip_prefix('.').map(|name| Path::new("r").with_extension(name));
    let is_forgotten = hidden.is_some_and(|recording| check_name(&recording).is_ok());
    !is_forgotten && (path.extension().is_none() || path.is_dir() && check_name(path).is_err())
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

/// Metadata of a file with the number of the format.
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
    let rows = columns.iter().map(|(_, values)| values.len()).min().unwrap_or(0);
    let time_s: Vec<f64> = (0..rows).map(|n| n as f64 * sample_period_s).collect();
    write_table(path, &time_s, columns, metadata)
}

/// The same with times of its own.
///
/// # Errors
/// If the file cannot be written.
pub fn write_table(
    path: &Path,
    time_s: &[f64],
    columns: &[(&str, &[f64])],
    metadata: &Metadata,
) -> Result<(), RecordingError> {
    let names = std::iter::once(TIME).chain(columns.iter().map(|(name, _)| *name));
    let named: Vec<(String, ColumnKind)> = names.map(|name| (name.to_owned(), ColumnKind::Wide)).collect();
    let mut table = TableWriter::create(path, &named, metadata)?;
    let rows = columns.iter().map(|(_, values)| values.len()).min().unwrap_or(0);
    for (n, time_s) in time_s.iter().enumerate().take(rows) {
        let values = columns.iter().map(|(_, values)| values[n]);
        table.push(&mut std::iter::once(*time_s).chain(values).map(RowCell::Number))?;
    }
    table.finish(&Metadata::new())
}

#[cfg(all(test, feature = "parquet"))]
mod tests;
