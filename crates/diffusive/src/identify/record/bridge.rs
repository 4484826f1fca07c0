//! Missing values that follow from the rows around them.
//!
//! | missing | is filled |
//! |---|---|
//! | input | in ten rows at most, where it is the same before and behind |
//! | gas | in a hundred rows at most, on a straight line |
//! | row | ten at most, where inputs and texts are the same before and behind; outputs stay missing |
//!
//! A number that instruments write for a missing one is missing: -9999 of loggers, 9.9e37 and
//! 9.91e37 of SCPI (SCPI-99, volume 1, 7.2.1).
//!
//! A row that is left out costs more than itself: behind it begins a segment whose offset and
//! stored heat are unknown. Both neighbours must have been read at once with what is missing
//! between them.

use super::clock::{NEGLIGIBLE, usual_step_s};
use super::files::RawRows;
use recording::{ColumnValues, ColumnWords};

/// Consecutive rows that are filled at most.
const MOST_OF_INPUT: usize = 10;
const MOST_OF_GAS: usize = 100;

/// Numbers that stand for a missing one.
const MARKER: f64 = -9999.0;
/// 9.9e37 for infinity and 9.91e37 for no number, rounded to f32 or not.
const SCPI_MARKERS: std::ops::RangeInclusive<f64> = 9.899e37..=9.92e37;
/// Relative distance from a marker within which a value beside it makes it a value.
const NEAR: f64 = 0.5;

/// Makes missing what a marker stands for, and returns how many values that were. A value that those
/// before or after it come near is none.
pub(super) fn unmark(values: &mut [f64]) -> u64 {
    let is_marker = |value: f64| value == MARKER || SCPI_MARKERS.contains(&value.abs());
    // Without a branch in the loop: this runs over every value of every record.
    if values.iter().fold(true, |none, value| none & !is_marker(*value)) {
        return 0;
    }
    let (mut marked, mut from) = (0, 0);
    while from < values.len() {
        let to = from + values[from..].iter().take_while(|value| is_marker(**value)).count();
        let is_near = |at: Option<&f64>| at.is_some_and(|beside| (beside / values[from] - 1.0).abs() < NEAR);
        if to > from && !is_near(from.checked_sub(1).and_then(|at| values.get(at))) && !is_near(values.get(to)) {
            values[from..to].fill(f64::NAN);
            marked += (to - from) as u64;
        }
        from = to + 1;
    }
    marked
}

/// Where rows are missing in time, and how many: the row before, in order.
fn missing_rows(rows: &RawRows, inputs: &[usize]) -> Vec<(usize, usize)> {
    let times = &rows.time_s;
    let mean_s = (times[times.len() - 1] - times[0]) / times.len() as f64;
    if times.windows(2).all(|pair| pair[1] - pair[0] < 1.5 * mean_s) {
        return Vec::new();
    }
    let Some(step_s) = usual_step_s(times) else { return Vec::new() };
    let is_same = |at: usize| {
        rows.columns.iter().enumerate().all(|(slot, column)| match column {
            ColumnValues::Numbers(values) => !inputs.contains(&slot) || values[at] == values[at + 1],
            ColumnValues::Words(words) => words.word(at) == words.word(at + 1),
        })
    };
    let of = |(at, pair): (usize, &[f64])| {
        let periods = (pair[1] - pair[0]) / step_s;
        let missing = periods.round() - 1.0;
        let follows = missing >= 1.0 && missing <= MOST_OF_INPUT as f64;
        (follows && (periods - periods.round()).abs() <= NEGLIGIBLE && is_same(at)).then_some((at, missing as usize))
    };
    times.windows(2).enumerate().filter_map(of).collect()
}

