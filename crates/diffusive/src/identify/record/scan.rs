//! What is known of a record before its rows are handed out: one pass over it.

use super::clock::{NEGLIGIBLE, RunTimes};
use super::error::RecordError;
use super::files::RecordFiles;
use super::roles::Roles;
use super::sieve::{Sieve, Tally};
use super::swapped;
use recording::text::tidy;
use recording::{ColumnValues, ColumnWords};

/// The state in which our instrument keeps to its drives.
const RUNNING: &str = "running";
/// A record of which a greater part of the rows begins a segment has no period.
const MOST_GAPS: f64 = 0.25;

/// The grid on which the rows of a run stand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RunGrid {
    pub begin_s: f64,
    pub period_s: f64,
}

pub(super) struct Scan {
    pub rows: u64,
    pub segments: u64,
    pub longest: u64,
    pub period_s: f64,
    pub first_s: f64,
    pub last_s: f64,
    pub grids: Vec<RunGrid>,
    pub has_jitter: bool,
    pub notes: Vec<String>,
}

impl Scan {
    pub(super) fn of(files: &mut RecordFiles, roles: &Roles) -> Result<Self, RecordError> {
        let mut sieve = Sieve::new(files, roles);
        let mut runs: Vec<RunTimes> = Vec::new();
        let mut file_of_run: Vec<usize> = Vec::new();
        let mut stops = Vec::new();
        let mut ends_s: Option<(f64, f64)> = None;
        let mut notes = Vec::new();
        files.restart();
        while let Some(raw) = files.next_rows()? {
            let pieces = sieve.pieces(files, &raw)?;
            for piece in &pieces {
                if runs.len() <= piece.run {
                    runs.resize(piece.run + 1, RunTimes::default());
                    file_of_run.resize(piece.run + 1, raw.file);
                }
                let times = &raw.time_s[piece.rows.clone()];
                for (n, &time_s) in (piece.n..).zip(times) {
                    runs[piece.run].add(n, time_s);
                }
                let first_s = ends_s.map_or(times[0], |(first_s, _)| first_s);
                ends_s = Some((first_s, times[times.len() - 1]));
            }
            if let Some(state) = roles.state
                && let ColumnValues::Words(states) = &raw.columns[files.slot(state)]
            {
                count_stops(&mut stops, states, raw.first_row);
            }
            if let (true, Some(piece)) = (notes.is_empty() && raw.file == 0 && raw.first_row == 0, pieces.first()) {
                notes.extend(swapped::notes(files, roles, &raw, piece.rows.clone()));
            }
        }
        let (tally, has_jitter) = (&sieve.tally, sieve.clock().jitter() > NEGLIGIBLE);
        refuse(files, roles, tally)?;
        // A file keeps its own period, by which its rows stand where they do.
        let periods: Vec<Option<f64>> = (0..files.paths.len())
            .map(|file| {
                let own: Vec<RunTimes> =
                    runs.iter().zip(&file_of_run).filter(|(_, of)| **of == file).map(|(run, _)| *run).collect();
                RunTimes::period_s(&own, has_jitter)
            })
            .collect();
        let (Some(period_s), Some((first_s, last_s))) = (RunTimes::period_s(&runs, has_jitter), ends_s) else {
            return Err(RecordError::content(&files.paths[0], "has no two rows that follow each other in time"));
        };
        let grid = |(run, &file): (&RunTimes, &usize)| {
            let period_s = periods[file].unwrap_or(period_s);
            RunGrid { begin_s: run.begin_s(period_s, has_jitter), period_s }
        };
        let grids = runs.iter().zip(&file_of_run).map(grid).collect();
        for (state, first, rows) in &stops {
            notes.push(format!(
                "`state` is `{state}` in {rows} rows, first in row {first}: the heaters are off there, whatever their drives say"
            ));
        }
        notes.extend(remarks(files, roles, tally, period_s));
        let Tally { rows, segments, longest, .. } = *tally;
        Ok(Self { rows, segments, longest, period_s, first_s, last_s, grids, has_jitter, notes })
    }
}

