//! A file of either format that appears when it is complete.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use crate::clock_fit::ClockFit;
use crate::column::{ColumnKind, Metadata, RowCell, RowSink};
use crate::csv::CsvWriter;
use crate::error::RecordingError;
use crate::file_format::{FileFormat, check_name};
use crate::temporary::Temporary;

/// Room is reserved in steps of so many bytes.
const STEP: u64 = 64 << 10;

pub(super) struct TableWriter {
    path: PathBuf,
    file: File,
    /// Bytes that the disk keeps for the file.
    reserved: u64,
    has_rows: bool,
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
        let own = file.try_clone().map_err(unwritten(path))?;
        let sink: Box<dyn RowSink + Send> = match format {
            #[cfg(feature = "parquet")]
            FileFormat::Parquet => {
                let sink = crate::parquet::ParquetWriter::new(file, columns, metadata);
                Box::new(sink.map_err(io::Error::other).map_err(unwritten(path))?)
            }
            FileFormat::Csv | FileFormat::Journal => {
                Box::new(CsvWriter::new(file, columns, metadata).map_err(unwritten(path))?)
            }
        };
        let has_moments = columns.get(1).is_some_and(|(_, kind)| *kind == ColumnKind::Utc);
        Ok(Self {
            path: path.to_owned(),
            file: own,
            reserved: 0,
            has_rows: false,
            sink,
            temporary,
            clock: has_moments.then(ClockFit::default),
        })
    }

    pub fn has_rows(&self) -> bool {
        self.has_rows
    }

    pub fn push(&mut self, cells: &mut dyn Iterator<Item = RowCell<'_>>) -> Result<(), RecordingError> {
        self.has_rows = true;
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

    /// Has the disk keep room for one more row and for the end of the file, so that it can always
    /// be closed.
    pub fn reserve(&mut self) -> Result<(), RecordingError> {
        let wanted = self.sink.bytes() + self.sink.frame_bytes() + STEP / 4;
        if wanted > self.reserved {
            let length = wanted.next_multiple_of(STEP);
            allocate(&self.file, length).map_err(unwritten(&self.path))?;
            self.reserved = length;
        }
        Ok(())
    }

    /// Length of the rows so far, at most.
    pub fn bytes(&self) -> u64 {
        self.sink.bytes()
    }

    pub fn finish(self, metadata: &Metadata) -> Result<(), RecordingError> {
        let clock = self.clock.map(|clock| clock.metadata()).unwrap_or_default();
        let metadata: Metadata = metadata.iter().cloned().chain(clock).collect();
        let Self { path, file, reserved, sink, temporary, .. } = self;
        let give_back = || if reserved > 0 { file.set_len(file.metadata()?.len()) } else { Ok(()) };
        sink.finish(&metadata).and_then(|()| give_back()).and_then(|()| temporary.keep()).map_err(unwritten(&path))
    }
}

/// Blocks for so many bytes, where the system can: elsewhere the journal has the rows.
#[cfg(target_os = "linux")]
fn allocate(file: &File, length: u64) -> io::Result<()> {
    use rustix::fs::{FallocateFlags, fallocate};
    match fallocate(file, FallocateFlags::KEEP_SIZE, 0, length) {
        Err(rustix::io::Errno::OPNOTSUPP | rustix::io::Errno::NOSYS) => Ok(()),
        outcome => Ok(outcome?),
    }
}

#[cfg(not(target_os = "linux"))]
fn allocate(_: &File, _: u64) -> io::Result<()> {
    Ok(())
}

/// Makes the error for a file that the system does not let be written.
pub(super) fn unwritten(path: &Path) -> impl Fn(io::Error) -> RecordingError {
    move |error| RecordingError::unwritten(path, &error)
}
