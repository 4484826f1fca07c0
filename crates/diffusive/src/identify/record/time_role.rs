//! Which column holds the times, and in what unit.
//!
//! It is the one that the user names by its form, `time_s`, or the first; but where the first only
//! counts the rows (0, 1, 2 … or 1, 2, 3 …) and another one is called as times are, it is that one.

use super::columns::{FileColumns, shown};
use super::error::RecordError;
use super::source::Selection;
use super::times::{SINCE_1970_S, TimeUnit};
use recording::{ColumnValues, TIME, utc};

/// What the names of columns of times contain, or are.
const TIMES: [&str; 6] = ["time", "date", "zeit", "datum", "stamp", "utc"];
const SHORT_TIMES: [&str; 2] = ["t", "t_s"];
/// What people and programs call the column that counts the rows.
const COUNTS: [&str; 15] = [
    "index", "idx", "sample", "samples", "row", "rows", "no", "no.", "nr", "nr.", "#", "record", "scan", "number", "id",
];

#[derive(Debug, Clone, Default)]
pub(super) struct TimeRole {
    /// None if the rows are counted.
    pub column: Option<usize>,
    pub is_text: bool,
    pub unit: TimeUnit,
    /// Columns that only count the rows, or are not used for the time.
    pub left_out: Vec<usize>,
    pub notes: Vec<String>,
}

impl TimeRole {
    pub(super) fn choose(columns: &FileColumns, selection: &Selection) -> Result<Self, RecordError> {
        let mut role = Self::default();
        let first_counts = columns.position(TIME).is_none() && counts(columns, 0)?;
        if let Some(period_s) = selection.sample_period_s {
            let is_usable = period_s.is_finite() && period_s > 0.0;
            refuse_if!(!is_usable, columns.refuse("needs a sample period that is finite and above 0 s"));
            let is_left = |&column: &usize| is_called_time(&columns.names[column]) || column == 0 && first_counts;
            role.left_out = (0..columns.names.len()).filter(is_left).collect();
            if !role.left_out.is_empty() {
                let which = columns.list(&role.left_out);
                role.notes.push(format!("{which} left out: the rows are {period_s} s apart, as --sample-period says"));
            }
            return Ok(role);
        }
        let column = match columns.position(TIME) {
            Some(column) => column,
            None if is_called_time(&columns.names[0]) || !(first_counts || columns.text[0]) => 0,
            None => role.behind_a_count(columns, first_counts)?,
        };
        role.column = Some(column);
        role.read(columns, column, selection.time_unit)?;
        Ok(role)
    }

    /// The column of times behind a first one that holds none.
    fn behind_a_count(&mut self, columns: &FileColumns, first_counts: bool) -> Result<usize, RecordError> {
        if columns.text[0] && moment(columns, 0)?.is_some() {
            return Ok(0);
        }
        for column in (1..columns.names.len()).filter(|&column| is_called_time(&columns.names[column])) {
            let ascends = match columns.first_rows(column)? {
                ColumnValues::Numbers(times) => times.windows(2).all(|pair| pair[1] > pair[0] || pair[1].is_nan()),
                ColumnValues::Words(words) => words.iter().next().is_some_and(|word| utc::from_text(word).is_some()),
            };
            if ascends {
                let (what, name) = (columns.list(&[0]), &columns.names[column]);
                let why = if first_counts { "it counts the rows" } else { "text" };
                self.notes.push(format!("{what} left out: {why}; the time is in `{name}`"));
                self.left_out.push(0);
                return Ok(column);
            }
        }
        let is_called_count = COUNTS.iter().any(|name| columns.names[0].eq_ignore_ascii_case(name));
        refuse_if!(
            first_counts && is_called_count,
            columns.refuse(format!(
                "has no times: `{}` counts the rows; say how far they are apart by --sample-period SECONDS",
                columns.names[0]
            ))
        );
        Ok(0)
    }

    /// In what unit a column's times are written.
    fn read(&mut self, columns: &FileColumns, column: usize, given: Option<TimeUnit>) -> Result<(), RecordError> {
        let name = &columns.names[column];
        self.is_text = columns.text[column];
        if self.is_text {
            let Some(states_zone) = moment(columns, column)? else {
                let text = columns.first_rows(column)?;
                let text =
                    if let ColumnValues::Words(words) = &text { words.iter().next().unwrap_or_default() } else { "" };
                return Err(columns.refuse(format!(
                    "row 1, column `{name}`: `{}` stands where the time belongs, as a number or as 2026-12-24 18:00:00.5",
                    shown(text)
                )));
            };
            if !states_zone {
                self.notes.push(format!("the times in `{name}` state no zone and are taken for UTC"));
            }
            return Ok(());
        }
        let units = columns.units.get(column).and_then(|unit| TimeUnit::of_name(unit));
        let named = given.or_else(|| TimeUnit::of_column(name)).or(units);
        let ColumnValues::Numbers(times) = columns.first_rows(column)? else { return Ok(()) };
        let first = times.into_iter().find(|time| time.is_finite()).unwrap_or_default();
        self.unit = named.or_else(|| TimeUnit::of_size(first)).unwrap_or_default();
        let first_s = self.unit.seconds(first);
        if first_s >= SINCE_1970_S {
            let (unit, begin) = (self.unit.name(), utc::rfc3339(first_s));
            self.notes.push(format!("`{name}` is taken for {unit} since 1970: the record begins at {begin}"));
        } else if self.unit != TimeUnit::Second {
            self.notes.push(format!("the times in `{name}` are taken for {}", self.unit.name()));
        }
        Ok(())
    }
}

fn is_called_time(name: &str) -> bool {
    let name = name.to_lowercase();
    let plain = name.split(['(', '[', '/']).next().unwrap_or_default().trim();
    SHORT_TIMES.contains(&plain) || TIMES.iter().any(|part| plain.contains(part))
}

/// Whether a column counts the rows, from 0 or 1, as far as its first rows tell.
fn counts(columns: &FileColumns, column: usize) -> Result<bool, RecordError> {
    if columns.text[column] {
        return Ok(false);
    }
    let ColumnValues::Numbers(numbers) = columns.first_rows(column)? else { return Ok(false) };
    let Some(&first) = numbers.first().filter(|first| [0.0, 1.0].contains(*first)) else { return Ok(false) };
    Ok(numbers.iter().enumerate().all(|(row, &number)| number == first + row as f64))
}

/// Whether the first moment of a column of text states its zone; `None` if it is no moment.
fn moment(columns: &FileColumns, column: usize) -> Result<Option<bool>, RecordError> {
    let ColumnValues::Words(words) = columns.first_rows(column)? else { return Ok(None) };
    let first = words.iter().find(|word| !word.is_empty()).unwrap_or_default();
    Ok(utc::from_text(first).map(|(_, states_zone)| states_zone))
}
