//! A record read from its files, block by block.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};

use super::classes::Classes;
use super::clock::{LATE, NEGLIGIBLE};
use super::error::RecordError;
use super::files::{RawRows, RecordFiles, numbers};
use super::roles::Roles;
use super::scan::{RunGrid, Scan};
use super::sieve::{Piece, Sieve};
use super::source::{Block, RecordSource, Selection, Survey};
use super::times::SINCE_1970_S;
use crate::model::Conditions;
use recording::text::tidy;
use recording::{ColumnValues, GAS_TEMPERATURE, utc};

/// Note on a recording of our instrument whose gas column is not used.
const OSCILLATING: &str = "the gas temperature oscillated while this was recorded, and its column `gas_temperature_c` is left out: \
    structure `conductance` takes it with --gas-temperature gas_temperature_c";

/// Under this key our recordings say when they began.
const START_UTC: &str = "start_utc";

/// Parquet or CSV files as a record.
pub struct RecordStream {
    survey: Survey,
    roles: Roles,
    files: RecordFiles,
    grids: Vec<RunGrid>,
    has_jitter: bool,
    sieve: Sieve,
    classes: Classes,
    /// Rows that were read to see what follows the ones before.
    ahead: Option<RawRows>,
    /// Time and outputs of the row before, if it is of the same segment.
    before: Option<(f64, Vec<f64>)>,
    /// The last value of each output.
    last: Vec<f64>,
    ready: VecDeque<Block>,
    block: Block,
    /// Rows whose time was off, and by how much at most, s.
    off: (u64, f64),
    read_once: bool,
}

impl RecordStream {
    /// Reads a record once, and decides which columns play which part.
    pub fn open(path: &Path, selection: &Selection) -> Result<Self, RecordError> {
        Self::open_all(&[path.to_owned()], selection)
    }

    /// As [`RecordStream::open`], of several files with the same columns: each begins a segment,
    /// unless it goes on where the one before ended.
    ///
    /// # Errors
    /// As there; or if there is no file, or one of other columns or of another sample period.
    pub fn open_all(paths: &[PathBuf], selection: &Selection) -> Result<Self, RecordError> {
        let Some(path) = paths.first() else {
            return Err(RecordError::content(Path::new("the record"), "has no file: name one at least"));
        };
        let whole: Vec<PathBuf> = paths.iter().map(|path| recording::whole_path(path)).collect();
        for (number, path) in paths.iter().enumerate() {
            if whole[..number].contains(&whole[number]) {
                return Err(RecordError::content(path, "is named twice: its rows would count as two measurements"));
            }
        }
        let roles = Roles::choose(path, selection)?;
        let mut files = RecordFiles::new(paths, &roles, selection)?;
        let scan = Scan::of(&mut files, &roles)?;
        let names = files.names();
        let mut notes = roles.notes.clone();
        if roles.gas.is_none() && names.iter().any(|name| name == GAS_TEMPERATURE) {
            notes.push(OSCILLATING.to_owned());
        }
        notes.extend(scan.notes);
        let name = |&column: &usize| names[column].clone();
        let is_dated = roles.time.is_text || scan.first_s >= SINCE_1970_S;
        let metadata = files.metadata()?;
        let stated_utc = metadata.iter().find(|(key, _)| key == START_UTC).map(|(_, utc)| utc.clone());
        let survey = Survey {
            path: path.clone(),
            paths: paths.to_vec(),
            time_column: files.time_column.clone(),
            inputs: roles.inputs.iter().map(name).collect(),
            outputs: roles.outputs.iter().map(name).collect(),
            event_column: roles.event.as_ref().map(name),
            gas_column: roles.gas.as_ref().map(name),
            rows: scan.rows,
            segments: scan.segments,
            longest_rows: scan.longest,
            start_utc: if is_dated { Some(utc::rfc3339(scan.first_s)) } else { stated_utc }
                .filter(|utc| !utc.is_empty()),
            first_time_s: scan.first_s,
            last_time_s: scan.last_s,
            sample_period_s: scan.period_s,
            is_uneven: false,
            conditions: Conditions::of_metadata(&metadata),
            notes,
        };
        files.restart();
        Ok(Self {
            sieve: Sieve::new(&files, &roles),
            grids: scan.grids,
            has_jitter: scan.has_jitter,
            classes: if roles.event.is_some() { Classes::growing() } else { Classes::none() },
            ahead: None,
            before: None,
            last: vec![f64::NAN; roles.outputs.len()],
            ready: VecDeque::new(),
            block: Block::default(),
            off: (0, 0.0),
            read_once: false,
            survey,
            roles,
            files,
        })
    }