/// Inserts the rows that follow, and returns how many gaps they fill; `inputs` are slots of columns.
pub(super) fn insert_rows(rows: &mut RawRows, inputs: &[usize]) -> u64 {
    let missing = missing_rows(rows, inputs);
    if missing.is_empty() {
        return 0;
    }
    let mut gaps = missing.iter().peekable();
    // Each row by the one that it is, or follows.
    let (mut origins, mut time_s) = (Vec::new(), Vec::new());
    for (at, &now_s) in rows.time_s.iter().enumerate() {
        let count = gaps.next_if(|(before, _)| *before == at).map_or(0, |(_, count)| *count);
        for n in 0..=count {
            if n > 0 {
                rows.inserted.push(origins.len());
            }
            origins.push((at, n > 0));
            let step_s = rows.time_s.get(at + 1).map_or(0.0, |next_s| (next_s - now_s) / (count + 1) as f64);
            time_s.push(now_s + n as f64 * step_s);
        }
    }
    rows.time_s = time_s;
    for (slot, column) in rows.columns.iter_mut().enumerate() {
        match column {
            ColumnValues::Numbers(values) if !values.is_empty() => {
                let of = |&(at, is_new): &(usize, bool)| match is_new && !inputs.contains(&slot) {
                    true => f64::NAN,
                    false => values[at],
                };
                *values = origins.iter().map(of).collect();
            }
            ColumnValues::Numbers(_) => {}
            ColumnValues::Words(words) => {
                let mut all = ColumnWords::default();
                origins.iter().for_each(|&(at, _)| all.push(words.word(at)));
                *words = all;
            }
        }
    }
    missing.len() as u64
}

/// How a column's missing values follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum BridgedColumn {
    Input,
    Gas,
}

/// Fills what follows, and returns how many values that were.
pub(super) fn bridge(values: &mut [f64], column: BridgedColumn) -> u64 {
    // Without a branch in the loop: this runs over every value of every record.
    if values.iter().fold(true, |all, value| all & !value.is_nan()) {
        return 0;
    }
    let (mut filled, mut last) = (0, None::<usize>);
    for at in 0..values.len() {
        if values[at].is_nan() {
            continue;
        }
        if let Some(last) = last.replace(at).filter(|last| at - last > 1) {
            let (before, behind, missing) = (values[last], values[at], at - last - 1);
            let follows = match column {
                BridgedColumn::Input => missing <= MOST_OF_INPUT && before == behind,
                BridgedColumn::Gas => missing <= MOST_OF_GAS,
            };
            if follows {
                let step = (behind - before) / (missing + 1) as f64;
                (1..=missing).for_each(|n| values[last + n] = before + n as f64 * step);
                filled += missing as u64;
            }
        }
    }
    filled
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: f64 = f64::NAN;

    /// NaN as −1, which compares.
    fn bridged(values: &[f64], column: BridgedColumn) -> (u64, Vec<f64>) {
        let mut values = values.to_vec();
        let filled = bridge(&mut values, column);
        (filled, values.into_iter().map(|value| if value.is_nan() { -1.0 } else { value }).collect())
    }

    #[test]
    fn an_input_is_filled_where_it_stood() {
        let values = [NONE, 1.0, NONE, NONE, 1.0, NONE, 2.0, 2.0, NONE];
        assert_eq!(bridged(&values, BridgedColumn::Input), (2, vec![-1.0, 1.0, 1.0, 1.0, 1.0, -1.0, 2.0, 2.0, -1.0]));
        let mut long = vec![3.0; 14];
        long[1..12].fill(NONE);
        assert_eq!(bridged(&long, BridgedColumn::Input).0, 0);
        long[11] = 3.0;
        assert_eq!(bridged(&long, BridgedColumn::Input), (10, vec![3.0; 14]));
    }

    #[test]
    fn markers_of_loggers_and_instruments_are_missing() {
        let mut values = [20.0, -9999.0, 9.9e37, f64::from(9.91e37_f32), -9.9e37, 1e38, -9998.0, -9999.0, -10000.0];
        assert_eq!(unmark(&mut values), 4);
        assert_eq!(values.map(f64::is_nan), [false, true, true, true, true, false, false, false, false]);
    }

    #[test]
    fn surroundings_go_straight() {
        assert_eq!(
            bridged(&[20.0, NONE, NONE, 23.0, NONE], BridgedColumn::Gas),
            (2, vec![20.0, 21.0, 22.0, 23.0, -1.0])
        );
    }
}
