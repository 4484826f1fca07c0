//! Tables and texts of other programs in this process, under names that are read like files.
//!
//! Whatever reads a recording or a text by its path so reads what a caller has in memory: a data
//! frame, a model, an experiment. A name lasts as long as its [`InMemory`].

use std::collections::HashMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, LazyLock, PoisonError, RwLock};

use crate::column::{CHUNK, ChunkSource, ColumnValues, Metadata, RecordingColumn, TableHead};
use crate::error::RecordingError;

/// A column's type of another library.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("is of the type {0}, which is neither number nor text")]
pub struct ForeignType(pub String);

/// A table of somebody else, of which rows are copied as they are read.
pub trait MemoryTable: Send + Sync {
    /// Names of its columns.
    fn names(&self) -> Vec<String>;
    /// Number of rows.
    fn rows(&self) -> usize;
    /// Tells whether a column holds text.
    fn holds_text(&self, column: usize) -> bool;
    /// Some rows of a column.
    ///
    /// # Errors
    /// If it has a type that is neither number nor text.
    fn values(&self, column: usize, rows: Range<usize>) -> Result<ColumnValues, ForeignType>;
    /// Metadata.
    fn metadata(&self) -> Metadata {
        Metadata::new()
    }
}

/// Columns of a recording, and what it says of itself.
#[derive(Debug, Clone, PartialEq)]
pub struct MemoryColumns {
    /// In the order of a file.
    pub columns: Vec<RecordingColumn>,
    /// By key.
    pub metadata: Metadata,
}

impl MemoryTable for MemoryColumns {
    fn names(&self) -> Vec<String> {
        self.columns.iter().map(|column| column.name.clone()).collect()
    }

    fn rows(&self) -> usize {
        self.columns.first().map_or(0, |column| column.values.len())
    }

    fn holds_text(&self, column: usize) -> bool {
        matches!(self.columns[column].values, ColumnValues::Words(_))
    }

    fn values(&self, column: usize, rows: Range<usize>) -> Result<ColumnValues, ForeignType> {
        Ok(self.columns[column].values.between(rows))
    }

    fn metadata(&self) -> Metadata {
        self.metadata.clone()
    }
}

#[derive(Clone)]
enum Kept {
    Table(Arc<dyn MemoryTable>),
    Text(Arc<str>),
    /// Where a recording is to be put.
    Place,
    Written(Arc<MemoryColumns>),
}

static KEPT: LazyLock<RwLock<HashMap<PathBuf, Kept>>> = LazyLock::new(RwLock::default);
static NEXT: AtomicU64 = AtomicU64::new(1);

/// A name for something in memory; dropped, the name is gone.
#[derive(Debug)]
pub struct InMemory {
    path: PathBuf,
}

impl InMemory {
    /// A table that is read like a recording.
    pub fn table(table: Arc<dyn MemoryTable>) -> Self {
        Self::keep(Path::new(""), "parquet", Kept::Table(table))
    }

    /// A text that is read like a file of that extension; what it names is sought from `folder`.
    pub fn text(folder: &Path, extension: &str, text: &str) -> Self {
        Self::keep(folder, extension, Kept::Text(text.into()))
    }

    /// A place that a recording may be written to.
    pub fn place() -> Self {
        Self::keep(Path::new(""), "parquet", Kept::Place)
    }

    fn keep(folder: &Path, extension: &str, what: Kept) -> Self {
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let path = folder.join(format!("memory:{number}.{extension}"));
        KEPT.write().unwrap_or_else(PoisonError::into_inner).insert(path.clone(), what);
        Self { path }
    }

    /// The name.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Columns that were put there, if any were.
    pub fn take(self) -> Option<MemoryColumns> {
        match KEPT.write().unwrap_or_else(PoisonError::into_inner).remove(&self.path) {
            Some(Kept::Written(columns)) => Some(Arc::unwrap_or_clone(columns)),
            _ => None,
        }
    }
}

impl Drop for InMemory {
    fn drop(&mut self) {
        KEPT.write().unwrap_or_else(PoisonError::into_inner).remove(&self.path);
    }
}

fn kept(path: &Path) -> Option<Kept> {
    KEPT.read().unwrap_or_else(PoisonError::into_inner).get(path).cloned()
}

/// Tells whether there is something in memory under this name.
pub fn is_in_memory(path: &Path) -> bool {
    kept(path).is_some()
}

/// Tells whether this is the name of a place for a recording.
pub fn is_place(path: &Path) -> bool {
    matches!(kept(path), Some(Kept::Place | Kept::Written(_)))
}

