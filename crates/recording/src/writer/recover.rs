//! The rows that a journal has kept of a recording that was cut short become a closed file.

use std::fs::DirEntry;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::journal::take_over;
use super::salvage::{Salvage, Soundness};
use super::table::TableWriter;
use crate::column::{Metadata, overlay};
use crate::error::RecordingError;
use crate::parts::{
    JOURNAL, SEGMENT_NUMBER, journal_in, journal_of, next_number, number_of, number_of_segment, segment_in, segments_in,
};
use crate::reader::RecordingReader;
use crate::temporary::{Temporary, sync_name};

/// Outcome of [`recover`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recovered {
    /// The file that has the rows now.
    pub file: PathBuf,
    /// Number of rows.
    pub rows: u64,
    /// The journal as it was, put aside if a disk has damaged it: lines cannot be read, or a
    /// checksum is not that of the lines before; it keeps its rows where `file` has none.
    pub damaged: Option<PathBuf>,
}

/// Makes a closed file of the rows in a journal, and removes the journal. None if there is none,
/// or if its rows are in a closed file already.
///
/// A journal that a disk has damaged is put aside, and the rows that can be read are taken.
///
/// # Arguments
/// The recording: a folder, the file that was to become one (`run.parquet`), or the journal itself.
///
/// # Errors
/// If another program is writing it, the file is there already, or the disk does not take it.
pub fn recover(recording: &Path) -> Result<Option<Recovered>, RecordingError> {
    let own = recover_own(recording)?;
    for means in every_in(recording) {
        recover_own(&means)?;
    }
    Ok(own)
}

/// Without the decimated recordings in it.
fn recover_own(recording: &Path) -> Result<Option<Recovered>, RecordingError> {
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
    let folder = folder.map(|folder| if folder.as_os_str().is_empty() { Path::new(".") } else { folder });
    let closed = folder.map(segments_in).transpose()?.unwrap_or_default();
    let soundness = Soundness::of(&journal).map_err(|error| RecordingError::io(&journal, "read", error))?;
    let head_is_damaged = soundness.head == Some(false);
    let number = number_of(&journal).filter(|_| !head_is_damaged);
    if let Some((_, file)) = closed.iter().find(|(closed, _)| number == Some(*closed)) {
        // Killed between the end of a segment and the next journal; damaged, its rows were
        // taken, and the program was killed before it was put aside.
        if soundness.damaged > 0 {
            let damaged = Some(put_aside(&journal).map_err(unwritten)?);
            return Ok(Some(Recovered { file: file.clone(), rows: 0, damaged }));
        }
        std::fs::remove_file(&journal).map_err(unwritten)?;
        return Ok(None);
    }
    let file = match folder {
        Some(folder) => segment_in(folder, number.map_or_else(|| next_number(folder, &closed), Ok)?),
        None => journal.with_extension(""),
    };
    Temporary::clear_left(&file);
    if file.exists() {
        let sentence = format!("is there already: move it away, and what {} keeps takes its name", journal.display());
        return Err(RecordingError::new(&file, sentence));
    }
    let before = closed.last().and_then(|(_, file)| RecordingReader::open(file).ok());
    let before = before.map(|reader| reader.names().to_vec());
    let salvage = Salvage::open(&journal, before, head_is_damaged);
    let salvage = salvage.map_err(|error| RecordingError::io(&journal, "read", error))?;
    let (rows, unread) = write(salvage, &journal, &file, |unread| ended(unread, soundness.damaged))?;
    let damaged =
        if unread > 0 || soundness.damaged > 0 { Some(put_aside(&journal).map_err(unwritten)?) } else { None };
    if damaged.is_none() {
        std::fs::remove_file(&journal).map_err(unwritten)?;
    }
    drop(lock);
    Ok((rows > 0 || damaged.is_some()).then_some(Recovered { file, rows, damaged }))
}

/// The decimated recordings in a folder.
fn every_in(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    // None that a link leads to, which may lead back here.
    let is_folder = |entry: &DirEntry| entry.file_type().is_ok_and(|kind| kind.is_dir());
    let is_one = |entry: &DirEntry| is_folder(entry) && entry.file_name().to_string_lossy().starts_with("every-");
    entries.filter(is_one).map(|entry| entry.path()).collect()
}

/// Closes a segment of which its own journal alone has the rows.
pub(super) fn close(journal: &Path, segment: &Path, columns: Vec<String>, why: &str) -> Result<(), RecordingError> {
    let salvage = Salvage::open(journal, Some(columns), false);
    let salvage = salvage.map_err(|error| RecordingError::io(journal, "read", error))?;
    write(salvage, journal, segment, |_| incomplete(why.to_owned())).map(drop)
}

/// Writes the rows of a journal into a file, which says at its end how it came to be; returns how
/// many there are, and how many lines cannot be read. Without rows there is no file.
fn write(
    mut salvage: Salvage,
    journal: &Path,
    file: &Path,
    ended: impl FnOnce(u64) -> Metadata,
) -> Result<(u64, u64), RecordingError> {
    // Only a file in a folder is a segment.
    salvage.metadata.retain(|(key, _)| key != SEGMENT_NUMBER);
    overlay(
        &mut salvage.metadata,
        number_of_segment(file).map(|number| (SEGMENT_NUMBER.to_owned(), number.to_string())),
    );
    let mut table = TableWriter::create(file, &salvage.columns, &salvage.metadata)?;
    let (rows, unread) = salvage.write(journal, &mut table)?;
    if rows > 0 {
        table.finish(&ended(unread))?;
    }
    Ok((rows, unread))
}

/// Why a file of a journal's rows is not complete.
fn ended(unread: u64, damaged: u64) -> Metadata {
    let mut ended = "the program that recorded it ended without closing it".to_owned();
    if unread > 0 || damaged > 0 {
        ended.push_str(&format!(
            ", and its journal was damaged in {damaged} places: {unread} lines could not be read, and others may be wrong"
        ));
    }
    incomplete(ended)
}

/// Metadata of a file that does not end as it was meant to.
pub(super) fn incomplete(why: String) -> Metadata {
    vec![("complete".to_owned(), "false".to_owned()), ("ended".to_owned(), why)]
}

/// Gives a journal a name under which no recording looks for it; returns it.
fn put_aside(journal: &Path) -> std::io::Result<PathBuf> {
    let name = |number: u32| journal.with_extension(format!("damaged-{number}.{JOURNAL}"));
    let aside = (1..).map(name).find(|aside| !aside.exists()).unwrap_or_else(|| name(0));
    std::fs::rename(journal, &aside)?;
    sync_name(&aside)?;
    Ok(aside)
}