    /// Makes blocks of rows.
    fn take(&mut self, mut raw: RawRows) -> Result<(), RecordError> {
        let pieces = self.sieve.pieces(&self.files, &raw)?;
        for piece in &pieces {
            self.refuse_drift(&raw, piece)?;
        }
        let rows = raw.time_s.len();
        let is_whole = matches!(pieces.as_slice(), [piece] if piece.rows == (0..rows));
        for piece in pieces {
            let block = self.block_of(&mut raw, &piece, is_whole)?;
            self.ready.push_back(block);
        }
        Ok(())
    }

    /// A piece as a block; the columns of whole rows are taken rather than copied.
    fn block_of(&mut self, raw: &mut RawRows, piece: &Piece, is_whole: bool) -> Result<Block, RecordError> {
        let Self { survey, roles, files, classes, .. } = self;
        let path = &files.paths[raw.file];
        let rows = piece.rows.clone();
        let mut block = Block {
            time_s: (raw.time_s[rows.start], raw.time_s[rows.end - 1]),
            begins_segment: piece.begins_segment,
            ..Block::default()
        };
        match (roles.event, &survey.event_column) {
            (Some(event), Some(name)) => {
                let labels = &raw.columns[files.slot(event)];
                classes.fill(path, name, raw.first_row, labels, rows.clone(), &mut block.class)?;
            }
            _ => block.class.resize(rows.len(), 0),
        }
        // A gas column may be an output as well, so it is copied before that is taken.
        if let (Some(gas), Some(name)) = (roles.gas, &survey.gas_column) {
            let values = numbers(path, name, &mut raw.columns[files.slot(gas)], raw.first_row)?;
            block.gas.extend_from_slice(&values[rows.clone()]);
        }
        for (columns, names, into) in
            [(&roles.inputs, &survey.inputs, &mut block.inputs), (&roles.outputs, &survey.outputs, &mut block.outputs)]
        {
            for (&column, name) in columns.iter().zip(names) {
                let values = numbers(path, name, &mut raw.columns[files.slot(column)], raw.first_row)?;
                into.push(if is_whole { std::mem::take(values) } else { values[rows.clone()].to_vec() });
            }
        }
        if self.has_jitter {
            self.interpolate(raw, piece, &mut block);
        }
        self.fill_missing(&mut block);
        Ok(block)
    }

    /// Refuses a time that is off its place on the grid of the whole run.
    fn refuse_drift(&self, raw: &RawRows, piece: &Piece) -> Result<(), RecordError> {
        let RunGrid { begin_s, period_s } = self.grids[piece.run];
        let times = piece.rows.clone().map(|row| raw.time_s[row]).zip(piece.n..);
        // What jitters by half a period may lie on either side.
        let most_s = period_s * if self.has_jitter { LATE } else { 0.5 };
        let is_off = |(now_s, n): &(f64, u64)| (now_s - (begin_s + *n as f64 * period_s)).abs() > most_s;
        let Some((at, (now_s, n))) = times.enumerate().find(|(_, time)| is_off(time)) else { return Ok(()) };
        let row = raw.number(piece.rows.start + at);
        let sentence = format!(
            "row {row}: `{}` is {now_s} s where {} s is due after {n} periods of {} s: its rate drifts; resample the record \
             to uniform times",
            self.survey.time_column,
            tidy(begin_s + n as f64 * period_s),
            tidy(period_s)
        );
        Err(RecordError::content(&self.files.paths[raw.file], sentence))
    }

