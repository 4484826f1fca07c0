//! Reading any flat Parquet file of numbers, booleans and text, in pieces whatever the size of its
//! row groups.
//!
//! A null is a missing number (NaN) or an empty text; a timestamp is its seconds.

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, TimeUnit, Type as Physical};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{ByteArrayType, DataType};
use parquet::errors::ParquetError;
use parquet::file::metadata::ParquetStatisticsPolicy;
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::file::serialized_reader::{ReadOptions, ReadOptionsBuilder};

use super::zstandard;
use crate::column::{CHUNK, ChunkSource, ColumnValues, ColumnWords, Metadata, TableHead};
use crate::error::RecordingError;

pub(crate) struct ParquetReader {
    file: SerializedFileReader<File>,
    /// The same for columns of Zstandard.
    disk: Arc<File>,
    /// The next row group to open.
    group: usize,
    open: RowGroup,
    /// Columns of text that hold moments.
    times: Vec<usize>,
}

/// A row group that is being read.
#[derive(Default)]
struct RowGroup {
    columns: Vec<ColumnReader>,
    rows_left: u64,
}

impl ParquetReader {
    /// The reader, and the names of the columns.
    pub(crate) fn open(file: File, path: &Path) -> Result<(Box<dyn ChunkSource>, Vec<String>), RecordingError> {
        let damaged = |reason: &dyn std::fmt::Display| RecordingError::damaged(path, reason);
        let length = file.metadata().map_err(|error| RecordingError::io(path, "read", error))?.len() as i64;
        let disk = Arc::new(file.try_clone().map_err(|error| RecordingError::io(path, "read", error))?);
        let file = without_panic(move || SerializedFileReader::new_with_options(file, frugal()))
            .map_err(|error| damaged(&error))?;
        let schema = file.metadata().file_metadata().schema_descr();
        let mut names = Vec::new();
        for column in schema.columns() {
            let name = column.path().string();
            if column.max_rep_level() > 0 || column.path().parts().len() > 1 {
                let sentence = format!("column `{name}` is nested: a recording is a flat table");
                return Err(RecordingError::new(path, sentence));
            }
            names.push(column.name().to_owned());
        }
        let groups = file.metadata().row_groups();
        if let Some(codec) =
            groups.iter().flat_map(|group| group.columns()).find_map(|column| unread(column.compression()))
        {
            let sentence = format!(
                "is compressed by {codec}, which is not read here: write it with Zstandard, Snappy, gzip, LZ4 or none (compression=\"snappy\" in pandas and Polars)"
            );
            return Err(RecordingError::new(path, sentence));
        }
        // The library asserts this where it reads, which would be a panic.
        for column in groups.iter().flat_map(|group| group.columns()) {
            let offsets =
                [Some(column.data_page_offset()), column.dictionary_page_offset(), Some(column.compressed_size())];
            if column.num_values() < 0 || offsets.into_iter().flatten().any(|bytes| !(0..=length).contains(&bytes)) {
                return Err(damaged(&"its table of contents points outside of the file"));
            }
        }
        if groups.iter().any(|group| group.num_rows() < 0) {
            return Err(damaged(&"its table of contents tells of fewer than no rows"));
        }
        Ok((Box::new(Self { file, disk, group: 0, open: RowGroup::default(), times: Vec::new() }), names))
    }

    fn open_group(&mut self, selected: &[usize]) -> Result<(), ParquetError> {
        let group = self.file.get_row_group(self.group)?;
        self.group += 1;
        self.open.rows_left = group.metadata().num_rows().unsigned_abs();
        let column = |&index: &usize| {
            without_panic(|| {
                let (metadata, rows) = (group.metadata(), self.open.rows_left as usize);
                let packed = zstandard::column_reader(&self.disk, metadata.column(index), rows)?;
                packed.map_or_else(|| group.get_column_reader(index), Ok)
            })
        };
        self.open.columns = selected.iter().map(column).collect::<Result<_, _>>()?;
        Ok(())
    }
}

