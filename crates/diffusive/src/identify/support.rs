//! Whether a record supports its model, and what it lacks if not.

use super::drift::DriftGiven;
use super::folds::FOLDS;
use super::options::IdentifyOptions;
use super::pass::Facts;
use super::record::{RecordError, Survey};
use super::residuals::Residuals;
use super::stuck::StuckRun;
use recording::stated_unit;
use recording::text::short;

use crate::model::certainty::noise_error;
use crate::model::{Class, Model, ModelOutput, rise_unit};

/// Column values beyond it have squares, and sums of squares, that are no longer numbers.
const GREATEST: f64 = 1e100;

/// An input that is not at its first value in fewer rows than this, counted as rows of its greatest
/// departure, excites too little.
const FEW_ROWS: f64 = 5.0;

/// Refuses what no model can come of.
pub fn refuse(
    survey: &Survey,
    facts: &Facts,
    classes: &[String],
    gated: bool,
    from_rest: bool,
) -> Result<(), RecordError> {
    let inputs = survey.inputs.iter().enumerate().map(|(input, name)| (name, facts.input_range(input)));
    let outputs = survey.outputs.iter().zip(&facts.outputs).map(|(name, of)| (name, [of.least, of.greatest]));
    for (name, [least, most]) in inputs.chain(outputs) {
        survey.refuse_if(
            most.abs().max(least.abs()) > GREATEST,
            format_args!("column `{name}` reaches from {least:e} to {most:e}: values beyond ±{GREATEST:e} cannot be worked with; correct them, or choose another unit"),
        )?;
    }
    for (input, name) in survey.inputs.iter().enumerate() {
        let ([value, _], rows) = (facts.input_range(input), facts.rows);
        // From rest, a constant is a step at the first row.
        survey.refuse_if(
            facts.input_sd(input) == 0.0 && !(from_rest && value != 0.0),
            format_args!("column `{name}` is {value} in all {rows} rows: an input that never changes excites nothing; record again with a changing input, or leave it out with --input{}", if value == 0.0 { "; if it was switched off at the first row, put a row with its power before it" } else { "; if it was switched on at the first row, say --initial-state rest" }),
        )?;
    }
    if gated {
        for (class, label) in classes.iter().enumerate() {
            let spreads = facts.classes.get(class).map_or(&[][..], Vec::as_slice);
            let column = survey.event_column.as_deref().unwrap_or("event");
            let rows = spreads.first().map_or(0, |input| input.count);
            survey.refuse_if(
                spreads.iter().all(|input| input.sd() == 0.0),
                format_args!("class `{label}` of column `{column}` has no excitation: no input changes in its {rows} rows; excite it there, or give these rows another label"),
            )?;
        }
    }
    Ok(())
}

/// What makes the record a poor one.
pub fn warnings(survey: &Survey, facts: &Facts) -> Vec<String> {
    let mut warnings = Vec::new();
    for (spread, name) in facts.outputs.iter().zip(&survey.outputs) {
        if spread.sd() == 0.0 {
            warnings.push(format!(
                "`{name}` is {} in all rows: the output does not answer; is it the right column, and is the sensor connected?",
                spread.least
            ));
        }
    }
    for (input, name) in survey.inputs.iter().enumerate() {
        let full = facts.full_rows(input);
        if full > 0.0 && full < FEW_ROWS {
            warnings.push(format!(
                "`{name}` leaves its first value for no more than {full:.1} rows' worth: what little heat that is tells next to nothing of slow rates; excite it all through the record"
            ));
        }
    }
    for i in 0..survey.inputs.len() {
        for j in 0..i {
            let correlation = facts.correlation(i, j);
            if correlation.abs() > 0.999 {
                warnings.push(format!(
                    "inputs `{}` and `{}` move together (correlation {correlation:.4}): their effects cannot be distinguished; drive them by different sequences, or name one of them with --input",
                    survey.inputs[j], survey.inputs[i]
                ));
            }
        }
    }
    warnings
}

