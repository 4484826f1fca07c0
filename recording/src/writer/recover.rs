//! What a journal has kept of a recording that was cut short becomes a closed file.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::journal::take_over;
use super::table::TableWriter;
use crate::column::{ColumnKind, Metadata, cells_of_row};
use crate::error::RecordingError;
use crate::file_format::JOURNAL;
use crate::parts::{SEGMENT_NUMBER, journal_in, journal_of, number_of, segment_in, segments_in};
use crate::reader::RecordingReader;
use crate::temporary::Temporary;

/// What [`recover`] has done.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recovered {
    /// The file that has the rows now.
    pub file: PathBuf,
    /// How many.
    pub rows: u64,
}

/// Makes a closed file of the rows in a journal, and removes the journal. None if there is none,
/// or if its rows are in a closed file already.
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
    let file = match (folder, number_of(&journal)) {
        (Some(folder), Some(number)) => {
            if segments_in(folder)?.iter().any(|(closed, _)| *closed == number) {
                std::fs::remove_file(&journal).map_err(unwritten)?;
                return Ok(None);
            }
            segment_in(folder, number)
        }
        // Its columns' names did not reach the disk: there is no row.
        (Some(_), None) => {
            std::fs::remove_file(&journal).map_err(unwritten)?;
            return Ok(None);
        }
        (None, _) => journal.with_extension(""),
    };
    Temporary::clear_left(&file);
    if file.exists() {
        let sentence = format!("is there already: move it away, and what {} keeps takes its name", journal.display());
        return Err(RecordingError::new(&file, sentence));
    }
    let rows = write(&journal, &file)?;
    std::fs::remove_file(&journal).map_err(unwritten)?;
    drop(lock);
    Ok((rows > 0).then_some(Recovered { file, rows }))
}

/// The decimated recordings in a folder.
fn every_in(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let is_one = |path: &PathBuf| {
        path.is_dir() && path.file_name().and_then(|name| name.to_str()).is_some_and(|name| name.starts_with("every-"))
    };
    entries.map(|entry| entry.path()).filter(is_one).collect()
}

/// Writes the rows of a journal into a file; returns how many there are. None leave no file.
fn write(journal: &Path, file: &Path) -> Result<u64, RecordingError> {
    let mut reader = match RecordingReader::open(journal) {
        Ok(reader) => reader,
        // Not even the columns' names reached the disk.
        Err(_) => return Ok(0),
    };
    let columns = ColumnKind::of_each(reader.names().iter().cloned());
    let mut known: Metadata = reader.metadata();
    known.retain(|(key, _)| key != SEGMENT_NUMBER || journal_in(file.parent().unwrap_or(Path::new(""))) == journal);
    let mut table = TableWriter::create(file, &columns, &known)?;
    let mut rows = 0;
    while let Some(chunk) = reader.next_chunk()? {
        for row in 0..chunk.first().map_or(0, |column| column.values.len()) {
            table.push(&mut cells_of_row(&chunk, row))?;
            rows += 1;
        }
    }
    if rows > 0 {
        let ended = [("complete", "false"), ("ended", "the program that recorded it ended without closing it")];
        table.finish(&ended.map(|(key, value)| (key.to_owned(), value.to_owned())).to_vec())?;
    }
    Ok(rows)
}