/// The name of a compression that hardly anybody uses, or whose library has its own tables of
/// some 100 KB.
const fn unread(compression: Compression) -> Option<&'static str> {
    match compression {
        Compression::UNCOMPRESSED
        | Compression::SNAPPY
        | Compression::GZIP(_)
        | Compression::LZ4
        | Compression::LZ4_RAW
        | Compression::ZSTD(_) => None,
        Compression::BROTLI(_) => Some("Brotli"),
        Compression::LZO => Some("LZO"),
    }
}

impl ChunkSource for ParquetReader {
    fn metadata(&self) -> Metadata {
        let pairs = self.file.metadata().file_metadata().key_value_metadata();
        let pairs = pairs.into_iter().flatten().filter(|pair| pair.key != super::arrow_schema::KEY);
        pairs.map(|pair| (pair.key.clone(), pair.value.clone().unwrap_or_default())).collect()
    }

    fn rows(&self) -> Option<u64> {
        let groups = self.file.metadata().row_groups();
        Some(groups.iter().fold(0, |rows, group| rows.saturating_add(group.num_rows().unsigned_abs())))
    }

    fn holds_text(&mut self, _head: &TableHead) -> Result<Vec<bool>, RecordingError> {
        let schema = self.file.metadata().file_metadata().schema_descr();
        Ok(schema.columns().iter().map(|column| column.physical_type() == Physical::BYTE_ARRAY).collect())
    }

    /// Columns have their types.
    fn read_as_text(&mut self, _column: usize) {}

    fn read_as_time(&mut self, column: usize) {
        self.times.push(column);
    }

    /// Passes over rows before the first chunk, whole row groups and pages at a time.
    fn skip(&mut self, rows: u64, head: &TableHead) -> Result<u64, RecordingError> {
        let mut left = rows;
        while left > 0 && self.group < self.file.num_row_groups() {
            let here = self.file.metadata().row_group(self.group).num_rows().unsigned_abs();
            if here <= left {
                self.group += 1;
                left -= here;
                continue;
            }
            self.open_group(&head.selected).map_err(|error| head.damaged(error))?;
            for column in &mut self.open.columns {
                let skipped = without_panic(|| skip_records(column, left as usize));
                let skipped = skipped.map_err(|error| head.damaged(error))?;
                if skipped as u64 != left {
                    return Err(head.damaged(format!("{skipped} of {here} rows are there")));
                }
            }
            self.open.rows_left -= left;
            left = 0;
        }
        Ok(rows - left)
    }

    fn next_chunk(&mut self, head: &TableHead) -> Result<Option<Vec<ColumnValues>>, RecordingError> {
        while self.open.rows_left == 0 {
            if self.group == self.file.num_row_groups() {
                return Ok(None);
            }
            self.open_group(&head.selected).map_err(|error| head.damaged(error))?;
        }
        let rows = self.open.rows_left.min(CHUNK as u64) as usize;
        self.open.rows_left -= rows as u64;
        let mut columns = Vec::with_capacity(head.selected.len());
        for (column, &index) in self.open.columns.iter_mut().zip(&head.selected) {
            let scale = seconds(self.file.metadata().file_metadata().schema_descr().column(index).logical_type_ref());
            let values = without_panic(|| {
                Ok(Some(match column {
                    ColumnReader::DoubleColumnReader(column) => numbers(column, rows, |value| value)?,
                    ColumnReader::FloatColumnReader(column) => numbers(column, rows, f64::from)?,
                    ColumnReader::Int32ColumnReader(column) => numbers(column, rows, f64::from)?,
                    ColumnReader::Int64ColumnReader(column) => numbers(column, rows, |value| value as f64 * scale)?,
                    ColumnReader::BoolColumnReader(column) => numbers(column, rows, |value| u8::from(value).into())?,
                    ColumnReader::ByteArrayColumnReader(column) => words(column, rows)?,
                    _ => return Ok(None),
                }))
            });
            let name = &head.names[index];
            let refuse = |sentence: String| RecordingError::new(&head.path, sentence);
            let values = values
                .map_err(|error| head.damaged(error))?
                .ok_or_else(|| refuse(format!("column `{name}` is of a type that is neither number nor text")))?;
            columns.push(match values {
                ColumnValues::Words(words) if self.times.contains(&index) => {
                    let no_moment = |row| refuse(format!("column `{name}`: `{}` is no moment", words.word(row)));
                    ColumnValues::Numbers(words.seconds().map_err(no_moment)?)
                }
                values => values,
            });
        }
        Ok(Some(columns))
    }
}

