//! Tables of plain numbers, for records that no instrument made: `time_s` and named columns in f64, as CSV or Parquet by the extension.

use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Compression, Repetition, Type as Physical};
use parquet::data_type::DoubleType;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use super::{Format, Metadata, RecordingError, TIME, Temporary};

/// Rows of a row group.
const GROUP: usize = 1 << 20;

/// Writes a whole record; row n is at n times the sample period. The columns are as long as the first, or longer.
pub fn write_columns(
    path: &Path,
    sample_period_s: f64,
    columns: &[(&str, &[f64])],
    metadata: &Metadata,
) -> Result<(), RecordingError> {
    let format = Format::of(path)?;
    let (temporary, file) = Temporary::create(path).map_err(|error| RecordingError::io(path, "written", &error))?;
    let rows = columns.iter().map(|(_, values)| values.len()).min().unwrap_or(0);
    match format {
        Format::Csv => write_csv(file, sample_period_s, rows, columns, metadata)
            .map_err(|error| RecordingError::io(path, "written", &error))?,
        Format::Parquet => write_parquet(file, sample_period_s, rows, columns, metadata)
            .map_err(|error| RecordingError::io(path, "written", &error))?,
    }
    temporary.keep().map_err(|error| RecordingError::io(path, "written", &error))
}

fn write_csv(
    file: File,
    sample_period_s: f64,
    rows: usize,
    columns: &[(&str, &[f64])],
    metadata: &Metadata,
) -> std::io::Result<()> {
    let mut file = BufWriter::with_capacity(1 << 16, file);
    super::comma::write_metadata(&mut file, metadata)?;
    let names: Vec<&str> = std::iter::once(TIME).chain(columns.iter().map(|(name, _)| *name)).collect();
    writeln!(file, "{}", names.join(","))?;
    for n in 0..rows {
        write!(file, "{}", n as f64 * sample_period_s)?;
        for (_, values) in columns {
            write!(file, ",{}", values[n])?;
        }
        writeln!(file)?;
    }
    file.flush()
}

fn write_parquet(
    file: File,
    sample_period_s: f64,
    rows: usize,
    columns: &[(&str, &[f64])],
    metadata: &Metadata,
) -> Result<(), ParquetError> {
    let field = |name: &str| {
        let field = Type::primitive_type_builder(name, Physical::DOUBLE).with_repetition(Repetition::REQUIRED);
        field.build().map(Arc::new)
    };
    let fields = std::iter::once(TIME).chain(columns.iter().map(|(name, _)| *name)).map(field);
    let schema = Type::group_type_builder("record").with_fields(fields.collect::<Result<_, _>>()?).build()?;
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_created_by(format!("anemo {}", env!("CARGO_PKG_VERSION")))
        .set_key_value_metadata(Some(
            metadata.iter().map(|(key, value)| KeyValue::new(key.clone(), value.clone())).collect(),
        ));
    let mut file = SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties.build()))?;
    for from in (0..rows).step_by(GROUP) {
        let to = rows.min(from + GROUP);
        let times: Vec<f64> = (from..to).map(|n| n as f64 * sample_period_s).collect();
        let mut group = file.next_row_group()?;
        for values in std::iter::once(times.as_slice()).chain(columns.iter().map(|(_, values)| &values[from..to])) {
            let Some(mut column) = group.next_column()? else { break };
            column.typed::<DoubleType>().write_batch(values, None, None)?;
            column.close()?;
        }
        group.close()?;
    }
    file.close().map(|_| ())
}

#[cfg(test)]
mod tests {
    use super::super::{Recording, Values};
    use super::*;

    #[test]
    fn either_format_gives_the_same_numbers_back() {
        let folder = tempfile::tempdir().unwrap();
        let (u, y) = ([0.0, 1.0, 1.0], [0.1, 1.0 / 3.0, -2e-9]);
        for name in ["record.csv", "record.parquet"] {
            let path = folder.path().join(name);
            let metadata = vec![("title".to_owned(), "a test".to_owned())];
            write_columns(&path, 5e-4, &[("u", &u), ("y", &y)], &metadata).unwrap();
            let read = Recording::read(&path).unwrap();
            let columns: Vec<(&str, &Values)> = read.columns.iter().map(|c| (c.name.as_str(), &c.values)).collect();
            let numbers = |values: &[f64]| Values::Numbers(values.to_vec());
            let expected = [numbers(&[0.0, 5e-4, 1e-3]), numbers(&u), numbers(&y)];
            assert_eq!(columns.iter().map(|(name, _)| *name).collect::<Vec<_>>(), ["time_s", "u", "y"], "{name}");
            assert!(columns.iter().zip(&expected).all(|((_, values), expected)| *values == expected), "{name}");
            assert_eq!(read.metadata, metadata, "{name}");
        }
        let error = write_columns(&folder.path().join("record.txt"), 1.0, &[("u", &u)], &Vec::new()).unwrap_err();
        assert!(error.to_string().contains(".parquet or .csv"), "{error}");
    }
}
