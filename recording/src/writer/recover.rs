//! What a journal has kept of a recording that was cut short becomes a closed file.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::journal::take_over;
use super::salvage::Salvage;
use super::table::TableWriter;
use crate::column::Metadata;
use crate::error::RecordingError;
use crate::file_format::JOURNAL;
use crate::parts::{SEGMENT_NUMBER, journal_in, journal_of, number_of, segment_in, segments_in};
use crate::reader::RecordingReader;
use crate::temporary::{Temporary, sync_name};

/// What [`recover`] has done.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recovered {
    /// The file that has the rows now.
    pub file: PathBuf,
    /// How many.
    pub rows: u64,
    /// The journal as it was, put aside if some of it could not be read; it keeps its rows where
    /// `file` has none.
    pub damaged: Option<PathBuf>,
}

/// Makes a closed file of the rows in a journal, and removes the journal. None if there is none,
/// or if its rows are in a closed file already.
///
/// A journal of which some cannot be read is put aside, and the rows that can be read are taken.
///
/// # Arguments
/// The recording: a folder, the file that was to become one (`run.parquet`), or the journal itself.
///
/// # Errors
/// If another program is writing it, the file is there already, or the disk does not take it.
pub fn recover(recording: &Path) -> Result<Option<Recovered>, RecordingError> {
    for means in every_in(recording) {
        recover(&means)?;
    }
    let journal = match recording.extension() {
        Some(extension) if extension == JOURNAL => recording.to_owned(),
        _ if recording.is_dir() => journal_in(recording),
        _ => journal_of(recording),
    };
    let lock = match take_over(&journal) {
        Ok(lock) => lock,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        Err(error) if error.kind() == ErrorKind::WouldBlock => {
            return Err(RecordingError::new(&journal, "another program is recording there"));
        }
        Err(error) => return Err(RecordingError::io(&journal, "read", error)),
    };
    let unwritten = |error| RecordingError::io(&journal, "removed", error);
    let folder = journal.parent().filter(|folder| journal_in(folder) == journal);
    let closed = folder.map(segments_in).transpose()?.unwrap_or_default();
    let number = number_of(&journal);
    if number.is_some_and(|number| closed.iter().any(|(closed, _)| *closed == number)) {
        std::fs::remove_file(&journal).map_err(unwritten)?;
        return Ok(None);
    }
    let next = closed.last().map_or(1, |(last, _)| last + 1);
    let file = folder.map_or(journal.with_extension(""), |folder| segment_in(folder, number.unwrap_or(next)));
    Temporary::clear_left(&file);
    if file.exists() {
        let sentence = format!("is there already: move it away, and what {} keeps takes its name", journal.display());
        return Err(RecordingError::new(&file, sentence));
    }
    let before = closed.last().and_then(|(_, file)| RecordingReader::open(file).ok());
    let before = before.map(|reader| reader.names().to_vec());
    let (rows, unread) = write(&journal, &file, before)?;
    let damaged = if unread > 0 { Some(put_aside(&journal).map_err(unwritten)?) } else { None };
    if damaged.is_none() {
        std::fs::remove_file(&journal).map_err(unwritten)?;
    }
    drop(lock);
    Ok((rows > 0 || damaged.is_some()).then_some(Recovered { file, rows, damaged }))
}

/// The decimated recordings in a folder.
fn every_in(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let is_one = |path: &PathBuf| {
        path.is_dir() && path.file_name().and_then(|name| name.to_str()).is_some_and(|name| name.starts_with("every-"))
    };
    entries.map(|entry| entry.path()).filter(is_one).collect()
}

/// Writes the rows of a journal into a file; returns how many there are, and how many lines cannot
/// be read. Without rows there is no file.
fn write(journal: &Path, file: &Path, before: Option<Vec<String>>) -> Result<(u64, u64), RecordingError> {
    let mut salvage = Salvage::open(journal, before).map_err(|error| RecordingError::io(journal, "read", error))?;
    // Only a file in a folder is a segment.
    let is_segment = journal_in(file.parent().unwrap_or(Path::new(""))) == journal;
    salvage.metadata.retain(|(key, _)| key != SEGMENT_NUMBER || is_segment);
    let mut table = TableWriter::create(file, &salvage.columns, &salvage.metadata)?;
    let (rows, unread) = salvage.write(journal, &mut table)?;
    if rows > 0 {
        table.finish(&ended(unread))?;
    }
    Ok((rows, unread))
}

fn ended(unread: u64) -> Metadata {
    let mut ended = "the program that recorded it ended without closing it".to_owned();
    if unread > 0 {
        ended.push_str(&format!(", and {unread} lines of its journal could not be read"));
    }
    [("complete", "false".to_owned()), ("ended", ended)].map(|(key, value)| (key.to_owned(), value)).to_vec()
}

/// Gives a journal a name under which no recording looks for it; returns it.
fn put_aside(journal: &Path) -> std::io::Result<PathBuf> {
    let name = |number: u32| journal.with_extension(format!("damaged-{number}.{JOURNAL}"));
    let aside = (1..).map(name).find(|aside| !aside.exists()).unwrap_or_else(|| name(0));
    std::fs::rename(journal, &aside)?;
    sync_name(&aside)?;
    Ok(aside)
}
