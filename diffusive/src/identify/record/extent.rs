//! First and last time, number of rows and sample period of a file, without reading all of it.
//!
//! T = (t_last − t_first)/(rows − 1). A Parquet file knows its rows; those of a CSV file follow
//! from the times as long as the first rows tell the period well enough to count the rest with it,
//! and are counted otherwise.

use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::Path;

use super::clock::Clock;
use super::error::{RecordError, finite};
use super::roles::shown;
use recording::{CHUNK, ColumnValues, RecordingReader};

/// How far a row number that follows from times may be uncertain before rows are counted.
const UNCERTAIN_ROWS: f64 = 0.1;

/// Parts of a file's end in which its last row is residual_pass for, in bytes: lines of words may
/// stand below the table.
const TAILS: [u64; 2] = [1 << 14, 1 << 20];

pub(super) struct Extent {
    pub clock: Clock,
    pub rows: u64,
    pub last_s: f64,
}

pub(super) fn extent(path: &Path, time: usize) -> Result<Extent, RecordError> {
    let reader = |from: u64| -> Result<RecordingReader, RecordError> {
        let mut reader = RecordingReader::open(path)?;
        reader.select(&[time]);
        reader.skip(from)?;
        Ok(reader)
    };
    let mut head_reader = reader(0)?;
    let name = head_reader.names()[time].clone();
    let head = times(&mut head_reader, path, &name)?;
    finite(path, &name, &head, 0)?;
    let (&[first_s, ..], &[.., head_last_s]) = (head.as_slice(), head.as_slice()) else {
        return Err(RecordError::content(path, "has columns but no rows"));
    };
    if let Some(at) = head.windows(2).position(|pair| pair[1] <= pair[0]) {
        let (row, before, after) = (at + 2, head[at], head[at + 1]);
        let sentence = format!(
            "row {row}: `{name}` goes from {before} s to {after} s, but time must ascend; it is taken from the column `time_s`, or from the first"
        );
        return Err(RecordError::content(path, sentence));
    }
    let mut steps: Vec<f64> = head.windows(2).map(|pair| pair[1] - pair[0]).collect();
    refuse_if!(steps.is_empty(), RecordError::content(path, "has one row: a sample period takes at least two"));
    let middle = steps.len() / 2;
    let step_s = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
    let mean_s = (head_last_s - first_s) / (head.len() - 1) as f64;

    let known = head_reader.rows();
    let whole = known.map_or(head.len() < CHUNK, |rows| rows == head.len() as u64);
    let (rows, last_s) = if whole {
        (head.len() as u64, head_last_s)
    } else if let Some(rows) = known {
        drop(head_reader);
        let last = times(&mut reader(rows - 1)?, path, &name)?;
        finite(path, &name, &last, rows - 1)?;
        (rows, last.last().copied().unwrap_or(head_last_s))
    } else {
        let estimated = last_of_csv(path, time, head_reader.names())?
            .and_then(|last_s| Some((rows_until(last_s, &head, mean_s)?, last_s)));
        match estimated {
            Some(found) => found,
            None => count(head_reader, path, &name, &head)?,
        }
    };
    // Time that falls back later on is met, and told, where it does.
    let period_s = if last_s < head_last_s { mean_s } else { (last_s - first_s) / (rows - 1) as f64 };
    Ok(Extent { clock: Clock::new(first_s, period_s, step_s), rows, last_s })
}

/// The first step in the whole record that is off the usual one, as a sentence.
pub(super) fn gap(path: &Path, time: usize, name: &str, clock: &Clock) -> Result<Option<String>, RecordError> {
    let mut reader = RecordingReader::open(path)?;
    reader.select(&[time]);
    let (mut rows, mut last_s) = (0, None);
    loop {
        let more = times(&mut reader, path, name)?;
        let Some(&last) = more.last() else { return Ok(None) };
        if let Some(sentence) = clock.gap(name, rows, last_s, &more) {
            return Ok(Some(sentence));
        }
        rows += more.len() as u64;
        last_s = Some(last);
    }
}

