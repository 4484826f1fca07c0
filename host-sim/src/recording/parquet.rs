//! Recordings as Parquet: typed columns in row groups, Snappy-compressed, every value present.
//!
//! Times are DOUBLE, temperatures, powers and wind FLOAT, heater bits INT32 marked as unsigned 8 bit, event and state UTF-8 in a
//! dictionary. Reading accepts any flat file of numbers, booleans and text; a null is a missing number (NaN) or an empty text.

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, FloatType, Int32Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{ColumnPath, Type};

use super::read::{Column, Values, Words};
use super::write::{Kind, Row};
use super::{Metadata, RecordingError};

/// Rows of a row group: what the writer holds in memory, some megabytes.
const GROUP: usize = 16_384;

enum Buffer {
    Times(Vec<f64>),
    Numbers(Vec<f32>),
    Bits(Vec<i32>),
    Text(Vec<ByteArray>),
}

pub(super) struct Writer {
    file: SerializedFileWriter<File>,
    buffers: Vec<Buffer>,
    rows: usize,
    /// The texts in use: they repeat for thousands of rows, and a clone is a counter.
    texts: Vec<ByteArray>,
}

impl Writer {
    pub(super) fn new(
        file: File,
        columns: &[(String, Kind)],
        metadata: &Metadata,
        path: &Path,
    ) -> Result<Self, RecordingError> {
        let failed = |error: ParquetError| RecordingError::io(path, "written", &error);
        let mut properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_dictionary_enabled(false)
            .set_created_by(format!("anemo {}", env!("CARGO_PKG_VERSION")))
            .set_key_value_metadata(Some(
                metadata.iter().map(|(key, value)| KeyValue::new(key.clone(), value.clone())).collect(),
            ));
        for (name, kind) in columns {
            if matches!(kind, Kind::Text | Kind::Bit) {
                properties = properties.set_column_dictionary_enabled(ColumnPath::new(vec![name.clone()]), true);
            }
        }
        let schema = columns
            .iter()
            .map(|(name, kind)| field(name, *kind).map(Arc::new))
            .collect::<Result<_, _>>()
            .map_err(failed)?;
        let schema = Type::group_type_builder("recording").with_fields(schema).build().map_err(failed)?;
        let file = SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties.build())).map_err(failed)?;
        let buffers = columns
            .iter()
            .map(|(_, kind)| match kind {
                Kind::Time => Buffer::Times(Vec::with_capacity(GROUP)),
                Kind::Number => Buffer::Numbers(Vec::with_capacity(GROUP)),
                Kind::Bit => Buffer::Bits(Vec::with_capacity(GROUP)),
                Kind::Text => Buffer::Text(Vec::with_capacity(GROUP)),
            })
            .collect();
        Ok(Self { file, buffers, rows: 0, texts: Vec::new() })
    }

    pub(super) fn push(&mut self, row: &Row, path: &Path) -> Result<(), RecordingError> {
        let wind = row.wind_m_s.map(|wind| wind.map(|component| component as f32));
        let mut numbers = row.temperature_c.iter().chain(row.power_w).copied().chain(wind.into_iter().flatten());
        let mut heaters = row.heaters;
        let mut texts = [self.text(row.event), self.text(row.state)].into_iter();
        // The buffers stand in the order of the columns, in which each kind keeps the order of the row.
        for buffer in &mut self.buffers {
            match buffer {
                Buffer::Times(times) => times.push(row.time_s),
                Buffer::Numbers(values) => values.extend(numbers.next()),
                Buffer::Bits(bits) => {
                    bits.push(i32::from(heaters & 1));
                    heaters >>= 1;
                }
                Buffer::Text(values) => values.extend(texts.next()),
            }
        }
        self.rows += 1;
        if self.rows == GROUP {
            self.flush().map_err(|error| RecordingError::io(path, "written", &error))?;
        }
        Ok(())
    }

    fn text(&mut self, text: &str) -> ByteArray {
        if let Some(known) = self.texts.iter().find(|known| known.data() == text.as_bytes()) {
            return known.clone();
        }
        // Labels are few; a stream of ever new ones must not pile up.
        if self.texts.len() == 64 {
            self.texts.clear();
        }
        self.texts.push(ByteArray::from(text));
        ByteArray::from(text)
    }

    fn flush(&mut self) -> Result<(), ParquetError> {
        if self.rows == 0 {
            return Ok(());
        }
        let mut group = self.file.next_row_group()?;
        for buffer in &mut self.buffers {
            let Some(mut column) = group.next_column()? else { break };
            match buffer {
                Buffer::Times(values) => write_all::<DoubleType>(&mut column, values)?,
                Buffer::Numbers(values) => write_all::<FloatType>(&mut column, values)?,
                Buffer::Bits(values) => write_all::<Int32Type>(&mut column, values)?,
                Buffer::Text(values) => write_all::<ByteArrayType>(&mut column, values)?,
            }
            column.close()?;
        }
        group.close()?;
        self.rows = 0;
        Ok(())
    }

    pub(super) fn finish(mut self, metadata: &Metadata, path: &Path) -> Result<(), RecordingError> {
        let failed = |error: ParquetError| RecordingError::io(path, "written", &error);
        self.flush().map_err(failed)?;
        for (key, value) in metadata {
            self.file.append_key_value_metadata(KeyValue::new(key.clone(), value.clone()));
        }
        self.file.close().map(|_| ()).map_err(failed)
    }
}

