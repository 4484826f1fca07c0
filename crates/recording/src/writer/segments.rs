//! The segments of a folder: which is written, when the next one begins, which are too old; and the
//! options of a growing recording.

use std::collections::VecDeque;
use std::fmt;
use std::io::ErrorKind;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::SystemTime;

use super::journal::is_held;
use super::table::unwritten;
use crate::column::{ColumnValues, Metadata};
use crate::error::RecordingError;
use crate::parts::{journal_in, next_number, segment_in, segments_in};
use crate::reader::RecordingReader;
use crate::temporary::sync_name;

/// A recording in a folder that another one continues.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordingSoFar {
    /// Metadata of its last segment.
    pub metadata: Metadata,
    /// Time of its last row, s.
    pub last_s: f64,
}

/// Segments of a folder, if it is there and has a closed segment.
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

/// Tells whether a program is recording into a folder.
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

    /// Tells whether a row belongs into the next segment.
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

/// When a segment of a folder is closed and the next one begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SegmentLength {
    /// So many seconds of rows.
    Seconds(f64),
    /// So many bytes, at most.
    Bytes(u64),
}

impl Default for SegmentLength {
    fn default() -> Self {
        Self::Seconds(600.0)
    }
}

/// A text that is no length.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}`: a time from 1 s to 100 years (30s, 10min, 1h, 1d) or a size from 1 kB to 1 TB (500kB, 64MB, 1GB) belongs here"
)]
pub struct SegmentLengthError(String);

/// Beyond them, somebody forgot a unit.
const SECONDS: RangeInclusive<f64> = 1.0..=100.0 * 365.25 * 86_400.0;
const BYTES: RangeInclusive<f64> = 1e3..=1e12;
/// Seconds in a unit.
const TIMES: [(&str, f64); 4] = [("s", 1.0), ("min", 60.0), ("h", 3600.0), ("d", 86_400.0)];
/// Bytes in a unit.
const SIZES: [(&str, f64); 3] = [("kB", 1e3), ("MB", 1e6), ("GB", 1e9)];

impl FromStr for SegmentLength {
    type Err = SegmentLengthError;

    /// Reads `10min` or `64MB`.
    fn from_str(text: &str) -> Result<Self, SegmentLengthError> {
        let end = text.find(|letter: char| !letter.is_ascii_digit() && letter != '.').unwrap_or(text.len());
        let (number, unit) = text.split_at(end);
        let number = number.parse::<f64>().ok().filter(|number| *number > 0.0);
        let of =
            |units: &[(&str, f64)]| units.iter().find(|(known, _)| *known == unit.trim()).map(|(_, in_one)| *in_one);
        match (number, of(&TIMES), of(&SIZES)) {
            (Some(number), Some(seconds), _) if SECONDS.contains(&(number * seconds)) => {
                Ok(Self::Seconds(number * seconds))
            }
            (Some(number), _, Some(bytes)) if BYTES.contains(&(number * bytes)) => {
                Ok(Self::Bytes((number * bytes) as u64))
            }
            _ => Err(SegmentLengthError(text.to_owned())),
        }
    }
}

impl fmt::Display for SegmentLength {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Seconds(seconds) => write!(f, "{seconds}s"),
            Self::Bytes(bytes) => write!(f, "{}kB", bytes as f64 / 1e3),
        }
    }
}

/// Options of a recording that grows.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WriterOptions {
    /// A file has a journal beside it, from which its rows can be had if the program is killed. A
    /// folder always has one.
    pub has_journal: bool,
    /// Length of a folder's segments.
    pub segment: SegmentLength,
    /// Rows carry the moment at which they arrived. Every file ends then with the drift of the
    /// instrument's clock by that of the host.
    pub has_utc: bool,
    /// For a folder: go on behind the segments that are there, which have the same columns.
    pub appends: bool,
    /// For a folder: remove segments whose rows are older than this, s.
    pub keep_s: Option<f64>,
    /// For a folder: write mean, least and greatest of so many seconds into a folder in it.
    pub every_s: Option<f64>,
    /// For a folder: close the segment when the disk is full, leave rows out, and begin the next
    /// one when there is room. Without it, a full disk is an error.
    pub outlasts_full_disk: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_of_segments_are_read_with_their_units() {
        for (text, length) in [
            ("10min", SegmentLength::Seconds(600.0)),
            ("1.5h", SegmentLength::Seconds(5400.0)),
            ("64MB", SegmentLength::Bytes(64_000_000)),
            ("600s", SegmentLength::default()),
        ] {
            assert_eq!(text.parse(), Ok(length), "{text}");
            assert_eq!(length.to_string().parse(), Ok(length));
        }
        for text in
            ["", "10", "min", "-1min", "0s", "0.5s", "10 parsec", "1e3s", "NaNs", "99999999d", "0.0001kB", "2000GB"]
        {
            assert!(text.parse::<SegmentLength>().unwrap_err().to_string().contains("10min"), "{text}");
        }
    }
}
