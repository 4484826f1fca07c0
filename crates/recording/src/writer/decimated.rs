//! A recording of fewer rows beside the full one: of every interval the mean, the least and the
//! greatest of each column.
//!
//! | full | decimated |
//! |---|---|
//! | `time_s` | beginning of the interval |
//! | `utc` | of its first row |
//! | a number | its mean, under its name; `min_` and `max_` before it |
//! | `heater_<element>` | `duty_<element>`, the mean |
//! | `quality_flags` | every bit that was set |
//! | `event`, `state` | the last that was not empty |

use super::recorder::{OwnedCell, OwnedRow};
use crate::column::{ColumnKind, RowCell};
use crate::names::HEATER;

/// Duty of an element's heater, 0 to 1.
const DUTY: &str = "duty_";

/// Name of the folder: a point in it would make a file of it.
pub(super) fn folder(every_s: f64) -> String {
    if every_s.fract() == 0.0 { format!("every-{every_s}s") } else { format!("every-{}ms", every_s * 1e3) }
}

/// Names of the columns of a decimated recording.
pub(super) fn names(columns: &[(String, ColumnKind)]) -> Vec<String> {
    let of = |(name, kind): &(String, ColumnKind)| match kind {
        ColumnKind::Number => vec![name.clone(), format!("min_{name}"), format!("max_{name}")],
        ColumnKind::Bit => vec![name.replacen(HEATER, DUTY, 1)],
        _ => vec![name.clone()],
    };
    columns.iter().flat_map(of).collect()
}

/// Values of a column in the interval.
enum Gathered {
    First(f64),
    Extent { sum: f64, count: f64, least: f64, greatest: f64 },
    Mean { sum: f64, count: f64 },
    Bits(Option<u32>),
    Last(String),
}

impl Gathered {
    fn new(kind: ColumnKind) -> Self {
        match kind {
            ColumnKind::Wide | ColumnKind::Utc => Self::First(f64::NAN),
            ColumnKind::Number => {
                Self::Extent { sum: 0.0, count: 0.0, least: f64::INFINITY, greatest: f64::NEG_INFINITY }
            }
            ColumnKind::Bit => Self::Mean { sum: 0.0, count: 0.0 },
            ColumnKind::Flags => Self::Bits(None),
            ColumnKind::Text => Self::Last(String::new()),
        }
    }

    fn add(&mut self, cell: RowCell<'_>) {
        match (self, cell) {
            (Self::Last(last), RowCell::Text(text)) if !text.is_empty() => text.clone_into(last),
            (_, RowCell::Number(number)) if number.is_nan() => {}
            (Self::First(first), RowCell::Number(number)) if first.is_nan() => *first = number,
            (Self::Extent { sum, count, least, greatest }, RowCell::Number(number)) => {
                (*sum, *count) = (*sum + number, *count + 1.0);
                (*least, *greatest) = (least.min(number), greatest.max(number));
            }
            (Self::Mean { sum, count }, RowCell::Number(number)) => (*sum, *count) = (*sum + number, *count + 1.0),
            (Self::Bits(bits), RowCell::Number(number)) => *bits = Some(bits.unwrap_or(0) | number as u32),
            _ => {}
        }
    }

    fn cells(&self) -> Vec<OwnedCell> {
        let numbers = |numbers: &[f64]| numbers.iter().map(|number| OwnedCell::Number(*number)).collect();
        match self {
            Self::First(first) => numbers(&[*first]),
            Self::Extent { count: 0.0, .. } => numbers(&[f64::NAN; 3]),
            Self::Extent { sum, count, least, greatest } => numbers(&[sum / count, *least, *greatest]),
            Self::Mean { sum, count } => numbers(&[sum / count]),
            Self::Bits(bits) => numbers(&[bits.map_or(f64::NAN, f64::from)]),
            Self::Last(last) => vec![OwnedCell::Text(last.as_str().into())],
        }
    }
}

/// Gathers rows until their interval is over.
pub(super) struct RowDecimator {
    every_s: f64,
    kinds: Vec<ColumnKind>,
    /// Interval of the rows, if there are any.
    interval: Option<f64>,
    gathered: Vec<Gathered>,
}

impl RowDecimator {
    pub fn new(every_s: f64, columns: &[(String, ColumnKind)]) -> Self {
        let kinds = columns.iter().map(|(_, kind)| *kind).collect();
        Self { every_s, kinds, interval: None, gathered: Vec::new() }
    }

    /// Adds a row; returns the one of the interval before, if this row begins another.
    pub fn push<'a>(&mut self, time_s: f64, cells: impl Iterator<Item = RowCell<'a>>) -> Option<OwnedRow> {
        // A row's time may be rounded.
        let interval = (time_s / self.every_s + 1e-9).floor();
        let before = if self.interval == Some(interval) { None } else { self.take() };
        if self.interval.is_none() {
            self.interval = Some(interval);
            self.gathered = self.kinds.iter().map(|kind| Gathered::new(*kind)).collect();
        }
        self.gathered.iter_mut().zip(cells).for_each(|(gathered, cell)| gathered.add(cell));
        before
    }

    /// The row of what has been gathered.
    pub fn take(&mut self) -> Option<OwnedRow> {
        let time_s = self.interval.take()? * self.every_s;
        let mut cells: Vec<OwnedCell> = self.gathered.iter().flat_map(Gathered::cells).collect();
        cells[0] = OwnedCell::Number(time_s);
        Some(OwnedRow { time_s, cells })
    }
}
