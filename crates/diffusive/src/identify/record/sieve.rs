//! Which rows of a file are taken, and where a segment begins: every pass over a record decides
//! alike.
//!
//! | row | is |
//! |---|---|
//! | time, input, gas or number of a class is missing | left out; the next one begins a segment |
//! | comes more than half a period behind its place | the first of a segment |
//! | before every output has had a value | left out |
//! | an output is missing | taken; the output keeps its value |

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use super::clock::{Clock, ClockFault, usual_step_s};
use super::error::RecordError;
use super::files::{RawRows, RecordFiles};
use super::roles::Roles;
use recording::ColumnValues;
use recording::text::tidy;

/// Sample periods of the files of a record differ by no more than this part.
const PERIOD_TOLERANCE: f64 = 0.01;

/// Consecutive rows of a segment, within what was read at once.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Piece {
    pub rows: Range<usize>,
    pub begins_segment: bool,
    /// Of the clock, with the place of the first row.
    pub run: usize,
    pub n: u64,
}

/// What a pass has met.
#[derive(Debug, Clone, Default)]
pub(super) struct Tally {
    pub rows: u64,
    pub segments: u64,
    /// Rows of the segment that is being read, and of the longest.
    segment_rows: u64,
    pub longest: u64,
    /// Gaps in time, and the periods in them.
    pub gaps: u64,
    pub lost: u64,
    /// Rows that were left out, and the first of them: file, row from 1, column.
    pub dropped: u64,
    pub first_dropped: Option<(usize, u64, String)>,
    /// Rows in which each output is missing.
    pub missing: Vec<u64>,
}

pub(super) struct Sieve {
    /// Slot and name of each column without whose value a row is left out.
    needed: Arc<[(usize, String)]>,
    outputs: Arc<[(usize, String)]>,
    clock: Clock,
    /// Step of each file begun so far.
    steps_s: Vec<f64>,
    /// Whether each output has had a value.
    seen: Vec<bool>,
    is_broken: bool,
    pub tally: Tally,
}

impl Sieve {
    pub(super) fn new(files: &RecordFiles, roles: &Roles) -> Self {
        let named = |&column: &usize| (files.slot(column), files.names()[column].clone());
        let needed = roles.inputs.iter().chain(&roles.gas).chain(&roles.event).map(named).collect();
        let outputs: Arc<[_]> = roles.outputs.iter().map(named).collect();
        let tally = Tally { missing: vec![0; outputs.len()], ..Tally::default() };
        let seen = vec![false; outputs.len()];
        Self { needed, outputs, clock: Clock::default(), steps_s: Vec::new(), seen, is_broken: false, tally }
    }

    pub(super) const fn clock(&self) -> &Clock {
        &self.clock
    }

    /// Cuts rows to those that are taken.
    pub(super) fn pieces(&mut self, files: &RecordFiles, raw: &RawRows) -> Result<Vec<Piece>, RecordError> {
        let path = &files.paths[raw.file];
        if raw.first_row == 0 {
            self.begin_file(files, raw)?;
        }
        let (needed, outputs) = (Arc::clone(&self.needed), Arc::clone(&self.outputs));
        let mut needed = lacking(path, raw, &needed)?;
        let outputs = lacking(path, raw, &outputs)?;
        if !raw.time_s.iter().fold(true, |all, value| all & value.is_finite()) {
            refuse_infinite(path, &files.time_column, &raw.time_s, raw)?;
            needed.insert(0, LackingColumn { at: 0, name: &files.time_column, values: &raw.time_s });
        }
        let mut pieces: Vec<Piece> = Vec::new();
        for (row, &now_s) in raw.time_s.iter().enumerate() {
            let place = if now_s.is_nan() { None } else { Some(self.place(files, raw, row)?) };
            if let Some(place) = place.filter(|place| place.lost > 0) {
                self.tally.gaps += 1;
                self.tally.lost = self.tally.lost.saturating_add(place.lost);
                self.is_broken = true;
            }
            let lacks = needed.iter().find(|column| column.values[row].is_nan()).map(|column| column.name);
            let lacks = lacks.or_else(|| self.lacks_output(&outputs, row));
            let (Some(place), None) = (place, lacks) else {
                self.tally.dropped += 1;
                let number = raw.number(row);
                self.tally
                    .first_dropped
                    .get_or_insert_with(|| (raw.file, number, lacks.unwrap_or_default().to_owned()));
                self.is_broken = true;
                continue;
            };
            for column in &outputs {
                self.tally.missing[column.at] += u64::from(column.values[row].is_nan());
            }
            self.tally.rows += 1;
            match pieces.last_mut() {
                Some(piece) if !self.is_broken => piece.rows.end += 1,
                _ => {
                    let is_first = self.tally.segments == 0;
                    let begins_segment = self.is_broken && !is_first;
                    if begins_segment || is_first {
                        self.tally.segments += 1;
                        self.tally.segment_rows = 0;
                    }
                    pieces.push(Piece { rows: row..row + 1, begins_segment, run: place.run, n: place.n });
                }
            }
            self.is_broken = false;
            self.tally.segment_rows += 1;
            self.tally.longest = self.tally.longest.max(self.tally.segment_rows);
        }
        Ok(pieces)
    }

