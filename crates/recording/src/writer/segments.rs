//! The segments of a folder: which is written, when the next one begins, which are too old.

use std::collections::VecDeque;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::WriterOptions;
use super::journal::is_held;
use super::options::SegmentLength;
use super::table::unwritten;
use crate::column::{ColumnValues, Metadata};
use crate::error::RecordingError;
use crate::parts::{journal_in, next_number, segments_in};
use crate::reader::RecordingReader;
use crate::segment_names::segment_in;
use crate::temporary::sync_name;

/// A recording in a folder that another one continues.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordingSoFar {
    /// What its last segment says of itself.
    pub metadata: Metadata,
    /// Time of its last row, s.
    pub last_s: f64,
}

/// What is in a folder, if it is there and has a closed segment.
///
/// # Errors
/// If the last segment cannot be read.
pub fn so_far(folder: &Path) -> Result<Option<RecordingSoFar>, RecordingError> {
    let segments = if folder.is_dir() { segments_in(folder)? } else { Vec::new() };
    let Some((_, last)) = segments.last() else { return Ok(None) };
    let mut reader = RecordingReader::open(last)?;
    reader.select(&[0]);
    let mut last_s = 0.0;
    while let Some(columns) = reader.next_chunk()? {
        if let Some(ColumnValues::Numbers(times)) = columns.first().map(|column| &column.values) {
            last_s = times.last().copied().unwrap_or(last_s);
        }
    }
    Ok(Some(RecordingSoFar { metadata: reader.metadata(), last_s }))
}

/// Whether a program is recording into a folder.
pub fn is_being_written(folder: &Path) -> bool {
    is_held(&journal_in(folder))
}

pub(super) struct Segments {
    folder: PathBuf,
    length: SegmentLength,
    keep_s: Option<f64>,
    pub number: u32,
    /// Time of the segment's first row, s.
    begin_s: Option<f64>,
    /// Closed segments with the time of their last row, s; of earlier programs, before the first
    /// row of this one, how long before it.
    closed: VecDeque<(PathBuf, f64)>,
    has_begun: bool,
}

impl Segments {
    /// Makes a folder for a new recording, or goes on in one.
    pub fn new(folder: &Path, options: &WriterOptions, columns: &[String]) -> Result<Self, RecordingError> {
        match std::fs::create_dir(folder) {
            Ok(()) => sync_name(folder).map_err(unwritten(folder))?,
            Err(error) if error.kind() == ErrorKind::AlreadyExists && folder.is_dir() => {}
            Err(error) => return Err(unwritten(folder)(error)),
        }
        let before = segments_in(folder)?;
        if let Some((_, last)) = before.last() {
            if !options.appends {
                return Err(RecordingError::new(folder, "holds a recording already: name another folder"));
            }
            if RecordingReader::open(last)?.names() != columns {
                let sentence = "holds a recording with other columns: name another folder";
                return Err(RecordingError::new(folder, sentence));
            }
        }
        let age_s = |path: &Path| {
            let closed = path.metadata().and_then(|file| file.modified()).ok();
            closed.and_then(|closed| SystemTime::now().duration_since(closed).ok()).map_or(0.0, |age| age.as_secs_f64())
        };
        Ok(Self {
            folder: folder.to_owned(),
            length: options.segment,
            keep_s: options.keep_s,
            number: next_number(folder, &before)?,
            begin_s: None,
            closed: before.into_iter().map(|(_, path)| (path.clone(), -age_s(&path))).collect(),
            has_begun: false,
        })
    }

    /// Refuses to go on where another program has closed segments since [`Segments::new`] looked.
    /// The caller has the journal now, so that none does from here on.
    pub fn check_number(&self) -> Result<(), RecordingError> {
        if next_number(&self.folder, &segments_in(&self.folder)?)? == self.number {
            return Ok(());
        }
        Err(RecordingError::new(&self.folder, "another program has recorded there in this moment: start once more"))
    }

    pub fn path(&self) -> PathBuf {
        segment_in(&self.folder, self.number)
    }

    /// Only if nothing else is in it.
    pub fn remove_folder(&self) {
        let _ = std::fs::remove_dir(&self.folder);
    }

    /// Whether a row belongs into the next segment.
    pub fn ends_before(&self, time_s: f64, bytes: u64) -> bool {
        self.begin_s.is_some_and(|begin_s| match self.length {
            // A row's time may be rounded.
            SegmentLength::Seconds(length_s) => time_s - begin_s >= length_s * (1.0 - 1e-9),
            SegmentLength::Bytes(length) => bytes >= length,
        })
    }

    /// A row has been written.
    pub fn add(&mut self, time_s: f64) {
        if !std::mem::replace(&mut self.has_begun, true) {
            self.closed.iter_mut().for_each(|(_, end_s)| *end_s += time_s);
        }
        self.begin_s.get_or_insert(time_s);
    }

    /// The segment has been closed; the next one has the next number.
    pub fn close(&mut self, end_s: f64) {
        self.closed.push_back((self.path(), end_s));
        self.number += 1;
        self.begin_s = None;
        while let Some((path, _)) =
            self.closed.front().filter(|(_, old_s)| self.keep_s.is_some_and(|keep_s| end_s - old_s > keep_s))
        {
            // Somebody may have taken it away.
            let _ = std::fs::remove_file(path);
            self.closed.pop_front();
        }
    }
}
