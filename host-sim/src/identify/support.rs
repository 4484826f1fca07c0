//! Whether a record can carry the model that is asked of it, and what it lacks if not.

use super::pass::Facts;
use super::record::Survey;

/// Beyond it, squares and sums of squares are no longer numbers.
const GREATEST: f64 = 1e100;

/// Refuses what no model can come of.
pub fn refuse(survey: &Survey, facts: &Facts, classes: &[String], gated: bool, from_rest: bool) -> Result<(), String> {
    let columns = survey.inputs.iter().zip(&facts.input_range).chain(survey.outputs.iter().zip(&facts.output_range));
    for (name, [least, most]) in columns {
        if most.abs().max(least.abs()) > GREATEST {
            return Err(format!(
                "column `{name}` reaches from {least:e} to {most:e}: values beyond ±{GREATEST:e} cannot be worked with; correct them, or choose another unit"
            ));
        }
    }
    for (input, name) in survey.inputs.iter().enumerate() {
        let [value, _] = facts.input_range[input];
        // From rest, a constant is a step at the first row.
        if facts.input_sd(input) == 0.0 && !(from_rest && value != 0.0) {
            return Err(format!(
                "column `{name}` is {value} in all {} rows: an input that never changes excites nothing; record again with a changing input, or leave it out with --input",
                facts.rows
            ));
        }
    }
    if gated {
        for (class, label) in classes.iter().enumerate() {
            let excited = (0..survey.inputs.len()).any(|input| facts.class_input_sd(class, input) > 0.0);
            if !excited {
                return Err(format!(
                    "class `{label}` of column `{}` has no excitation: no input changes in its {} rows; excite it there, or give these rows another label",
                    survey.event_column.as_deref().unwrap_or("event"),
                    facts.class_rows.get(class).copied().unwrap_or(0)
                ));
            }
        }
    }
    Ok(())
}

/// What makes the record a poor one.
pub fn warnings(survey: &Survey, facts: &Facts) -> Vec<String> {
    let mut warnings = Vec::new();
    for (output, name) in survey.outputs.iter().enumerate() {
        if facts.output_sd(output) == 0.0 {
            let [value, _] = facts.output_range[output];
            warnings.push(format!(
                "`{name}` is {value} in all rows: the output does not answer; is it the right column, and is the sensor connected?"
            ));
        }
    }
    for i in 0..survey.inputs.len() {
        for j in 0..i {
            let correlation = facts.correlation(i, j);
            if correlation.abs() > 0.999 {
                warnings.push(format!(
                    "inputs `{}` and `{}` move together (correlation {correlation:.4}): their effects cannot be told apart; drive them by different sequences, or name one of them with --input",
                    survey.inputs[j], survey.inputs[i]
                ));
            }
        }
    }
    warnings
}
