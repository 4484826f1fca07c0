//! Recordings as Parquet: typed columns in row groups, Snappy-compressed.
//!
//! Times are DOUBLE, temperatures, powers and wind FLOAT, heater bits INT32 marked as unsigned 8
//! bit, quality flags INT32 marked as unsigned 32 bit and null where there is no estimate, event
//! and state UTF-8 in a dictionary, moments INT64 marked as microseconds in UTC. Unit and
//! description of every column are where Arrow keeps them. Reading accepts any flat file of
//! numbers, booleans and text; a null is a missing number (NaN) or an empty text.

mod arrow_schema;
mod read;
mod zstandard;

use std::fs::File;
use std::io;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, TimeUnit, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, FloatType, Int32Type, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{ColumnPath, Type};

use crate::column::{ColumnKind, ColumnValues, Metadata, RowCell, RowSink, length, overlay};

pub(crate) use read::ParquetReader;

/// Rows of a row group: what the writer holds in memory, some megabytes. Fewer make a reader's
/// table of contents grow, which has a line for every group and column.
const GROUP: usize = 65_536;

pub(crate) struct ParquetWriter {
    file: SerializedFileWriter<File>,
    /// The rows that wait for their group, column by column.
    buffers: Vec<(ColumnKind, ColumnValues)>,
    rows: usize,
    groups: u64,
    columns: Vec<(String, ColumnKind)>,
    metadata: Metadata,
}

impl ParquetWriter {
    pub(crate) fn new(file: File, columns: &[(String, ColumnKind)], metadata: &Metadata) -> Result<Self, ParquetError> {
        let mut properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_dictionary_enabled(false)
            .set_created_by(format!("anemo {}", env!("CARGO_PKG_VERSION")))
            .set_key_value_metadata(Some(
                metadata.iter().map(|(key, value)| KeyValue::new(key.clone(), value.clone())).collect(),
            ));
        for (name, kind) in columns {
            if matches!(kind, ColumnKind::Text | ColumnKind::Bit | ColumnKind::Flags) {
                properties = properties.set_column_dictionary_enabled(ColumnPath::new(vec![name.clone()]), true);
            }
        }
        let fields = columns.iter().map(|(name, kind)| field(name, *kind).map(Arc::new)).collect::<Result<_, _>>()?;
        let schema = Type::group_type_builder("recording").with_fields(fields).build()?;
        let file = SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties.build()))?;
        let empty = |kind| (kind, ColumnValues::empty(kind == ColumnKind::Text));
        Ok(Self {
            file,
            buffers: columns.iter().map(|(_, kind)| empty(*kind)).collect(),
            rows: 0,
            groups: 0,
            columns: columns.to_vec(),
            metadata: metadata.clone(),
        })
    }

    fn write_group(&mut self) -> Result<(), ParquetError> {
        if self.rows == 0 {
            return Ok(());
        }
        let mut group = self.file.next_row_group()?;
        for (kind, buffer) in &mut self.buffers {
            let Some(mut column) = group.next_column()? else { break };
            write_column(&mut column, *kind, buffer)?;
            *buffer = ColumnValues::empty(*kind == ColumnKind::Text);
            column.close()?;
        }
        group.close()?;
        (self.rows, self.groups) = (0, self.groups + 1);
        Ok(())
    }
}

impl RowSink for ParquetWriter {
    fn push(&mut self, cells: &mut dyn Iterator<Item = RowCell<'_>>) -> io::Result<()> {
        for ((_, buffer), cell) in self.buffers.iter_mut().zip(cells) {
            buffer.push(cell);
        }
        self.rows += 1;
        if self.rows == GROUP { self.write_group().map_err(io::Error::other) } else { Ok(()) }
    }

