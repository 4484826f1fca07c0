//! Reading a recording in chunks, file after file.

use std::path::{Path, PathBuf};

use crate::column::{ChunkSource, Metadata, RecordingColumn, TableHead, overlay};
use crate::csv_read::CsvReader;
use crate::error::RecordingError;
use crate::interrupt::is_interrupted;
use crate::names::{FORMAT, duplicate};
use crate::parts::{FileFormat, files_of};
use crate::{in_memory, regular};

/// A recording that is read chunk by chunk, in memory that does not grow with its length.
pub struct RecordingReader {
    head: TableHead,
    source: Box<dyn ChunkSource>,
    /// Files that follow, the next one last.
    following: Vec<PathBuf>,
    /// Metadata of the files before.
    passed: Metadata,
    /// Columns to be taken for text.
    as_text: Vec<usize>,
    /// Columns to be taken for moments.
    as_time: Vec<usize>,
    /// Names in place of the files' own.
    given: Vec<String>,
}

impl RecordingReader {
    /// Opens a file, a folder of segments, or the files that a pattern (`run/*.parquet`) names.
    ///
    /// # Errors
    /// If there is no such file, its extension is not known, it is no table with named columns, or a
    /// recording of another format.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        Self::open_named(path, &[])
    }

    /// Opens like [`RecordingReader::open`], with these names for the columns in place of the
    /// file's own, if it has such at all; with none as they are.
    ///
    /// # Errors
    /// As there, or if there are more or fewer columns.
    pub fn open_named(path: &Path, given: &[String]) -> Result<Self, RecordingError> {
        let mut following = files_of(path)?;
        following.reverse();
        let first = following.pop().unwrap_or_else(|| path.to_owned());
        let (source, names) = open_file(&first, given)?;
        let selected = (0..names.len()).collect();
        let head = TableHead { path: first, names, selected };
        Ok(Self {
            head,
            source,
            following,
            passed: Metadata::new(),
            as_text: Vec::new(),
            as_time: Vec::new(),
            given: given.to_vec(),
        })
    }

    /// Names of the columns, in the file's order.
    pub fn names(&self) -> &[String] {
        &self.head.names
    }

    /// Metadata of the files, the later ones in place of the earlier. A CSV file may say more below
    /// its last row: complete after the last chunk.
    pub fn metadata(&self) -> Metadata {
        let mut metadata = self.passed.clone();
        overlay(&mut metadata, self.source.metadata());
        metadata
    }

    /// Number of rows, where a single file states it, as a Parquet file does.
    pub fn rows(&self) -> Option<u64> {
        self.source.rows().filter(|_| self.following.is_empty())
    }

    /// Tells whether each column holds text: by its type, or by its first row in a CSV file.
    pub fn holds_text(&mut self) -> Result<Vec<bool>, RecordingError> {
        self.source.holds_text(&self.head)
    }

    /// Hands out only these columns (as they stand in [`RecordingReader::names`]), in this order,
    /// and spares itself the others. Before the first chunk.
    pub fn select(&mut self, columns: &[usize]) {
        self.head.selected = columns.to_vec();
    }

    /// Takes a column of a CSV file for text even if its first row looks like a number. Parquet's
    /// columns have their types.
    pub fn read_as_text(&mut self, column: usize) {
        self.as_text.push(column);
        self.source.read_as_text(column);
    }

    /// Takes a column of text for moments in ISO 8601: it is handed out as seconds since 1970.
    pub fn read_as_time(&mut self, column: usize) {
        self.as_time.push(column);
        self.source.read_as_time(column);
    }

    /// Units that a line below the names states for each column, as loggers state units there; none
    /// without such a line.
    pub fn units(&self) -> &[String] {
        self.source.units()
    }

    /// Passes over rows before the first chunk; returns how many there were.
    pub fn skip(&mut self, rows: u64) -> Result<u64, RecordingError> {
        let mut skipped = 0;
        loop {
            skipped += self.source.skip(rows - skipped, &self.head)?;
            if skipped == rows || !self.open_next()? {
                return Ok(skipped);
            }
        }
    }

    /// The next rows of the selected columns, [`CHUNK`](crate::CHUNK) of them at most; `None` after
    /// the last.
    pub fn next_chunk(&mut self) -> Result<Option<Vec<RecordingColumn>>, RecordingError> {
        if is_interrupted() {
            return Err(RecordingError::new(&self.head.path, "reading it was interrupted"));
        }
        let chunk = loop {
            match self.source.next_chunk(&self.head)? {
                None if self.open_next()? => {}
                chunk => break chunk,
            }
        };
        let head = &self.head;
        let named = |(&at, values): (&usize, _)| RecordingColumn { name: head.names[at].clone(), values };
        Ok(chunk.map(|columns| head.selected.iter().zip(columns).map(named).collect()))
    }

    /// Goes on with the next file, if there is one. It has the columns of the first.
    fn open_next(&mut self) -> Result<bool, RecordingError> {
        let Some(path) = self.following.pop() else { return Ok(false) };
        let (source, names) = open_file(&path, &self.given)?;
        if names != self.head.names {
            let other = names.iter().zip(&self.head.names).find(|(name, first)| name != first);
            let what = other.map_or_else(
                || format!("{} columns where {} belong", names.len(), self.head.names.len()),
                |(name, first)| format!("`{name}` where `{first}` belongs"),
            );
            let sentence = format!("has {what}: it is of another recording than {}", self.head.path.display());
            return Err(RecordingError::new(&path, sentence));
        }
        overlay(&mut self.passed, self.source.metadata());
        self.source = source;
        self.as_text.iter().for_each(|&column| self.source.read_as_text(column));
        self.as_time.iter().for_each(|&column| self.source.read_as_time(column));
        self.head.path = path;
        Ok(true)
    }
}