    /// An output that has not had a value up to this row.
    fn lacks_output<'a>(&mut self, outputs: &[LackingColumn<'a>], row: usize) -> Option<&'a str> {
        if self.seen.iter().all(|&seen| seen) {
            return None;
        }
        let mut lacks = None;
        for at in 0..self.seen.len() {
            let column = outputs.iter().find(|column| column.at == at);
            self.seen[at] |= column.is_none_or(|column| !column.values[row].is_nan());
            lacks = lacks.or(column.filter(|_| !self.seen[at]).map(|column| column.name));
        }
        lacks
    }

    fn begin_file(&mut self, files: &RecordFiles, raw: &RawRows) -> Result<(), RecordError> {
        let path = &files.paths[raw.file];
        let step_s = usual_step_s(&raw.time_s).ok_or_else(|| {
            let name = &files.time_column;
            match raw.time_s.windows(2).position(|pair| pair[1] <= pair[0]) {
                Some(at) => {
                    RecordError::content(path, does_not_ascend(name, at as u64 + 2, raw.time_s[at], raw.time_s[at + 1]))
                }
                None if raw.time_s.iter().all(|time_s| time_s.is_nan()) => RecordError::content(
                    path,
                    format!("column `{name}` has no number: name the column of times `time_s`"),
                ),
                None => RecordError::content(path, "has one row: a sample period takes at least two"),
            }
        })?;
        if let Some(&first_s) = self.steps_s.first()
            && (step_s / first_s - 1.0).abs() > PERIOD_TOLERANCE
        {
            return Err(RecordError::content(
                path,
                format!(
                    "has rows {} s apart, and {} has {} s: identify records of one sample period together",
                    tidy(step_s),
                    files.paths[0].display(),
                    tidy(first_s)
                ),
            ));
        }
        self.steps_s.push(step_s);
        let goes_on = self.clock.begin_file(&raw.time_s, step_s);
        self.is_broken |= !goes_on;
        Ok(())
    }

    fn place(&mut self, files: &RecordFiles, raw: &RawRows, row: usize) -> Result<super::clock::RowPlace, RecordError> {
        let now_s = raw.time_s[row];
        let before_s = self.clock.last_s();
        self.clock.place(now_s).map_err(|fault| {
            let (name, number, before_s) = (&files.time_column, raw.number(row), before_s.unwrap_or(now_s));
            let path = &files.paths[raw.file];
            match fault {
                ClockFault::DoesNotAscend => RecordError::content(path, does_not_ascend(name, number, before_s, now_s)),
                ClockFault::TooEarly => RecordError::uneven(
                    path,
                    format!(
                        "row {number}: `{name}` moves on by {} s, by {} s elsewhere; resample the record or cut it there",
                        tidy(now_s - before_s),
                        tidy(self.clock.step_s())
                    ),
                ),
            }
        })
    }
}

fn does_not_ascend(name: &str, row: u64, before_s: f64, now_s: f64) -> String {
    format!(
        "row {row}: `{name}` goes from {before_s} s to {now_s} s, but time must ascend; it is taken from the column `time_s`, or from the first"
    )
}

/// A column of numbers in which a value is missing.
struct LackingColumn<'a> {
    /// In its list.
    at: usize,
    name: &'a str,
    values: &'a [f64],
}

/// The columns in which a value is missing.
fn lacking<'a>(
    path: &Path,
    raw: &'a RawRows,
    columns: &'a [(usize, String)],
) -> Result<Vec<LackingColumn<'a>>, RecordError> {
    let mut lacking = Vec::new();
    for (at, (slot, name)) in columns.iter().enumerate() {
        let ColumnValues::Numbers(values) = &raw.columns[*slot] else { continue };
        // Without a branch in the loop: this runs over every value of every record.
        if !values.iter().fold(true, |all, value| all & value.is_finite()) {
            refuse_infinite(path, name, values, raw)?;
            lacking.push(LackingColumn { at, name, values });
        }
    }
    Ok(lacking)
}

fn refuse_infinite(path: &Path, name: &str, values: &[f64], raw: &RawRows) -> Result<(), RecordError> {
    match values.iter().position(|value| value.is_infinite()) {
        None => Ok(()),
        Some(at) => {
            let what = "an infinite value; cut the record there or fill the gap";
            Err(RecordError::value(path, name, raw.number(at) - 1, what))
        }
    }
}