/// Refuses a record of which too little is there.
fn refuse(files: &RecordFiles, roles: &Roles, tally: &Tally) -> Result<(), RecordError> {
    let refuse = |sentence: String| Err(RecordError::content(&files.paths[0], sentence));
    let all = tally.rows + tally.dropped;
    for (output, &missing) in roles.outputs.iter().zip(&tally.missing) {
        let name = &files.names()[*output];
        if 2 * missing > all {
            return refuse(format!(
                "column `{name}` is missing in {missing} of {all} rows: half of them belong there at least"
            ));
        }
    }
    if let (true, Some((file, row, name))) = (2 * tally.dropped > all, &tally.first_dropped) {
        let which = if tally.dropped == all {
            format!("column `{name}` has no number")
        } else {
            format!("{} of {all} rows lack a value, first `{name}` in row {row}", tally.dropped)
        };
        return Err(RecordError::content(&files.paths[*file], format!("{which}: name another column, or fill it")));
    }
    let gaps = tally.gaps + files.bridged_gaps;
    if gaps as f64 > (MOST_GAPS * (tally.rows - files.inserted.min(tally.rows)) as f64).max(1.0) {
        let sentence = format!(
            "its times are uneven: {} of {} rows come more than half a period late; resample the record to uniform times",
            gaps,
            tally.rows - files.inserted.min(tally.rows)
        );
        return Err(RecordError::uneven(&files.paths[0], sentence));
    }
    Ok(())
}

/// What was remarkable in the rows.
fn remarks(files: &RecordFiles, roles: &Roles, tally: &Tally, period_s: f64) -> Vec<String> {
    let mut notes = Vec::new();
    let several = |count: u64, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
    if tally.gaps > 0 {
        let (gaps, rows) = (several(tally.gaps, "gap"), several(tally.lost, "row"));
        notes.push(format!(
            "{gaps} in time, of {rows} of {} s: nothing is taken from one side to the other",
            tidy(period_s)
        ));
    }
    if files.inserted > 0 {
        let (rows, period_s) = (several(files.inserted, "row"), tidy(period_s));
        notes.push(format!(
            "{rows} missing in time, {period_s} s apart, in which inputs stand: they follow from those beside"
        ));
    }
    for (name, marked) in files.marked() {
        notes.push(format!("`{name}` is -9999 or 9.9e37 in {}: taken for missing", several(marked, "row")));
    }
    for (name, filled) in files.filled() {
        notes.push(format!("`{name}` is missing in {}, and follows from those beside", several(filled, "row")));
    }
    if let Some((file, row, name)) = &tally.first_dropped {
        let rows = several(tally.dropped, "row");
        let file = if *file == 0 { String::new() } else { format!(" of {}", files.paths[*file].display()) };
        notes.push(format!("{rows} left out, in which a value is missing, first `{name}` in row {row}{file}"));
    }
    if tally.segments > 1 {
        notes.push(format!("{} segments, each with offset and stored heat of its own", tally.segments));
    }
    for (output, &missing) in roles.outputs.iter().zip(&tally.missing).filter(|(_, missing)| **missing > 0) {
        notes.push(format!(
            "`{}` is missing in {}, which count by their inputs only",
            files.names()[*output],
            several(missing, "row")
        ));
    }
    notes
}

/// Rows of states other than running: which, first in what row, how many.
fn count_stops(stops: &mut Vec<(String, u64, u64)>, states: &ColumnWords, first_row: u64) {
    for (from, to, state) in states.stretches().filter(|(_, _, state)| *state != RUNNING) {
        let rows = (to - from) as u64;
        let few = stops.len() < 8;
        match stops.iter_mut().find(|(known, ..)| known == state) {
            Some((.., all)) => *all += rows,
            // Causes of trips are few; a foreign column of ever new words must not pile up.
            None if few => stops.push((state.to_owned(), first_row + from as u64 + 1, rows)),
            None => {}
        }
    }
}
