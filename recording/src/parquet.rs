//! Recordings as Parquet: typed columns in row groups, Snappy-compressed.
//!
//! Times are DOUBLE, temperatures, powers and wind FLOAT, heater bits INT32 marked as unsigned 8
//! bit, quality flags INT32 marked as unsigned 32 bit and null where there is no estimate, event
//! and state UTF-8 in a dictionary. Reading accepts any flat file of numbers, booleans and text; a
//! null is a missing number (NaN) or an empty text.

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

use crate::column::{ColumnKind, Metadata, RowCell, RowSink};
use crate::error::RecordingError;

pub(crate) use read::ParquetReader;

/// Rows of a row group: what the writer holds in memory, some megabytes. Fewer make a reader's
/// table of contents grow, which has a line for every group and column.
const GROUP: usize = 65_536;

enum ColumnBuffer {
    Wide(Vec<f64>),
    Numbers(Vec<f32>),
    Bits(Vec<i32>),
    /// The flags that are there, and for each row whether they are.
    Flags(Vec<i32>, Vec<i16>),
    Text(Vec<ByteArray>),
}

pub(crate) struct ParquetWriter {
    file: SerializedFileWriter<File>,
    buffers: Vec<ColumnBuffer>,
    rows: usize,
    /// The texts in use: they repeat for thousands of rows, and a clone is a counter.
    texts: Vec<ByteArray>,
}

impl ParquetWriter {
    pub(crate) fn new(
        file: File,
        columns: &[(String, ColumnKind)],
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
            if matches!(kind, ColumnKind::Text | ColumnKind::Bit | ColumnKind::Flags) {
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
                ColumnKind::Wide => ColumnBuffer::Wide(Vec::with_capacity(GROUP)),
                ColumnKind::Number => ColumnBuffer::Numbers(Vec::with_capacity(GROUP)),
                ColumnKind::Bit => ColumnBuffer::Bits(Vec::with_capacity(GROUP)),
                ColumnKind::Flags => ColumnBuffer::Flags(Vec::new(), Vec::with_capacity(GROUP)),
                ColumnKind::Text => ColumnBuffer::Text(Vec::with_capacity(GROUP)),
            })
            .collect();
        Ok(Self { file, buffers, rows: 0, texts: Vec::new() })
    }

    fn text(texts: &mut Vec<ByteArray>, text: &str) -> ByteArray {
        if let Some(known) = texts.iter().find(|known| known.data() == text.as_bytes()) {
            return known.clone();
        }
        // Labels are few; a stream of ever new ones must not pile up.
        if texts.len() == 64 {
            texts.clear();
        }
        texts.push(ByteArray::from(text));
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
                ColumnBuffer::Wide(values) => write_all::<DoubleType>(&mut column, values, None)?,
                ColumnBuffer::Numbers(values) => write_all::<FloatType>(&mut column, values, None)?,
                ColumnBuffer::Bits(values) => write_all::<Int32Type>(&mut column, values, None)?,
                ColumnBuffer::Flags(values, present) => {
                    write_all::<Int32Type>(&mut column, values, Some(present))?;
                    present.clear();
                }
                ColumnBuffer::Text(values) => write_all::<ByteArrayType>(&mut column, values, None)?,
            }
            column.close()?;
        }
        group.close()?;
        self.rows = 0;
        Ok(())
    }
}

impl RowSink for ParquetWriter {
    fn push(&mut self, cells: &mut dyn Iterator<Item = RowCell<'_>>, path: &Path) -> Result<(), RecordingError> {
        for (buffer, cell) in self.buffers.iter_mut().zip(cells) {
            match (buffer, cell) {
                (ColumnBuffer::Wide(values), RowCell::Number(number)) => values.push(number),
                (ColumnBuffer::Numbers(values), RowCell::Number(number)) => values.push(number as f32),
                (ColumnBuffer::Bits(bits), RowCell::Number(bit)) => bits.push(bit as i32),
                (ColumnBuffer::Flags(values, present), RowCell::Number(flags)) => {
                    present.push(i16::from(!flags.is_nan()));
                    values.extend((!flags.is_nan()).then_some(flags as i32));
                }
                (ColumnBuffer::Text(values), RowCell::Text(text)) => values.push(Self::text(&mut self.texts, text)),
                // The cells are of the columns' kinds.
                _ => {}
            }
        }
        self.rows += 1;
        if self.rows == GROUP {
            self.flush().map_err(|error| RecordingError::io(path, "written", &error))?;
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>, metadata: &Metadata, path: &Path) -> Result<(), RecordingError> {
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
    present: Option<&[i16]>,
) -> Result<(), ParquetError> {
    column.typed::<T>().write_batch(values, present, None)?;
    values.clear();
    Ok(())
}

fn field(name: &str, kind: ColumnKind) -> Result<Type, ParquetError> {
    let (physical, logical) = match kind {
        ColumnKind::Wide => (Physical::DOUBLE, None),
        ColumnKind::Number => (Physical::FLOAT, None),
        ColumnKind::Bit => (Physical::INT32, Some(LogicalType::integer(8, false))),
        ColumnKind::Flags => (Physical::INT32, Some(LogicalType::integer(32, false))),
        ColumnKind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
    };
    Type::primitive_type_builder(name, physical)
        .with_repetition(if kind == ColumnKind::Flags { Repetition::OPTIONAL } else { Repetition::REQUIRED })
        .with_logical_type(logical)
        .build()
}