/// Readings of an output that are not believed.
pub fn doubtful(name: &str, residuals: &Residuals) -> Vec<String> {
    let mut doubts = Vec::new();
    if let Some((rows, part)) = residuals.outliers() {
        let list: Vec<String> = rows.iter().map(u64::to_string).collect();
        let (rows, make) = if rows.len() == 1 { ("row", "alone makes") } else { ("rows", "alone make") };
        doubts.push(format!(
            "`{name}`: {rows} {} {make} {:.0} % of all squared residuals: a reading that went wrong? correct it, or cut the record there",
            list.join(", "),
            100.0 * part
        ));
    }
    if let Some(StuckRun { value, first_row, rows, moved, is_extreme }) = residuals.stuck() {
        let what = if is_extreme { "the reading is clipped" } else { "the sensor was stuck" };
        doubts.push(format!(
            "`{name}`: it is {value} in {rows} rows, first in row {first_row}, while the model moves by {}: {what}; leave these cells empty",
            short(moved, 2)
        ));
    }
    doubts
}

/// Refuses a model that explains nothing of any output; returns warnings of outputs that it does
/// not explain.
pub fn unexplained(model: &Model, survey: &Survey) -> Result<Vec<String>, RecordError> {
    let found: Vec<String> = model.outputs.iter().filter_map(|output| why_nothing(model, output)).collect();
    survey.refuse_if(found.len() == model.outputs.len() && !found.is_empty(), found.join("; "))?;
    Ok(found)
}

/// Standard deviations of a chance by which inputs explain something.
const BEYOND_CHANCE: f64 = 3.0;

/// Why a model explains nothing of an output, if so.
///
/// Of n white values, p parameters explain n R²/(1 − R²) = p ± √2p variances by chance. Where an
/// offset moves, the fit does not tell, but the steady gains.
fn why_nothing(model: &Model, output: &ModelOutput) -> Option<String> {
    let name = &output.name;
    let pairs = || model.pairs.iter().filter(|pair| pair.output == *name);
    let classes = || pairs().flat_map(|pair| pair.classes.values());
    let values = classes().flat_map(|class| class.r_k_per_w.iter().chain([&class.feed_through_k_per_w]));
    let parameters = values.filter(|value| **value != 0.0).count() as f64;
    let ask = "are these the right columns, and was the element heated?";
    if output.spread_rms == Some(0.0) {
        return Some(format!(
            "`{name}` is {} in all rows: the output does not answer; is it the right column, and is the sensor connected?",
            output.offset_c
        ));
    }
    if parameters == 0.0 {
        return Some(format!("`{name}`: no input explains any of it, and all resistances are zero: {ask}"));
    }
    if output.drift.is_some() {
        let is_known = |class: &Class| class.steady_gain_k_per_w.abs() > output.inflation() * noise_error(class);
        return (!classes().any(is_known)).then(|| {
            format!("`{name}`: no steady gain is greater than its standard error, and the offset moves: {ask}")
        });
    }
    let left = (1.0 - output.fit_percent / 100.0).powi(2);
    let (rows, inflation) = (model.provenance.rows as f64, output.inflation());
    let explained = rows * (1.0 - left) / left.max(f64::MIN_POSITIVE) / (inflation * inflation);
    let by_chance = parameters + BEYOND_CHANCE * (2.0 * parameters).sqrt();
    (explained <= by_chance).then(|| {
        format!(
            "`{name}`: the inputs explain {:.2} % of it, no more than chance does: {ask} A reading that went wrong hides the answer, too",
            output.fit_percent
        )
    })
}

/// Elements that their own power cools, beyond any chance. Only where columns state power and
/// temperature: other pairs may have any sign.
pub fn cooled(model: &Model) -> Vec<String> {
    let of = |(input, output): (&String, &ModelOutput)| {
        let stated = stated_unit(input)?.ends_with('W') && rise_unit(&output.name)? == "K";
        let pair = model.pairs.iter().find(|pair| pair.input == *input && pair.output == output.name)?;
        let falls =
            |class: &Class| class.steady_gain_k_per_w < -4.0 * output.inflation() * class.se_steady_gain_k_per_w;
        (stated && pair.classes.values().any(falls)).then(|| {
            format!(
                "`{}`: more of `{input}` makes it colder: is the sign of the power wrong, or are columns swapped?",
                output.name
            )
        })
    };
    model.inputs.iter().zip(&model.outputs).filter_map(of).collect()
}

