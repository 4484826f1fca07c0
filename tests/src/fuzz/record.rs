//! Any bytes as a recording, in Parquet if they begin as such and in CSV if not: blocks of finite
//! numbers that agree with the survey, twice the same, or one sentence. Columns are found by their
//! headings, and again by names.

use super::sentences::said_of;
use diffusive::identify::record::{RecordError, RecordSource as _, RecordStream, Selection};
use recording::{ColumnValues, RecordingError, RecordingReader};
use std::path::Path;
use tempfile::TempDir;

/// Beginning of a file in Parquet.
const PARQUET: &[u8] = b"PAR1";

thread_local! {
    static FOLDER: TempDir = tempfile::tempdir().expect("there is room for temporary files");
}

/// The target.
///
/// # Panics
/// If something does not hold.
pub fn run(bytes: &[u8]) -> bool {
    FOLDER.with(|folder| {
        let name = if bytes.starts_with(PARQUET) { "record.parquet" } else { "record.csv" };
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("there is room for temporary files");
        if let Err(error) = columns(&path) {
            said_of(name, &error.to_string());
        }
        let read = [Selection::default(), named()].map(|selection| blocks(&path, &selection));
        // A file that is written over is flushed to the disk by some file systems, which takes
        // longer than all the rest.
        std::fs::remove_file(&path).expect("it has just been written");
        read.iter().filter_map(|read| read.as_ref().err()).for_each(|error| said_of(name, &error.to_string()));
        read.iter().any(Result::is_ok)
    })
}

/// Columns as a foreign file calls them.
fn named() -> Selection {
    Selection {
        inputs: vec!["u".to_owned()],
        outputs: vec!["y".to_owned()],
        event: Some("phase".to_owned()),
        gas: Some("gas".to_owned()),
        ..Selection::default()
    }
}

/// All columns as they are.
fn columns(path: &Path) -> Result<(), RecordingError> {
    let mut reader = RecordingReader::open(path)?;
    let names = reader.names().to_vec();
    while let Some(chunk) = reader.next_chunk()? {
        assert!(chunk.iter().map(|column| &column.name).eq(&names));
        for column in &chunk {
            assert_eq!(column.values.len(), chunk[0].values.len());
            if let ColumnValues::Words(words) = &column.values {
                assert!(words.stretches().map(|(from, to, _)| to - from).sum::<usize>() == words.len());
            }
        }
    }
    Ok(())
}

/// The columns that an identification reads.
fn blocks(path: &Path, selection: &Selection) -> Result<(), RecordError> {
    let mut stream = RecordStream::open(path, selection)?;
    let mut sums = Vec::new();
    for _ in 0..2 {
        let (mut rows, mut sum) = (0, 0.0);
        while let Some(block) = stream.next_block()? {
            rows += block.len() as u64;
            let gas = Some(&block.gas).filter(|gas| !gas.is_empty());
            for column in block.inputs.iter().chain(&block.outputs).chain(gas) {
                assert_eq!(column.len(), block.len());
                assert!(column.iter().all(|value| value.is_finite()));
                sum += column.iter().sum::<f64>();
            }
            let classes = block.class.clone();
            assert!(classes.iter().all(|&class| (class as usize) < stream.classes().len()));
        }
        let survey = stream.survey();
        assert!(rows >= 2 && survey.rows == rows && !survey.inputs.is_empty() && !survey.outputs.is_empty());
        assert!(survey.sample_period_s > 0.0 && survey.last_time_s > survey.first_time_s);
        sums.push((rows, sum.to_bits()));
        stream.restart()?;
    }
    assert_eq!(sums[0], sums[1]);
    Ok(())
}
