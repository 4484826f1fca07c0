//! Missing values that follow from the rows around them.
//!
//! | column | is filled |
//! |---|---|
//! | input | in ten rows at most, where it is the same before and behind |
//! | gas | in a hundred rows at most, on a straight line |
//!
//! A row that is left out costs more than itself: behind it begins a segment whose offset and
//! stored heat are unknown. Both neighbours must have been read at once with what is missing
//! between them.

/// Consecutive rows that are filled at most.
const MOST_OF_INPUT: usize = 10;
const MOST_OF_GAS: usize = 100;

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
    fn surroundings_go_straight() {
        assert_eq!(
            bridged(&[20.0, NONE, NONE, 23.0, NONE], BridgedColumn::Gas),
            (2, vec![20.0, 21.0, 22.0, 23.0, -1.0])
        );
    }
}