    /// A group is written when it is full.
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }

    fn bytes(&self) -> u64 {
        let row: u64 = self.buffers.iter().map(|(kind, _)| kind.bytes()).sum();
        self.file.bytes_written() as u64 + self.rows as u64 * row
    }

    /// The metadata that an instrument adds at the end is short; a column of a group has pages'
    /// heads, statistics and its line in the table of contents, and in the schema its description.
    fn frame_bytes(&self) -> u64 {
        // Once plain, once for Arrow, in base64.
        2 * length(&self.metadata) + 16_384 + 512 * self.buffers.len() as u64 * (self.groups + 2)
    }

    fn finish(mut self: Box<Self>, metadata: &Metadata) -> io::Result<()> {
        self.write_group().map_err(io::Error::other)?;
        overlay(&mut self.metadata, metadata.iter().cloned());
        let arrow = (arrow_schema::KEY.to_owned(), arrow_schema::encoded(&self.columns, &self.metadata));
        for (key, value) in metadata.iter().chain([&arrow]) {
            self.file.append_key_value_metadata(KeyValue::new(key.clone(), value.clone()));
        }
        self.file.close().map(|_| ()).map_err(io::Error::other)
    }
}

fn write_column(
    column: &mut SerializedColumnWriter<'_>,
    kind: ColumnKind,
    values: &ColumnValues,
) -> Result<(), ParquetError> {
    let whole = |numbers: &[f64]| numbers.iter().map(|number| *number as i32).collect::<Vec<_>>();
    match (kind, values) {
        (_, ColumnValues::Words(words)) => {
            // A clone of a text is a counter.
            let known: Vec<ByteArray> = words.dictionary().iter().map(|word| word.as_str().into()).collect();
            let texts: Vec<ByteArray> = words.codes().iter().map(|&code| known[code as usize].clone()).collect();
            column.typed::<ByteArrayType>().write_batch(&texts, None, None)
        }
        (ColumnKind::Bit, ColumnValues::Numbers(bits)) => {
            column.typed::<Int32Type>().write_batch(&whole(bits), None, None)
        }
        (ColumnKind::Flags, ColumnValues::Numbers(numbers)) => {
            let present: Vec<i16> = numbers.iter().map(|number| i16::from(!number.is_nan())).collect();
            let numbers: Vec<f64> = numbers.iter().copied().filter(|number| !number.is_nan()).collect();
            column.typed::<Int32Type>().write_batch(&whole(&numbers), Some(&present), None)
        }
        (ColumnKind::Utc, ColumnValues::Numbers(seconds)) => {
            let microseconds: Vec<i64> = seconds.iter().map(|seconds| (seconds * 1e6).round() as i64).collect();
            column.typed::<Int64Type>().write_batch(&microseconds, None, None)
        }
        (ColumnKind::Wide, ColumnValues::Numbers(numbers)) => {
            column.typed::<DoubleType>().write_batch(numbers, None, None)
        }
        (ColumnKind::Number | ColumnKind::Text, ColumnValues::Numbers(numbers)) => {
            let numbers: Vec<f32> = numbers.iter().map(|number| *number as f32).collect();
            column.typed::<FloatType>().write_batch(&numbers, None, None)
        }
    }
    .map(|_| ())
}

fn field(name: &str, kind: ColumnKind) -> Result<Type, ParquetError> {
    let (physical, logical) = match kind {
        ColumnKind::Wide => (Physical::DOUBLE, None),
        ColumnKind::Utc => (Physical::INT64, Some(LogicalType::timestamp(true, TimeUnit::MICROS))),
        ColumnKind::Number => (Physical::FLOAT, None),
        ColumnKind::Bit => (Physical::INT32, Some(LogicalType::integer(8, false))),
        ColumnKind::Flags => (Physical::INT32, Some(LogicalType::integer(32, false))),
        ColumnKind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
    };
    Type::primitive_type_builder(name, physical)
        .with_repetition(if kind.is_optional() { Repetition::OPTIONAL } else { Repetition::REQUIRED })
        .with_logical_type(logical)
        .build()
}
