//! A file of either format that appears when it is complete.

use std::path::{Path, PathBuf};

use crate::clock_fit::ClockFit;
use crate::column::{ColumnKind, Metadata, RowCell, RowSink};
use crate::csv::CsvWriter;
use crate::error::RecordingError;
use crate::file_format::{FileFormat, check_name};
use crate::temporary::Temporary;

pub(super) struct TableWriter {
    path: PathBuf,
    sink: Box<dyn RowSink + Send>,
    // Declared after the sink: the file is closed before it is removed.
    temporary: Temporary,
    /// Of a table with times and moments.
    clock: Option<ClockFit>,
}

impl TableWriter {
    pub fn create(path: &Path, columns: &[(String, ColumnKind)], metadata: &Metadata) -> Result<Self, RecordingError> {
        check_name(path)?;
        let format = FileFormat::of(path)?;
        let (temporary, file) = Temporary::create(path).map_err(unwritten(path))?;
        let sink: Box<dyn RowSink + Send> = match format {
            #[cfg(feature = "parquet")]
            FileFormat::Parquet => {
                let sink = crate::parquet::ParquetWriter::new(file, columns, metadata);
                Box::new(sink.map_err(std::io::Error::other).map_err(unwritten(path))?)
            }
            FileFormat::Csv | FileFormat::Journal => {
                Box::new(CsvWriter::new(file, columns, metadata).map_err(unwritten(path))?)
            }
        };
        let has_moments = columns.get(1).is_some_and(|(_, kind)| *kind == ColumnKind::Utc);
        Ok(Self { path: path.to_owned(), sink, temporary, clock: has_moments.then(ClockFit::default) })
    }

    pub fn push(&mut self, cells: &mut dyn Iterator<Item = RowCell<'_>>) -> Result<(), RecordingError> {
        let Some(clock) = &mut self.clock else { return self.sink.push(cells).map_err(unwritten(&self.path)) };
        let mut stamp = [f64::NAN; 2];
        let mut look = |(at, cell): (usize, RowCell<'_>)| {
            if let (Some(seen), RowCell::Number(number)) = (stamp.get_mut(at), cell) {
                *seen = number;
            }
        };
        self.sink
            .push(&mut cells.enumerate().inspect(|cell| look(*cell)).map(|(_, cell)| cell))
            .map_err(unwritten(&self.path))?;
        clock.add(stamp[0], stamp[1]);
        Ok(())
    }

    /// Length of the file if it ended here, at most.
    pub fn bytes(&self) -> u64 {
        self.sink.bytes()
    }

    pub fn finish(self, metadata: &Metadata) -> Result<(), RecordingError> {
        let clock = self.clock.map(|clock| clock.metadata()).unwrap_or_default();
        let metadata: Metadata = metadata.iter().cloned().chain(clock).collect();
        self.sink.finish(&metadata).and_then(|()| self.temporary.keep()).map_err(unwritten(&self.path))
    }
}

/// Makes the error for a file that the system does not let be written.
pub(super) fn unwritten(path: &Path) -> impl Fn(std::io::Error) -> RecordingError {
    move |error| RecordingError::io(path, "written", error)
}
