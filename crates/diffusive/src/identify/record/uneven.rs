//! A record whose rows stand at times of their own: a transient of a thermal tester, whose times
//! are spaced evenly in their logarithm, or a logger that skips.
//!
//! The power of a row is held to the next. Such a record is one segment, whole in memory.

use std::path::{Path, PathBuf};

use super::error::RecordError;
use super::files::{RecordFiles, numbers};
use super::roles::Roles;
use super::source::{BLOCK, Block, RecordSource, Selection, Survey};
use super::stream::RecordStream;
use super::table::RecordTable;
use super::times::SINCE_1970_S;
use recording::text::tidy;
use recording::utc;

/// Rows that are held in memory.
const MOST_ROWS: usize = 100_000;
/// First time over duration up to which a driven record is taken to have begun at 0 s.
const AT_ZERO: f64 = 1e-3;

/// Opens a record, on whatever times its rows stand.
///
/// # Errors
/// Fails as [`RecordStream::open_all`] does; or if an uneven record has several files, event classes, a
/// gas column or too many rows.
pub fn open(paths: &[PathBuf], selection: &Selection) -> Result<Box<dyn RecordSource>, RecordError> {
    match RecordStream::open_all(paths, selection) {
        Err(uneven @ RecordError::Uneven { .. }) => match read(paths, selection)? {
            Some(table) => Ok(Box::new(table)),
            None => Err(uneven),
        },
        other => Ok(Box::new(other?)),
    }
}

/// Columns of a record, row by row.
struct Rows {
    time_s: Vec<f64>,
    inputs: Vec<Vec<f64>>,
    outputs: Vec<Vec<f64>>,
}

/// The whole record; `None` where it has what uneven times do not allow.
fn read(paths: &[PathBuf], selection: &Selection) -> Result<Option<RecordTable>, RecordError> {
    let [path] = paths else { return Ok(None) };
    let roles = Roles::choose(path, selection)?;
    let mut files = RecordFiles::new(paths, &roles, selection)?.without_insertion();
    let names = files.names().to_vec();
    if roles.event.is_some() || roles.gas.is_some() {
        return Ok(None);
    }
    let mut rows = Rows {
        time_s: Vec::new(),
        inputs: vec![Vec::new(); roles.inputs.len()],
        outputs: vec![Vec::new(); roles.outputs.len()],
    };
    while let Some(mut raw) = files.next_rows()? {
        rows.time_s.append(&mut raw.time_s);
        if rows.time_s.len() > MOST_ROWS {
            return Ok(None);
        }
        for (columns, into) in [(&roles.inputs, &mut rows.inputs), (&roles.outputs, &mut rows.outputs)] {
            for (&column, into) in columns.iter().zip(into) {
                let slot = files.slot(column);
                into.extend_from_slice(numbers(path, &names[column], &mut raw.columns[slot], raw.first_row)?);
            }
        }
    }
    let mut notes = roles.notes.clone();
    rows.leave_out(&mut notes);
    rows.check(path, &files.time_column)?;
    rows.begin_at_zero(&mut notes);
    let interval_s = rows.intervals_s();
    let shortest_s = rows.shortest_s(&interval_s);
    let (first_s, last_s) = (rows.time_s[0], rows.time_s[rows.time_s.len() - 1]);
    let longest_s = interval_s.iter().copied().fold(0.0, f64::max);
    notes.push(format!(
        "times are not uniform (rows {} to {} s apart): every relaxation is computed over each interval, with the power held to the next row",
        tidy(interval_s.iter().copied().fold(f64::INFINITY, f64::min)),
        tidy(longest_s)
    ));
    let metadata = files.metadata()?;
    let name = |&column: &usize| names[column].clone();
    let is_dated = roles.time.is_text || first_s >= SINCE_1970_S;
    let survey = Survey {
        path: path.clone(),
        paths: paths.to_vec(),
        time_column: files.time_column.clone(),
        inputs: roles.inputs.iter().map(name).collect(),
        outputs: roles.outputs.iter().map(name).collect(),
        event_column: None,
        gas_column: None,
        rows: rows.time_s.len() as u64,
        segments: 1,
        longest_rows: rows.time_s.len() as u64,
        start_utc: is_dated.then(|| utc::rfc3339(first_s)),
        first_time_s: first_s,
        last_time_s: last_s,
        sample_period_s: shortest_s,
        is_uneven: true,
        conditions: crate::model::Conditions::of_metadata(&metadata),
        notes,
    };
    Ok(Some(RecordTable::of(survey, rows.blocks(interval_s))))
}