/// Leaves the statistics of every row group and column where they are: nobody asks for them, and in
/// a long file they take more memory than the rows in work.
fn frugal() -> ReadOptions {
    ReadOptionsBuilder::new()
        .with_column_stats_policy(ParquetStatisticsPolicy::SkipAll)
        .with_size_stats_policy(ParquetStatisticsPolicy::SkipAll)
        .with_encoding_stats_policy(ParquetStatisticsPolicy::SkipAll)
        .build()
}

/// Seconds in the unit of a timestamp, 1 for anything else.
fn seconds(logical: Option<&LogicalType>) -> f64 {
    match logical {
        Some(LogicalType::Timestamp(stamp)) => match stamp.unit {
            TimeUnit::MILLIS => 1e-3,
            TimeUnit::MICROS => 1e-6,
            TimeUnit::NANOS => 1e-9,
        },
        _ => 1.0,
    }
}

/// The next rows of a column; `None` for a null.
fn read_records<T: DataType>(
    column: &mut ColumnReaderImpl<T>,
    rows: usize,
) -> Result<impl Iterator<Item = Option<T::T>>, ParquetError> {
    let (mut values, mut levels) = (Vec::with_capacity(rows), Vec::new());
    let mut read = 0;
    while read < rows {
        let (records, _, _) = column.read_records(rows - read, Some(&mut levels), None, &mut values)?;
        if records == 0 {
            return Err(ParquetError::EOF(format!("{} rows are missing", rows - read)));
        }
        read += records;
    }
    let is_whole = values.len() == rows;
    let mut values = values.into_iter();
    Ok((0..rows)
        .map(move |row| if is_whole || levels.get(row).is_some_and(|level| *level > 0) { values.next() } else { None }))
}

fn numbers<T: DataType>(
    column: &mut ColumnReaderImpl<T>,
    rows: usize,
    convert: impl Fn(T::T) -> f64,
) -> Result<ColumnValues, ParquetError> {
    let records = read_records(column, rows)?;
    Ok(ColumnValues::Numbers(records.map(|value| value.map_or(f64::NAN, &convert)).collect()))
}

fn words(column: &mut ColumnReaderImpl<ByteArrayType>, rows: usize) -> Result<ColumnValues, ParquetError> {
    let mut words = ColumnWords::default();
    for value in read_records(column, rows)? {
        match &value {
            Some(value) => words.push(value.as_utf8()?),
            None => words.push(""),
        }
    }
    Ok(ColumnValues::Words(words))
}

fn skip_records(column: &mut ColumnReader, rows: usize) -> Result<usize, ParquetError> {
    match column {
        ColumnReader::DoubleColumnReader(column) => column.skip_records(rows),
        ColumnReader::FloatColumnReader(column) => column.skip_records(rows),
        ColumnReader::Int32ColumnReader(column) => column.skip_records(rows),
        ColumnReader::Int64ColumnReader(column) => column.skip_records(rows),
        ColumnReader::Int96ColumnReader(column) => column.skip_records(rows),
        ColumnReader::BoolColumnReader(column) => column.skip_records(rows),
        ColumnReader::ByteArrayColumnReader(column) => column.skip_records(rows),
        ColumnReader::FixedLenByteArrayColumnReader(column) => column.skip_records(rows),
    }
}

thread_local! {
    static IS_GUARDED: std::cell::Cell<bool> = const { std::cell::Cell::new(false) };
}

/// Makes an error of a panic inside the library, which asserts in places what a damaged file does
/// not keep to.
fn without_panic<T>(read: impl FnOnce() -> Result<T, ParquetError>) -> Result<T, ParquetError> {
    static QUIET: std::sync::Once = std::sync::Once::new();
    QUIET.call_once(|| {
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            if !IS_GUARDED.get() {
                before(panic);
            }
        }));
    });
    IS_GUARDED.set(true);
    let outcome = std::panic::catch_unwind(std::panic::AssertUnwindSafe(read));
    IS_GUARDED.set(false);
    outcome.unwrap_or_else(|_| Err(ParquetError::General("its parts contradict each other".to_owned())))
}
