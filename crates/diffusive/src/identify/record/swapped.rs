//! Whether an input looks like what another column warms: columns that are swapped give a model as
//! well, of a body that knows what is to come.
//!
//! A heater is set: its power jumps from one row to the next, and is held. A body follows: its
//! temperature never jumps, and its slope changes after a jump of the power, in its direction.
//! Inputs and outputs are taken for swapped only where all of this is found the wrong way round.

use std::ops::Range;

use super::files::{RawRows, RecordFiles};
use super::roles::Roles;
use recording::ColumnValues;

/// Rows that are looked at.
const ROWS: usize = 8192;
/// A larger part of a column's range in one row is a jump, a smaller one no change.
const JUMP: f64 = 0.1;
const STILL: f64 = 1e-3;
/// What is set is held in at least this part of the rows, and what follows is not.
const HELD: f64 = 0.9;
/// Correlation of jumps with changes of slope.
const FOLLOWS: f64 = 0.5;
/// Rows before and after a jump by which slopes are taken.
const LONGEST: usize = 30;

/// A sentence for each input that follows an output, as far as the first rows tell.
pub(super) fn notes(files: &RecordFiles, roles: &Roles, raw: &RawRows, rows: Range<usize>) -> Vec<String> {
    let rows = rows.start..rows.end.min(rows.start + ROWS);
    let column = |column: usize| match &raw.columns[files.slot(column)] {
        ColumnValues::Numbers(values) => {
            values.get(rows.clone()).filter(|values| values.iter().all(|value| value.is_finite()))
        }
        ColumnValues::Words(_) => None,
    };
    let follows = |&(input, output): &(usize, usize)| {
        column(input).zip(column(output)).is_some_and(|(input, output)| is_warmed_by(input, output))
    };
    let pairs = roles.inputs.iter().flat_map(|&input| roles.outputs.iter().map(move |&output| (input, output)));
    let name = |column: usize| &files.names()[column];
    let sentence = |(input, output)| {
        format!(
            "the input `{}` looks like what the output `{}` warms, which jumps where the input only follows: swapped?",
            name(input),
            name(output)
        )
    };
    pairs.filter(follows).map(sentence).collect()
}

/// Whether `body` follows the jumps of `power`, and never jumps itself.
fn is_warmed_by(body: &[f64], power: &[f64]) -> bool {
    let (Some(body_range), Some(power_range)) = (range(body), range(power)) else { return false };
    let share = |values: &[f64], most: f64| {
        values.windows(2).filter(|pair| (pair[1] - pair[0]).abs() <= most).count() as f64 / (values.len() - 1) as f64
    };
    if share(body, JUMP * body_range) < 1.0
        || share(power, STILL * power_range) < HELD
        || share(body, STILL * body_range) >= HELD
    {
        return false;
    }
    let is_jump = |&row: &usize| (power[row] - power[row - 1]).abs() > JUMP * power_range;
    let jumps: Vec<usize> = (1..power.len()).filter(is_jump).collect();
    let (mut products, mut jump_squares, mut slope_squares, mut count) = (0.0, 0.0, 0.0, 0);
    for (at, &row) in jumps.iter().enumerate() {
        let before = if at == 0 { 0 } else { jumps[at - 1] };
        let after = jumps.get(at + 1).copied().unwrap_or(power.len());
        let width = LONGEST.min(row - before).min(after - row - 1);
        if width < 2 {
            continue;
        }
        let change = (body[row + width] - 2.0 * body[row] + body[row - width]) / width as f64;
        let jump = power[row] - power[row - 1];
        products += jump * change;
        jump_squares += jump * jump;
        slope_squares += change * change;
        count += 1;
    }
    count >= 2 && products > FOLLOWS * f64::sqrt(jump_squares * slope_squares)
}

/// The range of values, if they change.
fn range(values: &[f64]) -> Option<f64> {
    let (low, high) =
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &value| (low.min(value), high.max(value)));
    (high > low).then_some(high - low)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps of power, and a body with a time constant of 20 rows.
    fn heated() -> (Vec<f64>, Vec<f64>) {
        let power: Vec<f64> = (0..600).map(|n| f64::from([0, 1, 0, 2, 1, 0][n / 100])).collect();
        let mut warm = 0.0;
        let body = power.iter().map(|power| {
            warm += (power - warm) / 20.0;
            20.0 + warm
        });
        let body = body.collect();
        (power, body)
    }

    #[test]
    fn a_temperature_follows_its_power_and_not_the_other_way_round() {
        let (power, body) = heated();
        assert!(is_warmed_by(&body, &power));
        assert!(!is_warmed_by(&power, &body));
        assert!(!is_warmed_by(&power, &power));
        assert!(!is_warmed_by(&[1.0; 9], &[1.0; 9]));
    }

    #[test]
    fn a_thermometer_of_few_digits_is_no_power() {
        let (power, body) = heated();
        // A measured power, whose last digit moves, and a temperature in whole halves of a kelvin.
        let noisy: Vec<f64> =
            power.iter().enumerate().map(|(n, power)| power + 1e-2 * ((n * 37) % 11) as f64).collect();
        let coarse: Vec<f64> = body.iter().map(|body| (2.0 * body).round() / 2.0).collect();
        assert!(!is_warmed_by(&noisy, &coarse));
    }

    #[test]
    fn measured_records_are_in_the_order_that_they_are_given_in() {
        use super::super::{RecordSource as _, RecordStream, Selection};
        let (mut all, mut found) = (0, 0);
        for name in ["", "more"] {
            let Some(folder) = crate::shared_data::shared_data(name) else { return };
            for file in std::fs::read_dir(folder).unwrap().map(|file| file.unwrap().path()) {
                let of = |selection: &Selection| {
                    let stream = RecordStream::open(&file, selection).ok()?;
                    let notes = stream.survey().notes.iter().any(|note| note.ends_with("swapped?"));
                    Some((notes, stream.survey().inputs.clone(), stream.survey().outputs.clone()))
                };
                let Some((notes, inputs, outputs)) = of(&Selection::default()) else { continue };
                assert!(!notes, "{}", file.display());
                // A sensor's own heater has its number.
                let input =
                    inputs.iter().rfind(|input| outputs[0].starts_with('T') && input.get(1..2) == outputs[0].get(1..2));
                let swapped = Selection {
                    inputs: outputs,
                    outputs: vec![input.unwrap_or(&inputs[0]).clone()],
                    ..Selection::default()
                };
                all += 1;
                found += usize::from(of(&swapped).unwrap().0);
            }
        }
        println!("{found} of {all} swapped records are noticed");
        assert!(2 * found >= all);
    }
}
