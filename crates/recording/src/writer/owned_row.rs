//! A row that outlives the one it was made from: on its way to a thread, or made of many.

use std::time::SystemTime;

use crate::column::RowCell;
use crate::row::RecordingRow;
use crate::utc::seconds_of;

pub(super) struct OwnedRow {
    pub time_s: f64,
    pub cells: Vec<OwnedCell>,
}

pub(super) enum OwnedCell {
    Number(f64),
    Text(Box<str>),
}

impl OwnedRow {
    pub fn of(row: &RecordingRow, arrived: Option<SystemTime>) -> Self {
        let owned = |cell: RowCell| match cell {
            RowCell::Number(number) => OwnedCell::Number(number),
            RowCell::Text(text) => OwnedCell::Text(text.into()),
        };
        Self { time_s: row.time_s, cells: stamped(row, arrived).map(owned).collect() }
    }

    pub fn cells(&self) -> impl Iterator<Item = RowCell<'_>> {
        self.cells.iter().map(|cell| match cell {
            OwnedCell::Number(number) => RowCell::Number(*number),
            OwnedCell::Text(text) => RowCell::Text(text),
        })
    }
}

/// The cells of a row, with the moment at which it arrived behind its time.
pub(super) fn stamped<'a>(row: &'a RecordingRow<'_>, arrived: Option<SystemTime>) -> impl Iterator<Item = RowCell<'a>> {
    let mut cells = row.cells();
    cells.next().into_iter().chain(arrived.map(|arrived| RowCell::Number(seconds_of(arrived)))).chain(cells)
}