/// Puts a recording into its place.
pub fn put(path: &Path, columns: MemoryColumns) {
    let what = Kept::Written(Arc::new(columns));
    KEPT.write().unwrap_or_else(PoisonError::into_inner).insert(path.to_owned(), what);
}

/// The text under this name.
pub(crate) fn text(path: &Path) -> Option<String> {
    match kept(path)? {
        Kept::Text(text) => Some(text.to_string()),
        _ => None,
    }
}

/// The reader of the table under this name, and the names of its columns.
pub(crate) fn open(path: &Path) -> Option<(Box<dyn ChunkSource>, Vec<String>)> {
    match kept(path)? {
        Kept::Table(table) => {
            let names = table.names();
            Some((Box::new(MemoryReader { table, at: 0, times: Vec::new() }), names))
        }
        _ => None,
    }
}

struct MemoryReader {
    table: Arc<dyn MemoryTable>,
    at: usize,
    /// Columns of text that hold moments.
    times: Vec<usize>,
}

impl ChunkSource for MemoryReader {
    fn metadata(&self) -> Metadata {
        self.table.metadata()
    }

    fn rows(&self) -> Option<u64> {
        Some(self.table.rows() as u64)
    }

    fn holds_text(&mut self, head: &TableHead) -> Result<Vec<bool>, RecordingError> {
        Ok((0..head.names.len()).map(|column| self.table.holds_text(column)).collect())
    }

    fn read_as_time(&mut self, column: usize) {
        self.times.push(column);
    }

    fn skip(&mut self, rows: u64, _head: &TableHead) -> Result<u64, RecordingError> {
        let skipped = (rows as usize).min(self.table.rows() - self.at);
        self.at += skipped;
        Ok(skipped as u64)
    }

    fn next_chunk(&mut self, head: &TableHead) -> Result<Option<Vec<ColumnValues>>, RecordingError> {
        let rows = self.at..self.table.rows().min(self.at + CHUNK);
        if rows.is_empty() {
            return Ok(None);
        }
        self.at = rows.end;
        let values = |&column: &usize| {
            let refuse = |sentence: String| {
                RecordingError::new(&head.path, format!("column `{}` {sentence}", head.names[column]))
            };
            match self.table.values(column, rows.clone()).map_err(|error| refuse(error.to_string()))? {
                ColumnValues::Words(words) if self.times.contains(&column) => {
                    let no_moment = |row| refuse(format!("holds `{}`, which is no moment", words.word(row)));
                    Ok(ColumnValues::Numbers(words.seconds().map_err(no_moment)?))
                }
                values => Ok(values),
            }
        };
        head.selected.iter().map(values).collect::<Result<_, _>>().map(Some)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Recording;

    fn recording(rows: usize) -> MemoryColumns {
        let time_s = (0..rows).map(|row| row as f64 * 0.5).collect();
        let column = |name: &str, values| RecordingColumn { name: name.to_owned(), values };
        let mut event = crate::ColumnWords::default();
        (0..rows).for_each(|row| event.push(if row < 20_000 { "still" } else { "gust" }));
        MemoryColumns {
            metadata: vec![("title".to_owned(), "a table".to_owned())],
            columns: vec![column("time_s", ColumnValues::Numbers(time_s)), column("event", ColumnValues::Words(event))],
        }
    }

    #[test]
    fn a_table_is_read_like_a_file_as_long_as_its_name_is_kept() {
        let whole = recording(CHUNK + 7_000);
        let named = InMemory::table(Arc::new(whole.clone()));
        let read = Recording::read(named.path()).unwrap();
        assert_eq!((&read.columns, &read.metadata), (&whole.columns, &whole.metadata));
        let mut reader = crate::RecordingReader::open(named.path()).unwrap();
        reader.select(&[1]);
        assert_eq!(reader.skip(20_001).unwrap(), 20_001);
        assert_eq!(reader.next_chunk().unwrap().unwrap()[0].values.len(), CHUNK + 7_000 - 20_001);
        let path = named.path().to_owned();
        drop(named);
        let gone = Recording::read(&path).unwrap_err().to_string();
        assert!(gone.ends_with("there is no such file"), "{gone}");
    }

    #[test]
    fn a_text_is_found_in_its_folder_and_a_place_gives_what_was_put_there() {
        let named = InMemory::text(Path::new("heads"), "toml", "a = 1");
        assert_eq!(named.path().parent(), Some(Path::new("heads")));
        assert_eq!(crate::regular::read_text(named.path()).unwrap(), "a = 1");
        let place = InMemory::place();
        assert!(is_place(place.path()) && !is_place(named.path()));
        put(place.path(), recording(3));
        assert_eq!(place.take().unwrap().rows(), 3);
        assert!(InMemory::place().take().is_none());
    }
}
