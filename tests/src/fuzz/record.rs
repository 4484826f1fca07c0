//! Any bytes as a recording in CSV: blocks of finite numbers that agree with the survey, twice the same, or one sentence.

use super::said_of;
use host_sim::identify::record::{RecordError, Selection, Source as _, Stream};
use host_sim::recording::{Reader, RecordingError, Values};
use std::path::Path;
use tempfile::TempDir;

thread_local! {
    static FOLDER: TempDir = tempfile::tempdir().expect("there is room for temporary files");
}

/// The target.
///
/// # Panics
/// If something does not hold.
pub fn run(bytes: &[u8]) -> bool {
    FOLDER.with(|folder| {
        let path = folder.path().join("record.csv");
        std::fs::write(&path, bytes).expect("there is room for temporary files");
        if let Err(error) = columns(&path) {
            said_of("record.csv", &error.to_string());
        }
        let read = blocks(&path);
        // A file that is written over is flushed to the disk by some file systems, which takes longer than all the rest.
        std::fs::remove_file(&path).expect("it has just been written");
        if let Err(error) = &read {
            said_of("record.csv", &error.to_string());
        }
        read.is_ok()
    })
}

/// All columns as they are.
fn columns(path: &Path) -> Result<(), RecordingError> {
    let mut reader = Reader::open(path)?;
    let names = reader.names().to_vec();
    while let Some(chunk) = reader.next_chunk()? {
        assert!(chunk.iter().map(|column| &column.name).eq(&names));
        for column in &chunk {
            assert_eq!(column.values.len(), chunk[0].values.len());
            if let Values::Words(words) = &column.values {
                assert!(words.stretches().map(|(from, to, _)| to - from).sum::<usize>() == words.len());
            }
        }
    }
    Ok(())
}

/// The columns that an identification reads.
fn blocks(path: &Path) -> Result<(), RecordError> {
    let mut stream = Stream::open(path, &Selection::default())?;
    let mut sums = Vec::new();
    for _ in 0..2 {
        let (mut rows, mut sum) = (0, 0.0);
        while let Some(block) = stream.next_block()? {
            assert_eq!(block.first_row, rows);
            rows += block.len() as u64;
            for column in block.inputs.iter().chain(&block.outputs) {
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