fn write_all<T: DataType>(
    column: &mut parquet::file::writer::SerializedColumnWriter<'_>,
    values: &mut Vec<T::T>,
) -> Result<(), ParquetError> {
    column.typed::<T>().write_batch(values, None, None)?;
    values.clear();
    Ok(())
}

fn field(name: &str, kind: Kind) -> Result<Type, ParquetError> {
    let (physical, logical) = match kind {
        Kind::Time => (Physical::DOUBLE, None),
        Kind::Number => (Physical::FLOAT, None),
        Kind::Bit => (Physical::INT32, Some(LogicalType::integer(8, false))),
        Kind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
    };
    Type::primitive_type_builder(name, physical)
        .with_repetition(Repetition::REQUIRED)
        .with_logical_type(logical)
        .build()
}

pub(super) struct Reader {
    file: SerializedFileReader<File>,
    names: Vec<String>,
    group: usize,
}

impl Reader {
    pub(super) fn open(file: File, path: &Path) -> Result<Self, RecordingError> {
        let length = file.metadata().map_err(|error| RecordingError::io(path, "read", &error))?.len() as i64;
        let file = without_panic(move || SerializedFileReader::new(file))
            .map_err(|error| RecordingError::damaged(path, &error))?;
        let schema = file.metadata().file_metadata().schema_descr();
        let mut names = Vec::new();
        for column in schema.columns() {
            let name = column.path().string();
            if column.max_rep_level() > 0 || column.path().parts().len() > 1 {
                return Err(RecordingError::content(
                    path,
                    format!("column `{name}` is nested: a recording is a flat table"),
                ));
            }
            names.push(column.name().to_owned());
        }
        // The library asserts this where it reads, which would be a panic.
        for column in file.metadata().row_groups().iter().flat_map(|group| group.columns()) {
            let offsets =
                [Some(column.data_page_offset()), column.dictionary_page_offset(), Some(column.compressed_size())];
            if column.num_values() < 0 || offsets.into_iter().flatten().any(|bytes| !(0..=length).contains(&bytes)) {
                return Err(RecordingError::damaged(path, &"its table of contents points outside of the file"));
            }
        }
        Ok(Self { file, names, group: 0 })
    }

    pub(super) fn names(&self) -> &[String] {
        &self.names
    }

