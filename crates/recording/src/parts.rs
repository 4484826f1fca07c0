//! The files of one recording: a folder of closed segments and a journal, or what a pattern names.
//!
//! | file of a folder | what |
//! |---|---|
//! | `segment-000001.parquet` … | closed segments, each a recording of its own |
//! | `recording.journal` | the rows since the last one; of a recording that goes on, or was cut short |
//!
//! The extension of a file says its format.

use std::path::{Path, PathBuf};

use crate::csv_read::CsvReader;
use crate::error::RecordingError;
use crate::regular;

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

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FileFormat {
    #[cfg(feature = "parquet")]
    Parquet,
    Csv,
    /// CSV that may end in the middle of a row.
    Journal,
}

/// Extension of a journal.
pub(crate) const JOURNAL: &str = "journal";

impl FileFormat {
    pub(crate) fn of(path: &Path) -> Result<Self, RecordingError> {
        let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
        match extension.to_ascii_lowercase().as_str() {
            #[cfg(feature = "parquet")]
            "parquet" => Ok(Self::Parquet),
            #[cfg(not(feature = "parquet"))]
            "parquet" => Err(RecordingError::new(
                path,
                "this program was built without Parquet: use a .csv file, or build it with the feature `parquet`",
            )),
            "csv" => Ok(Self::Csv),
            JOURNAL => Ok(Self::Journal),
            _ => Err(unknown(path)),
        }
    }
}

fn unknown(path: &Path) -> RecordingError {
    RecordingError::new(path, "a recording's name ends in .parquet or .csv")
}

/// Refuses a name that could only fail once the work is done: the extension first of all.
///
/// # Errors
/// If the extension is none of a recording.
pub fn check_name(path: &Path) -> Result<(), RecordingError> {
    match FileFormat::of(path)? {
        FileFormat::Journal => Err(unknown(path)),
        _ => Ok(()),
    }
}

#[cfg(all(test, not(feature = "parquet")))]
mod tests {
    use super::*;

    #[test]
    fn without_its_feature_parquet_is_refused_with_what_would_be_right() {
        let sentence = check_name(Path::new("r.parquet")).unwrap_err().to_string();
        assert_eq!(
            sentence,
            "r.parquet: this program was built without Parquet: use a .csv file, or build it with the feature `parquet`"
        );
        assert!(check_name(Path::new("r.csv")).is_ok());
    }
}

const SEGMENT: &str = "segment-";

/// A segment of a folder.
pub(crate) fn segment_in(folder: &Path, number: u32) -> PathBuf {
    let extension = if cfg!(feature = "parquet") { "parquet" } else { "csv" };
    folder.join(format!("{SEGMENT}{number:06}.{extension}"))
}

/// The number that a segment's name says.
pub(crate) fn number_of_segment(file: &Path) -> Option<u32> {
    let is_table = file.extension().is_some_and(|extension| extension == "parquet" || extension == "csv");
    let number = file.file_stem()?.to_str()?.strip_prefix(SEGMENT)?;
    number.parse().ok().filter(|_| is_table)
}