fn open_on_disk(path: &Path, given: &[String]) -> Result<(Box<dyn ChunkSource>, Vec<String>), RecordingError> {
    let format = FileFormat::of(path)?;
    let file = regular::open(path).map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => RecordingError::new(path, "there is no such file"),
        _ => RecordingError::io(path, "read", error),
    })?;
    match format {
        #[cfg(feature = "parquet")]
        FileFormat::Parquet => crate::parquet::ParquetReader::open(file, path),
        FileFormat::Csv => CsvReader::open(file, path, false, given),
        FileFormat::Journal => CsvReader::open(file, path, true, given),
    }
}

/// Refuses a file whose columns mean something else. A foreign file may say `format` in words.
fn check_format(path: &Path, metadata: &Metadata) -> Result<(), RecordingError> {
    let (key, current) = FORMAT;
    let said = metadata.iter().find(|(name, _)| name == key).map(|(_, value)| value.trim());
    match said.filter(|said| said.parse::<u64>().is_ok() && *said != current) {
        Some(said) => {
            let sentence =
                format!("is of format {said}, and this anemo reads format {current}: use the anemo that wrote it");
            Err(RecordingError::new(path, sentence))
        }
        None => Ok(()),
    }
}

/// Opens one file or table in memory, and tells the names of its columns.
fn open_file(path: &Path, given: &[String]) -> Result<(Box<dyn ChunkSource>, Vec<String>), RecordingError> {
    let (source, mut names) = match in_memory::open(path) {
        Some(table) => table,
        None => open_on_disk(path, given)?,
    };
    if !given.is_empty() {
        let (has, wanted) = (names.len(), given.len());
        if has != wanted {
            let sentence = format!("has {has} columns, and {wanted} names are given for them: name each");
            return Err(RecordingError::new(path, sentence));
        }
        names = given.to_vec();
    }
    check_format(path, &source.metadata())?;
    if let Some(name) = duplicate(names.iter().map(String::as_str)) {
        return Err(RecordingError::new(path, format!("two columns are named `{name}`: rename one of them")));
    }
    Ok((source, names))
}