/// Share of the output below which its inputs explain too little of it, %.
const LITTLE_PERCENT: f64 = 50.0;

/// Memory of residuals, as the factor by which it widens standard errors, that no noise has.
const MEMORY: f64 = 3.0;

/// Outputs that mostly follow something else than the inputs. White noise of any size is no such
/// thing: it averages out.
pub fn disturbed(model: &Model) -> Vec<String> {
    let is_disturbed = |output: &&ModelOutput| {
        let memory = output.whiteness.as_ref().map_or(1.0, |white| white.inflation);
        output.fit_percent < LITTLE_PERCENT && memory > MEMORY
    };
    let sentence = |output: &ModelOutput| {
        format!(
            "`{}`: the inputs explain {:.0} % of it, and the rest is no noise, but a drift, a disturbance or another input: is an input missing, or wrong?",
            output.name, output.fit_percent
        )
    };
    model.outputs.iter().filter(is_disturbed).map(sentence).collect()
}

/// Share of the output beyond which what its inputs leave moves no figure, %.
const ALL_BUT_PERCENT: f64 = 99.8;

/// Outputs whose residuals look as a drift leaves them, where none was searched.
pub fn undrifted(model: &Model, options: &IdentifyOptions) -> Vec<String> {
    let unsought = options.no_drift_for(model.classes.len()).filter(|_| options.drift == DriftGiven::Auto);
    let Some(reason) = unsought else { return Vec::new() };
    let sentence = |output: &ModelOutput| {
        format!(
            "`{}`: what is left of it remembers, as a room that moves leaves it, and widens standard errors {:.1} times; no drift is searched {reason}: identify without, or with a --drift of your own where that is possible, or record the temperature of the surroundings, for --ambient",
            output.name,
            output.inflation()
        )
    };
    let is_moved = |output: &&ModelOutput| output.inflation() > MEMORY && output.fit_percent < ALL_BUT_PERCENT;
    model.outputs.iter().filter(is_moved).map(sentence).collect()
}

/// Refuses as many unknowns as there are rows, or more.
pub fn solvable(survey: &Survey, unknowns: usize) -> Result<(), RecordError> {
    let rows = survey.rows;
    survey.refuse_if(
        unknowns as u64 >= rows,
        format_args!("has {rows} rows for {unknowns} unknowns: record longer, or ask for fewer with --order"),
    )
}

/// Most memory for the sums of all meshes together, bytes.
const MOST_BYTES: f64 = 4e9;

/// Refuses more unknowns than any machine should be asked for. `unknowns`: of every mesh that would
/// be tried.
pub fn affordable(survey: &Survey, unknowns: &[usize], classes: usize) -> Result<(), RecordError> {
    let bytes: f64 = unknowns.iter().map(|&count| 8.0 * FOLDS as f64 * (count as f64).powi(2)).sum();
    let unknowns = unknowns.iter().copied().max().unwrap_or(0);
    let (inputs, gigabytes) = (survey.inputs.len(), bytes / 1e9);
    survey.refuse_if(
        bytes > MOST_BYTES,
        format_args!("has {inputs} inputs and {classes} event classes, which make up to {unknowns} unknowns and {gigabytes:.0} GB of sums: join classes, name fewer inputs, or ask for fewer rates with --order"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::record::{RecordSource as _, RecordTable};

    #[test]
    fn unknowns_beyond_the_memory_of_machines_are_refused() {
        let inputs = (0..10).map(|input| (format!("u{input}"), vec![0.0, 1.0])).collect();
        let table = RecordTable::new(1.0, inputs, vec![("y".to_owned(), vec![0.0, 1.0])]).unwrap();
        assert!(affordable(table.survey(), &[500, 800], 60).is_ok());
        // 8 bytes, ten folds, 20 000²: 32 GB.
        let sentence = affordable(table.survey(), &[500, 20_000], 64).unwrap_err().to_string();
        assert!(sentence.contains(": has 10 inputs and 64 event classes, which make up to 20000 unknowns and 32 GB"));
    }
}
