//! A writer in a thread of its own: a disk that takes its time does not keep the instrument's rows
//! waiting. Owned rows go to the thread, or are made of many.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::SystemTime;

use super::journal::SYNC_EVERY;
use super::{RecordingWriter, WriterOptions};
use crate::column::{Metadata, RowCell};
use crate::error::RecordingError;
use crate::row::{RecordingLayout, RecordingRow};
use crate::utc::seconds_of;

/// Rows that may wait for the disk: a minute at 1 kHz. Then the instrument waits, too.
const MOST_WAITING: usize = 60_000;

/// News of the thread.
#[derive(Default)]
struct WriterNews {
    lacks_room: AtomicBool,
    left_out: AtomicU64,
    segment: AtomicU32,
}

impl WriterNews {
    fn take(&self, writer: &RecordingWriter) {
        self.lacks_room.store(writer.lacks_room(), Relaxed);
        self.left_out.store(writer.left_out, Relaxed);
        self.segment.store(writer.segments.as_ref().map_or(1, |segments| segments.number), Relaxed);
    }
}

/// A [`RecordingWriter`] in a thread of its own.
pub struct Recorder {
    layout: RecordingLayout,
    has_utc: bool,
    news: Arc<WriterNews>,
    // Dropped, it ends the thread.
    rows: Option<SyncSender<OwnedRow>>,
    writer: Option<JoinHandle<Result<RecordingWriter, RecordingError>>>,
}

impl Recorder {
    /// Starts a recording.
    ///
    /// # Errors
    /// As [`RecordingWriter::create`]; or if there is no thread to be had.
    pub fn create(
        path: &Path,
        layout: RecordingLayout,
        metadata: &Metadata,
        options: &WriterOptions,
    ) -> Result<Self, RecordingError> {
        let writer = RecordingWriter::with_options(path, layout.clone(), metadata, options)?;
        let (sender, receiver) = sync_channel(MOST_WAITING);
        let thread = std::thread::Builder::new().name("recorder".to_owned());
        let news = Arc::new(WriterNews::default());
        news.take(&writer);
        let shared = Arc::clone(&news);
        let writer = thread.spawn(move || write(writer, &receiver, &shared));
        let writer = writer.map_err(|error| RecordingError::new(path, format!("no thread can be had: {error}")))?;
        Ok(Self { layout, has_utc: options.has_utc, news, rows: Some(sender), writer: Some(writer) })
    }

    /// Hands on a row that has just arrived.
    ///
    /// # Errors
    /// If it does not fit the layout, or an earlier one could not be written.
    pub fn push(&mut self, row: &RecordingRow) -> Result<(), RecordingError> {
        self.push_at(row, SystemTime::now())
    }

    /// Hands on a row that arrived at this moment.
    ///
    /// # Errors
    /// As [`Recorder::push`].
    pub fn push_at(&mut self, row: &RecordingRow, arrived: SystemTime) -> Result<(), RecordingError> {
        self.layout.check(row)?;
        let sent = self.rows.as_ref().map(|rows| rows.send(OwnedRow::of(row, self.has_utc.then_some(arrived))));
        // The thread takes rows until one cannot be written.
        if let Some(Ok(())) = sent { Ok(()) } else { self.end().map(drop) }
    }

    /// Tells whether rows are left out, since the disk is full.
    pub fn lacks_room(&self) -> bool {
        self.news.lacks_room.load(Relaxed)
    }

    /// Rows that were left out of a full disk so far.
    pub fn left_out(&self) -> u64 {
        self.news.left_out.load(Relaxed)
    }

    /// Number of the segment that is written, from 1.
    pub fn segment(&self) -> u32 {
        self.news.segment.load(Relaxed)
    }

    /// Waits for the rows before, and completes the file with what is known at the end. Returns how
    /// many rows were left out of a full disk.
    ///
    /// # Errors
    /// If anything could not be written.
    pub fn finish(mut self, metadata: &Metadata) -> Result<u64, RecordingError> {
        match self.end()? {
            Some(writer) => writer.finish(metadata),
            None => Ok(0),
        }
    }

    fn end(&mut self) -> Result<Option<RecordingWriter>, RecordingError> {
        self.rows = None;
        match self.writer.take().map(JoinHandle::join) {
            Some(Ok(written)) => written.map(Some),
            Some(Err(panic)) => std::panic::resume_unwind(panic),
            None => Ok(None),
        }
    }
}

impl Drop for Recorder {
    /// The pushed rows are in the journal, where there is one.
    fn drop(&mut self) {
        if let Ok(Some(writer)) = self.end() {
            writer.discard_if_empty();
        }
    }
}

fn write(
    mut writer: RecordingWriter,
    rows: &Receiver<OwnedRow>,
    news: &WriterNews,
) -> Result<RecordingWriter, RecordingError> {
    loop {
        news.take(&writer);
        match rows.recv_timeout(SYNC_EVERY) {
            Ok(row) => writer.push_cells(row.time_s, &mut || Box::new(row.cells()))?,
            Err(RecvTimeoutError::Timeout) => writer.sync_if_due()?,
            Err(RecvTimeoutError::Disconnected) => return Ok(writer),
        }
    }
}

pub(super) struct OwnedRow {
    pub time_s: f64,
    pub cells: Vec<OwnedCell>,
}

pub(super) enum OwnedCell {
    Number(f64),
    Text(Box<str>),
}

impl OwnedRow {
    pub fn of(row: &RecordingRow, arrived: Option<SystemTime>) -> Self {
        let owned = |cell: RowCell| match cell {
            RowCell::Number(number) => OwnedCell::Number(number),
            RowCell::Text(text) => OwnedCell::Text(text.into()),
        };
        Self { time_s: row.time_s, cells: stamped(row, arrived).map(owned).collect() }
    }

    pub fn cells(&self) -> impl Iterator<Item = RowCell<'_>> {
        self.cells.iter().map(|cell| match cell {
            OwnedCell::Number(number) => RowCell::Number(*number),
            OwnedCell::Text(text) => RowCell::Text(text),
        })
    }
}

/// The cells of a row, with the moment at which it arrived behind its time.
pub(super) fn stamped<'a>(row: &'a RecordingRow<'_>, arrived: Option<SystemTime>) -> impl Iterator<Item = RowCell<'a>> {
    let mut cells = row.cells();
    cells.next().into_iter().chain(arrived.map(|arrived| RowCell::Number(seconds_of(arrived)))).chain(cells)
}