impl Rows {
    /// Leaves rows out in which time or input is missing.
    fn leave_out(&mut self, notes: &mut Vec<String>) {
        let is_there = |row: usize| self.time_s[row].is_finite() && self.inputs.iter().all(|own| own[row].is_finite());
        let kept: Vec<usize> = (0..self.time_s.len()).filter(|&row| is_there(row)).collect();
        let dropped = self.time_s.len() - kept.len();
        if dropped > 0 {
            notes.push(format!("{dropped} rows left out, in which time or input is missing"));
            for column in [&mut self.time_s].into_iter().chain(&mut self.inputs).chain(&mut self.outputs) {
                *column = kept.iter().map(|&row| column[row]).collect();
            }
        }
    }

    /// Refuses times that do not ascend, and outputs that are missing in most rows.
    fn check(&self, path: &Path, time_column: &str) -> Result<(), RecordError> {
        if self.time_s.len() < 2 {
            return Err(RecordError::content(path, "has one row: a model takes at least two"));
        }
        if let Some(at) = self.time_s.windows(2).position(|two| two[1] <= two[0]) {
            let [before_s, now_s] = [at, at + 1].map(|row| tidy(self.time_s[row]));
            let sentence = format!(
                "`{time_column}` goes from {before_s} s to {now_s} s, but time must ascend: sort the rows, and keep one of each time"
            );
            return Err(RecordError::content(path, sentence));
        }
        let missing = |values: &Vec<f64>| values.iter().filter(|value| !value.is_finite()).count();
        if self.outputs.iter().any(|values| 2 * missing(values) > values.len()) {
            return Err(RecordError::content(path, "has no output in more than half of its rows: fill it"));
        }
        Ok(())
    }

    /// Puts a row at 0 s before a driven record that begins just after: thermal testers count from the
    /// switch.
    fn begin_at_zero(&mut self, notes: &mut Vec<String>) {
        let (first_s, last_s) = (self.time_s[0], self.time_s[self.time_s.len() - 1]);
        let is_driven = self.inputs.iter().any(|values| values[0] != 0.0);
        if !is_driven || first_s <= 0.0 || first_s > AT_ZERO * last_s {
            return;
        }
        self.time_s.insert(0, 0.0);
        self.inputs.iter_mut().for_each(|values| values.insert(0, values[0]));
        self.outputs.iter_mut().for_each(|values| values.insert(0, f64::NAN));
        notes.push(format!("the first row is at {} s: its power is taken to be held since 0 s", tidy(first_s)));
    }

    /// Time from each row to the next; the last as the one before.
    fn intervals_s(&self) -> Vec<f64> {
        let mut interval_s: Vec<f64> = self.time_s.windows(2).map(|two| two[1] - two[0]).collect();
        interval_s.push(interval_s[interval_s.len() - 1]);
        interval_s
    }

    /// The shortest interval after a move of an input: no faster relaxation shows.
    fn shortest_s(&self, interval_s: &[f64]) -> f64 {
        let moves = |row: usize| {
            self.inputs.iter().any(|values| if row == 0 { values[0] != 0.0 } else { values[row] != values[row - 1] })
        };
        let after = (0..interval_s.len()).filter(|&row| moves(row)).map(|row| interval_s[row]);
        let shortest_s = after.fold(f64::INFINITY, f64::min);
        if shortest_s.is_finite() { shortest_s } else { interval_s[0] }
    }

    fn blocks(mut self, interval_s: Vec<f64>) -> Vec<Block> {
        let rows = self.time_s.len();
        let mut missing: Vec<u32> = Vec::new();
        for values in &mut self.outputs {
            let mut last = values.iter().copied().find(|value| value.is_finite()).unwrap_or_default();
            for (row, value) in values.iter_mut().enumerate() {
                if value.is_finite() {
                    last = *value;
                } else {
                    missing.push(row as u32);
                    *value = last;
                }
            }
        }
        missing.sort_unstable();
        missing.dedup();
        let all = Block {
            inputs: self.inputs,
            outputs: self.outputs,
            class: vec![0; rows],
            time_s: (self.time_s[0], self.time_s[rows - 1]),
            missing,
            interval_s,
            ..Block::default()
        };
        (0..rows).step_by(BLOCK).map(|from| all.rows(from..rows.min(from + BLOCK))).collect()
    }
}
