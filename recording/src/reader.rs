//! Reading a recording in chunks.

use std::path::Path;

use crate::column::{ChunkSource, Metadata, RecordingColumn, TableHead};
use crate::csv::CsvReader;
use crate::error::RecordingError;
use crate::file_format::FileFormat;
use crate::format1::rename_columns;
use crate::names::duplicate;
use crate::regular;

/// A recording that is read chunk by chunk, in memory that does not grow with its length.
pub struct RecordingReader {
    head: TableHead,
    source: Box<dyn ChunkSource>,
}

impl RecordingReader {
    /// Opens a file. Columns of format 1 get their names of today.
    ///
    /// # Errors
    /// If there is no such file, its extension is not known, or it is no table with named columns.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        let format = FileFormat::of(path)?;
        let file = regular::open(path).map_err(|error| match error.kind() {
            std::io::ErrorKind::NotFound => RecordingError::new(path, "there is no such file"),
            _ => RecordingError::io(path, "read", error),
        })?;
        let (source, mut names) = match format {
            #[cfg(feature = "parquet")]
            FileFormat::Parquet => crate::parquet::ParquetReader::open(file, path)?,
            FileFormat::Csv => CsvReader::open(file, path)?,
        };
        rename_columns(&mut names, &source.metadata());
        if let Some(name) = duplicate(names.iter().map(String::as_str)) {
            return Err(RecordingError::new(path, format!("two columns are named `{name}`: rename one of them")));
        }
        let selected = (0..names.len()).collect();
        Ok(Self { head: TableHead { path: path.to_owned(), names, selected }, source })
    }

    /// Names of the columns, in the file's order.
    pub fn names(&self) -> &[String] {
        &self.head.names
    }

    /// What the file says of itself. A CSV file may say more below its last row: complete after the
    /// last chunk.
    pub fn metadata(&self) -> Metadata {
        self.source.metadata()
    }

    /// Number of rows, where the file states it, as a Parquet file does.
    pub fn rows(&self) -> Option<u64> {
        self.source.rows()
    }

    /// Whether each column holds text: by its type, or by its first row in a CSV file.
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
        self.source.read_as_text(column);
    }

    /// Passes over rows before the first chunk; returns how many there were.
    pub fn skip(&mut self, rows: u64) -> Result<u64, RecordingError> {
        self.source.skip(rows, &self.head)
    }

    /// The next rows of the selected columns, [`CHUNK`](crate::CHUNK) of them at most; `None` after
    /// the last.
    pub fn next_chunk(&mut self) -> Result<Option<Vec<RecordingColumn>>, RecordingError> {
        let head = &self.head;
        let named = |(&at, values): (&usize, _)| RecordingColumn { name: head.names[at].clone(), values };
        let chunk = self.source.next_chunk(head)?;
        Ok(chunk.map(|columns| head.selected.iter().zip(columns).map(named).collect()))
    }
}
