//! Writing a recording row by row, in memory that does not grow with its length; and whole tables
//! of numbers.

use std::path::{Path, PathBuf};

use crate::column::{ColumnKind, Metadata, RowCell, RowSink};
use crate::csv::CsvWriter;
use crate::error::RecordingError;
use crate::file_format::FileFormat;
use crate::format1::FORMAT;
use crate::names::TIME;
use crate::row::{RecordingLayout, RecordingRow};
use crate::temporary::Temporary;

/// A file of either format that appears when it is complete.
struct TableWriter {
    path: PathBuf,
    sink: Box<dyn RowSink + Send>,
    // Declared after the sink: the file is closed before it is removed.
    temporary: Temporary,
}

impl TableWriter {
    fn create(path: &Path, columns: &[(String, ColumnKind)], metadata: &Metadata) -> Result<Self, RecordingError> {
        let format = FileFormat::of(path)?;
        let (temporary, file) = Temporary::create(path).map_err(unwritten(path))?;
        let sink: Box<dyn RowSink + Send> = match format {
            #[cfg(feature = "parquet")]
            FileFormat::Parquet => {
                let sink = crate::parquet::ParquetWriter::new(file, columns, metadata);
                Box::new(sink.map_err(std::io::Error::other).map_err(unwritten(path))?)
            }
            FileFormat::Csv => Box::new(CsvWriter::new(file, columns, metadata).map_err(unwritten(path))?),
        };
        Ok(Self { path: path.to_owned(), sink, temporary })
    }

    fn push<'a>(&mut self, mut cells: impl Iterator<Item = RowCell<'a>>) -> Result<(), RecordingError> {
        self.sink.push(&mut cells).map_err(unwritten(&self.path))
    }

    fn finish(self, metadata: &Metadata) -> Result<(), RecordingError> {
        self.sink.finish(metadata).and_then(|()| self.temporary.keep()).map_err(unwritten(&self.path))
    }
}

/// Makes the error for a file that the system does not let be written.
fn unwritten(path: &Path) -> impl Fn(std::io::Error) -> RecordingError {
    move |error| RecordingError::io(path, "written", error)
}

/// A recording that is being written. Dropped before [`RecordingWriter::finish`], it leaves no
/// file.
pub struct RecordingWriter {
    layout: RecordingLayout,
    table: TableWriter,
}

impl RecordingWriter {
    /// Starts a recording with the metadata that are known at its start; the format is added.
    ///
    /// # Errors
    /// If the file cannot be made, or two elements would share a column.
    pub fn create(path: &Path, layout: RecordingLayout, metadata: &Metadata) -> Result<Self, RecordingError> {
        FileFormat::of(path)?;
        layout.check_elements(path)?;
        let table = TableWriter::create(path, &layout.columns(), &with_format(metadata))?;
        Ok(Self { layout, table })
    }

    /// What the rows consist of.
    pub fn layout(&self) -> &RecordingLayout {
        &self.layout
    }

    /// Writes a row.
    ///
    /// # Errors
    /// If it does not fit the layout, or the file cannot be written.
    pub fn push(&mut self, row: &RecordingRow) -> Result<(), RecordingError> {
        self.layout.check(row)?;
        self.table.push(row.cells())
    }

    /// Completes the file with what is known at the end (losses, hash …) and gives it its name.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(self, metadata: &Metadata) -> Result<(), RecordingError> {
        self.table.finish(metadata)
    }
}

/// The metadata of a file in today's format, which may be copied from one of an older.
pub(crate) fn with_format(metadata: &Metadata) -> Metadata {
    let others = metadata.iter().filter(|(key, _)| key != FORMAT.0).cloned();
    std::iter::once((FORMAT.0.to_owned(), FORMAT.1.to_owned())).chain(others).collect()
}

/// Writes a whole table that no instrument made: `time_s` and named columns in f64. Row n is at n
/// times the sample period. There are as many rows as the shortest column has.
///
/// # Errors
/// If the file cannot be written.
pub fn write_columns(
    path: &Path,
    sample_period_s: f64,
    columns: &[(&str, &[f64])],
    metadata: &Metadata,
) -> Result<(), RecordingError> {
    let names = std::iter::once(TIME).chain(columns.iter().map(|(name, _)| *name));
    let named: Vec<(String, ColumnKind)> = names.map(|name| (name.to_owned(), ColumnKind::Wide)).collect();
    let mut table = TableWriter::create(path, &named, metadata)?;
    for n in 0..columns.iter().map(|(_, values)| values.len()).min().unwrap_or(0) {
        let values = columns.iter().map(|(_, values)| values[n]);
        table.push(std::iter::once(n as f64 * sample_period_s).chain(values).map(RowCell::Number))?;
    }
    table.finish(&Metadata::new())
}

#[cfg(all(test, feature = "parquet"))]
mod tests {
    use super::*;
    use crate::column::ColumnValues;
    use crate::recording::Recording;

    #[test]
    fn either_format_gives_the_same_numbers_back() {
        let folder = tempfile::tempdir().unwrap();
        let (u, y) = ([0.0, 1.0, 1.0], [0.1, 1.0 / 3.0, -2e-9]);
        for name in ["record.csv", "record.parquet"] {
            let path = folder.path().join(name);
            let metadata = vec![("title".to_owned(), "a test".to_owned())];
            write_columns(&path, 5e-4, &[("u", &u), ("y", &y)], &metadata).unwrap();
            let read = Recording::read(&path).unwrap();
            let columns: Vec<(&str, &ColumnValues)> =
                read.columns.iter().map(|c| (c.name.as_str(), &c.values)).collect();
            let numbers = |values: &[f64]| ColumnValues::Numbers(values.to_vec());
            let expected = [numbers(&[0.0, 5e-4, 1e-3]), numbers(&u), numbers(&y)];
            assert_eq!(columns.iter().map(|(name, _)| *name).collect::<Vec<_>>(), ["time_s", "u", "y"], "{name}");
            assert!(columns.iter().zip(&expected).all(|((_, values), expected)| *values == expected), "{name}");
            assert_eq!(read.metadata, metadata, "{name}");
        }
        let error = write_columns(&folder.path().join("record.txt"), 1.0, &[("u", &u)], &Vec::new()).unwrap_err();
        assert!(error.to_string().contains(".parquet or .csv"), "{error}");
    }
}
