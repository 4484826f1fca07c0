//! Recordings as Parquet: typed columns in row groups, Snappy-compressed, every value present.
//!
//! Times are DOUBLE, temperatures, powers and wind FLOAT, heater bits INT32 marked as unsigned 8 bit, event and state UTF-8 in a
//! dictionary. Reading accepts any flat file of numbers, booleans and text; a null is a missing number (NaN) or an empty text.

mod read;

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, FloatType, Int32Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{ColumnPath, Type};

use super::write::{Kind, Row};
use super::{Metadata, RecordingError};

pub(super) use read::Reader;

/// Rows of a row group: what the writer holds in memory, some megabytes. Fewer make a reader's table of contents grow, which has a
/// line for every group and column.
const GROUP: usize = 65_536;

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
        let readings = row.temperature_c.iter().chain(row.power_w).chain(row.equivalent_power_w);
        let mut numbers = readings.copied().chain(row.conditions().map(|number| number as f32));
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
