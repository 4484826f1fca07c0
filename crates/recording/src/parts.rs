//! The files of one recording: a folder of closed segments and a journal, or what a pattern names.
//!
//! | file of a folder | what |
//! |---|---|
//! | `segment-000001.parquet` … | closed segments, each a recording of its own |
//! | `recording.journal` | the rows since the last one; of a recording that goes on, or was cut short |

use std::path::{Path, PathBuf};

use crate::csv_read::CsvReader;
use crate::error::RecordingError;
use crate::file_format::JOURNAL;
use crate::regular;
use crate::segment_names::number_of_segment;

/// Metadata key: which of its recording's segments a file is, from 1.
pub(crate) const SEGMENT_NUMBER: &str = "segment";

/// The journal of a folder.
pub(crate) fn journal_in(folder: &Path) -> PathBuf {
    folder.join("recording").with_extension(JOURNAL)
}

/// The journal beside a recording that is one file.
pub fn journal_of(file: &Path) -> PathBuf {
    let mut name = file.as_os_str().to_owned();
    name.push(".");
    name.push(JOURNAL);
    name.into()
}

/// The number of the segment that follows those of a folder.
pub(crate) fn next_number(folder: &Path, closed: &[(u32, PathBuf)]) -> Result<u32, RecordingError> {
    let Some((last, file)) = closed.last() else { return Ok(1) };
    last.checked_add(1).ok_or_else(|| {
        RecordingError::new(
            folder,
            format!("no number follows {}: it is none of a recording's; move it away", file.display()),
        )
    })
}

/// The closed segments of a folder, in their order.
pub(crate) fn segments_in(folder: &Path) -> Result<Vec<(u32, PathBuf)>, RecordingError> {
    let unread = |error: std::io::Error| RecordingError::io(folder, "read", error);
    let mut segments = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unread)? {
        let path = entry.map_err(unread)?.path();
        segments.extend(number_of_segment(&path).map(|number| (number, path)));
    }
    segments.sort();
    Ok(segments)
}

/// The number of the segment that a journal's rows will be.
pub(crate) fn number_of(journal: &Path) -> Option<u32> {
    let file = regular::open(journal).ok()?;
    let (source, _) = CsvReader::open(file, journal, true, &[]).ok()?;
    let metadata = source.metadata();
    metadata.iter().find(|(key, _)| key == SEGMENT_NUMBER)?.1.parse().ok()
}

/// Files and folders that a pattern such as `run/*.parquet` names, in the order of their names;
/// another path names itself.
///
/// # Errors
/// If a pattern names nothing, or a folder of it cannot be read.
pub fn named_by(path: &Path) -> Result<Vec<PathBuf>, RecordingError> {
    let pattern = path.to_str().filter(|text| text.contains(['*', '?', '[']) && !path.exists());
    let Some(pattern) = pattern else { return Ok(vec![path.to_owned()]) };
    let matches = glob::glob(pattern).map_err(|error| RecordingError::new(path, format!("is no pattern: {error}")))?;
    let mut named = Vec::new();
    for found in matches {
        named.push(found.map_err(|error| RecordingError::io(error.path(), "read", error.error()))?);
    }
    if named.is_empty() { Err(RecordingError::new(path, "no file has such a name")) } else { Ok(named) }
}

/// The same path for two names of the same file.
pub fn whole_path(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

/// The files that make up a recording, in the order of their rows; one at least.
///
/// # Errors
/// If a folder holds no recording, or a pattern names no file.
pub(crate) fn files_of(path: &Path) -> Result<Vec<PathBuf>, RecordingError> {
    let mut files = Vec::new();
    for named in named_by(path)? {
        files.extend(if named.is_dir() { files_in(&named)? } else { vec![named] });
    }
    Ok(files)
}

/// The files of a folder.
fn files_in(folder: &Path) -> Result<Vec<PathBuf>, RecordingError> {
    let segments = segments_in(folder)?;
    let journal = journal_in(folder);
    // Between the end of a segment and the next journal, the old one repeats its rows.
    let has_more = number_of(&journal).is_some_and(|number| segments.iter().all(|(closed, _)| *closed != number));
    let closed = segments.into_iter().map(|(_, file)| file);
    let files: Vec<PathBuf> = closed.chain(has_more.then_some(journal)).collect();
    if files.is_empty() {
        return Err(RecordingError::new(folder, "is a folder without segment-*.parquet: it holds no recording"));
    }
    Ok(files)
}