/// The times of the next chunk; empty after the last.
fn times(reader: &mut RecordingReader, path: &Path, name: &str) -> Result<Vec<f64>, RecordError> {
    match reader.next_chunk()?.and_then(|mut columns| columns.pop()).map(|column| column.values) {
        None => Ok(Vec::new()),
        Some(ColumnValues::Numbers(times)) => Ok(times),
        Some(ColumnValues::Words(words)) => {
            let text = words.iter().next().unwrap_or_default();
            let sentence = format!("row 1, column `{name}`: `{}` stands where the time in s belongs", shown(text));
            Err(RecordError::content(path, sentence))
        }
    }
}

/// The number of rows up to the time `last_s`, unless the rows at the head leave it in doubt.
fn rows_until(last_s: f64, head: &[f64], mean_s: f64) -> Option<u64> {
    let (first_s, head_last_s) = (head[0], head[head.len() - 1]);
    if last_s < head_last_s {
        return None;
    }
    let jitter = |(n, time_s): (usize, &f64)| (time_s - first_s - n as f64 * mean_s).abs();
    let jitter_s = head.iter().enumerate().map(jitter).fold(0.0, f64::max);
    let steps = (last_s - first_s) / mean_s;
    let uncertain = 2.0 * steps * jitter_s / (head_last_s - first_s);
    (steps.is_finite() && uncertain < UNCERTAIN_ROWS).then(|| steps.round() as u64 + 1)
}

/// Reads the rest of the rows for nothing but their number.
fn count(mut reader: RecordingReader, path: &Path, name: &str, head: &[f64]) -> Result<(u64, f64), RecordError> {
    let (mut rows, mut last_s) = (head.len() as u64, head[head.len() - 1]);
    loop {
        let more = times(&mut reader, path, name)?;
        let Some(&last) = more.last() else { return Ok((rows, last_s)) };
        finite(path, name, &more, rows)?;
        rows += more.len() as u64;
        last_s = last;
    }
}

/// The time in the last row of a CSV file; `None` where it cannot be told for certain.
fn last_of_csv(path: &Path, time: usize, names: &[String]) -> Result<Option<f64>, RecordError> {
    let failed = |error: std::io::Error| RecordError::content(path, format!("cannot be read: {error}"));
    let mut file = File::open(path).map_err(failed)?;
    let length = file.metadata().map_err(failed)?.len();
    for tail in TAILS {
        let tail = tail.min(length);
        file.seek(SeekFrom::Start(length - tail)).map_err(failed)?;
        let mut bytes = Vec::with_capacity(tail as usize);
        file.by_ref().take(tail).read_to_end(&mut bytes).map_err(failed)?;
        let mut lines = bytes.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii).collect::<Vec<_>>();
        // The first may have lost its beginning.
        lines.remove(0);
        let Some(at) = lines.iter().rposition(|line| !line.is_empty() && !line.starts_with(b"#")) else { continue };
        // A quoted field may hold line breaks, and then this is no row.
        if lines[at].iter().filter(|&&byte| byte == b'"').count() % 2 == 1 {
            return Ok(None);
        }
        let mut row = csv::ReaderBuilder::new().has_headers(false).trim(csv::Trim::All).from_reader(lines[at]);
        let mut fields = csv::StringRecord::new();
        if !row.read_record(&mut fields).unwrap_or(false) {
            return Ok(None);
        }
        if fields.len() < names.len() && at + 1 == lines.len() {
            let (has, wanted) = (fields.len(), names.len());
            let sentence = format!("its last line is cut short: {has} of {wanted} fields are there; delete that line");
            return Err(RecordError::content(path, sentence));
        }
        let last_s = fields.get(time).and_then(|field| field.parse().ok());
        return Ok(last_s.filter(|last_s: &f64| last_s.is_finite() && fields.len() == names.len()));
    }
    Ok(None)
}