    /// Gives outputs whose time jitters their value at their place, between two neighbours.
    fn interpolate(&mut self, raw: &RawRows, piece: &Piece, block: &mut Block) {
        let RunGrid { begin_s, period_s } = self.grids[piece.run];
        let rows = block.len();
        let time_s = &raw.time_s[piece.rows.clone()];
        let before = self.before.take().filter(|_| !piece.begins_segment);
        // What follows the last row, unless a gap does.
        let (after, slots) = (self.ahead.as_ref(), self.roles.outputs.iter().map(|&output| self.files.slot(output)));
        let after = after.filter(|next| piece.rows.end == raw.time_s.len() && next.file == raw.file);
        let after = after.filter(|next| next.time_s[0] - time_s[rows - 1] < 2.0 * period_s);
        let after: Option<(f64, Vec<f64>)> = after.map(|next| {
            let value = |slot: usize| match &next.columns[slot] {
                ColumnValues::Numbers(values) => values[0],
                ColumnValues::Words(_) => f64::NAN,
            };
            (next.time_s[0], slots.map(value).collect())
        });
        self.before = Some((time_s[rows - 1], block.outputs.iter().map(|values| values[rows - 1]).collect()));
        let is_off = |n: usize| {
            let off_s = time_s[n] - (begin_s + (piece.n + n as u64) as f64 * period_s);
            Some(off_s).filter(|off_s| off_s.abs() > NEGLIGIBLE * period_s)
        };
        for (output, values) in block.outputs.iter_mut().enumerate() {
            let written = values.clone();
            let at = |n: usize| (time_s[n], written[n]);
            let outer = |row: &Option<(f64, Vec<f64>)>| row.as_ref().map(|(time_s, values)| (*time_s, values[output]));
            for (n, value) in values.iter_mut().enumerate() {
                let Some(off_s) = is_off(n) else { continue };
                let neighbour = match off_s > 0.0 {
                    true if n == 0 => outer(&before),
                    true => Some(at(n - 1)),
                    false if n + 1 == rows => outer(&after),
                    false => Some(at(n + 1)),
                };
                if let Some((other_s, other)) = neighbour.filter(|(_, other)| other.is_finite()) {
                    let at_place = *value + (other - *value) * off_s / (time_s[n] - other_s);
                    // Numbers at the end of their range overflow.
                    *value = if at_place.is_finite() { at_place } else { *value };
                }
            }
        }
        if !self.read_once {
            for off_s in (0..rows).filter_map(is_off) {
                self.off = (self.off.0 + 1, self.off.1.max(off_s.abs()));
            }
        }
    }

    /// Gives missing outputs the value before.
    fn fill_missing(&mut self, block: &mut Block) {
        for (values, last) in block.outputs.iter_mut().zip(&mut self.last) {
            if !values.iter().fold(true, |all, value| all & value.is_finite()) {
                for (row, value) in values.iter_mut().enumerate() {
                    if value.is_finite() {
                        *last = *value;
                    } else {
                        block.missing.push(row as u32);
                        *value = *last;
                    }
                }
            }
            *last = values[values.len() - 1];
        }
        block.missing.sort_unstable();
        block.missing.dedup();
    }

    /// Writes down what only a whole pass tells.
    fn finish(&mut self) {
        if std::mem::replace(&mut self.read_once, true) {
            return;
        }
        if let (rows @ 1.., most_s) = self.off {
            self.survey.notes.push(format!(
                "{rows} rows are off their place in time by more than 10 % of {} s, by {} s at most: outputs are interpolated to uniform times, inputs held",
                tidy(self.survey.sample_period_s),
                tidy(most_s)
            ));
        }
        if let (Some(event), [only]) = (&self.survey.event_column, self.classes.names())
            && self.roles.event_was_named
        {
            self.survey.notes.push(format!("column `{event}` has one label only, `{only}`: there is one class"));
        }
    }
}

impl RecordSource for RecordStream {
    fn survey(&self) -> &Survey {
        &self.survey
    }

    fn next_block(&mut self) -> Result<Option<&Block>, RecordError> {
        loop {
            if let Some(block) = self.ready.pop_front() {
                self.block = block;
                return Ok(Some(&self.block));
            }
            let ahead = match self.ahead.take() {
                Some(rows) => Some(rows),
                None => self.files.next_rows()?,
            };
            let Some(raw) = ahead else {
                self.finish();
                return Ok(None);
            };
            if self.has_jitter {
                self.ahead = self.files.next_rows()?;
            }
            self.take(raw)?;
        }
    }

    fn restart(&mut self) -> Result<(), RecordError> {
        self.files.restart();
        self.sieve = Sieve::new(&self.files, &self.roles);
        (self.ahead, self.before) = (None, None);
        self.ready.clear();
        self.last.fill(f64::NAN);
        if !self.read_once {
            self.off = (0, 0.0);
        }
        Ok(())
    }

    fn classes(&self) -> &[String] {
        self.classes.names()
    }
}
