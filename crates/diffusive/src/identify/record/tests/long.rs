//! Parquet files from elsewhere: large row groups, nullable columns, other types; and how fast a
//! long one passes.

use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, TimeUnit, Type as Physical};
use parquet::data_type::{DoubleType, Int64Type};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use super::*;

/// One row group: the time in ns as a timestamp, and two nullable columns `u` (n modulo 7) and `y`
/// (n), of which y lacks `missing`.
fn foreign(rows: usize, missing: Option<usize>) -> TemporaryFile {
    let temp = file("foreign.parquet", "");
    let column = |name: &str, physical, logical, repetition| {
        let column = Type::primitive_type_builder(name, physical);
        Arc::new(column.with_logical_type(logical).with_repetition(repetition).build().unwrap())
    };
    let stamp = Some(LogicalType::timestamp(true, TimeUnit::NANOS));
    let fields = vec![
        column("stamp", Physical::INT64, stamp, Repetition::REQUIRED),
        column("u", Physical::DOUBLE, None, Repetition::OPTIONAL),
        column("y", Physical::DOUBLE, None, Repetition::OPTIONAL),
    ];
    let schema = Arc::new(Type::group_type_builder("schema").with_fields(fields).build().unwrap());
    let properties = WriterProperties::builder().set_dictionary_enabled(false).build();
    let disk = std::fs::File::create(&temp.path).unwrap();
    let mut writer = SerializedFileWriter::new(disk, schema, Arc::new(properties)).unwrap();
    let mut group = writer.next_row_group().unwrap();
    let mut time = group.next_column().unwrap().unwrap();
    let stamps: Vec<i64> = (0..rows as i64).map(|n| 1_700_000_000_000_000_000 + n * 10_000_000).collect();
    time.typed::<Int64Type>().write_batch(&stamps, None, None).unwrap();
    time.close().unwrap();
    for (period, missing) in [(7, None), (usize::MAX, missing)] {
        let mut column = group.next_column().unwrap().unwrap();
        let levels: Vec<i16> = (0..rows).map(|n| i16::from(Some(n) != missing)).collect();
        let values: Vec<f64> = (0..rows).filter(|&n| Some(n) != missing).map(|n| (n % period) as f64).collect();
        column.typed::<DoubleType>().write_batch(&values, Some(&levels), None).unwrap();
        column.close().unwrap();
    }
    group.close().unwrap();
    writer.close().unwrap();
    temp
}

#[test]
fn a_large_row_group_is_read_in_pieces_and_a_timestamp_is_its_seconds() {
    let temp = foreign(100_000, None);
    let mut stream = RecordStream::open(&temp.path, &Selection::default()).unwrap();
    let survey = stream.survey();
    assert_eq!((survey.rows, survey.inputs[0].as_str(), survey.outputs[0].as_str()), (100_000, "u", "y"));
    assert!((survey.sample_period_s - 0.01).abs() < 1e-10);
    assert!((survey.last_time_s - 1_700_000_999.99).abs() < 1e-6);
    let mut row = 0;
    while let Some(block) = stream.next_block().unwrap() {
        assert!(block.len() <= BLOCK);
        for (u, y) in block.inputs[0].iter().zip(&block.outputs[0]) {
            assert_eq!((*u, *y), ((row % 7) as f64, row as f64));
            row += 1;
        }
    }
    assert_eq!(row, 100_000);
}

#[test]
fn a_null_in_a_later_piece_is_a_missing_value_in_its_row() {
    let temp = foreign(50_000, Some(40_000));
    let (survey, block, _) = read_all(&temp.path, &Selection::default()).unwrap();
    assert_eq!((survey.rows, survey.segments, block.missing), (50_000, 1, vec![40_000]));
    assert_eq!(block.outputs[0][40_000], 39_999.0, "the value before");
}

/// The memory that the process has held at most, kB.
fn peak_memory_kb() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmHWM:"));
    line.and_then(|line| line.split_whitespace().nth(1)?.parse().ok()).unwrap_or_default()
}

#[test]
#[ignore = "a measurement: cargo test --release -p host-sim --lib -- --ignored --nocapture long_recording"]
fn a_long_recording_passes_in_the_memory_of_some_blocks() {
    const ROWS: u64 = 100_000_000;
    let temp = file("long.parquet", "");
    let layout = RecordingLayout {
        elements: vec!["a".to_owned()],
        true_wind: false,
        gas: false,
        observed: Vec::new(),
        estimates: Vec::new(),
        combined_wind: false,
        earth_wind: false,
        cores: Vec::new(),
        numbers: Vec::new(),
    };
    let mut writer = RecordingWriter::create(&temp.path, layout, &Metadata::new()).unwrap();
    let mut noise = 1_u32;
    for n in 0..ROWS {
        noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let row = RecordingRow {
            time_s: n as f64 / 1000.0,
            temperature_c: &[noise as f32 / 1e9],
            power_w: &[0.04 * (noise >> 31) as f32],
            equivalent_power_w: &[],
            heaters: 0,
            event: "",
            state: "running",
            true_wind_m_s: None,
            gas_temperature_c: None,
            estimate: &[],
        };
        writer.push(&row).unwrap();
    }
    writer.finish(&Metadata::new()).unwrap();
    let before_kb = peak_memory_kb();
    assert_eq!(measured("with event and state", &temp.path), ROWS);
    // Some blocks of 16 384 rows, and the file's table of contents, which has a line for every row
    // group and column.
    assert!(peak_memory_kb() - before_kb < 49_152, "{} kB", peak_memory_kb() - before_kb);
    assert_eq!(measured("three columns, two of them nullable", &foreign(5_000_000, None).path), 5_000_000);
}

/// Processor time of this thread, s: other work on the machine does not count.
fn processor_s() -> f64 {
    let status = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    status.split_whitespace().next().and_then(|ns| ns.parse::<f64>().ok()).unwrap_or_default() * 1e-9
}

/// Reads a record, and prints how long a row took.
fn measured(what: &str, path: &Path) -> u64 {
    let start_s = processor_s();
    let mut stream = RecordStream::open(path, &Selection::default()).unwrap();
    let opened_s = processor_s() - start_s;
    let mut sum = 0.0;
    while let Some(block) = stream.next_block().unwrap() {
        sum += block.outputs[0].iter().sum::<f64>();
    }
    let rows = stream.survey().rows;
    let (row_ns, mean) = ((processor_s() - start_s - opened_s) * 1e9 / rows as f64, sum / rows as f64);
    println!("{what}: opened in {opened_s:.3} s, {row_ns:.1} ns a row, mean {mean}, peak {} kB", peak_memory_kb());
    rows
}