    pub(super) fn metadata(&self) -> Metadata {
        let pairs = self.file.metadata().file_metadata().key_value_metadata();
        pairs.into_iter().flatten().map(|pair| (pair.key.clone(), pair.value.clone().unwrap_or_default())).collect()
    }

    pub(super) fn next_chunk(&mut self, path: &Path) -> Result<Option<Vec<Column>>, RecordingError> {
        if self.group == self.file.num_row_groups() {
            return Ok(None);
        }
        let damaged = |error: ParquetError| RecordingError::damaged(path, &error);
        let group = self.file.get_row_group(self.group).map_err(damaged)?;
        self.group += 1;
        let rows =
            usize::try_from(group.metadata().num_rows()).map_err(|error| RecordingError::damaged(path, &error))?;
        let mut columns = Vec::with_capacity(self.names.len());
        for (index, name) in self.names.iter().enumerate() {
            let column = || group.get_column_reader(index);
            let values = match without_panic(column).map_err(damaged)? {
                ColumnReader::DoubleColumnReader(column) => numbers(column, rows, |value| value),
                ColumnReader::FloatColumnReader(column) => numbers(column, rows, f64::from),
                ColumnReader::Int32ColumnReader(column) => numbers(column, rows, f64::from),
                ColumnReader::Int64ColumnReader(column) => numbers(column, rows, |value| value as f64),
                ColumnReader::BoolColumnReader(column) => numbers(column, rows, |value| f64::from(u8::from(value))),
                ColumnReader::ByteArrayColumnReader(column) => words(column, rows),
                _ => {
                    let sentence = format!("column `{name}` is of a type that is neither number nor text");
                    return Err(RecordingError::content(path, sentence));
                }
            };
            columns.push(Column { name: name.clone(), values: values.map_err(damaged)? });
        }
        Ok(Some(columns))
    }
}

/// All values of a column of one row group, `None` where it is null.
fn read_all<T: DataType>(mut column: ColumnReaderImpl<T>, rows: usize) -> Result<Vec<Option<T::T>>, ParquetError> {
    without_panic(move || read_records(&mut column, rows))
}

fn read_records<T: DataType>(column: &mut ColumnReaderImpl<T>, rows: usize) -> Result<Vec<Option<T::T>>, ParquetError> {
    // The number of rows is the file's word for it, so it reserves no more than a sane group would need.
    let sane = rows.min(1 << 20);
    let (mut values, mut levels) = (Vec::with_capacity(sane), Vec::with_capacity(sane));
    let mut read = 0;
    while read < rows {
        let (records, _, _) = column.read_records(rows - read, Some(&mut levels), None, &mut values)?;
        if records == 0 {
            return Err(ParquetError::EOF(format!("{read} of {rows} rows are there")));
        }
        read += records;
    }
    if levels.is_empty() {
        return Ok(values.into_iter().map(Some).collect());
    }
    let mut values = values.into_iter();
    Ok(levels.iter().map(|&level| if level > 0 { values.next() } else { None }).collect())
}

fn numbers<T: DataType>(
    column: ColumnReaderImpl<T>,
    rows: usize,
    convert: fn(T::T) -> f64,
) -> Result<Values, ParquetError> {
    Ok(Values::Numbers(read_all(column, rows)?.into_iter().map(|value| value.map_or(f64::NAN, convert)).collect()))
}

fn words(column: ColumnReaderImpl<ByteArrayType>, rows: usize) -> Result<Values, ParquetError> {
    let mut words = Words::default();
    for value in read_all(column, rows)? {
        match value {
            Some(value) => words.push(value.as_utf8()?),
            None => words.push(""),
        }
    }
    Ok(Values::Words(words))
}

thread_local! {
    static IS_GUARDED: std::cell::Cell<bool> = const { std::cell::Cell::new(false) };
}

/// Makes an error of a panic inside the library, which asserts in places what a damaged file does not keep to.
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
