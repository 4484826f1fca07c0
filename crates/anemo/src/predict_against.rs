//! A recording that a prediction is compared with: what is taken of it, and whether it is of the
//! same experiment.

use std::path::Path;

use crate::output::Failure;
use diffusive::identify::record::{Selection, read_all};
use diffusive::model::pair_class::element;
use diffusive::model::{ALL, Model};
use diffusive::predict::arrival::at_set_point;
use diffusive::predict::closed::{PredictedElement, Prediction};
use host_sim::experiment::Experiment;
use recording::text::{count, four_digits as brief};
use recording::{self, ColumnValues, GAS_TEMPERATURE, RecordingReader, STATE};

/// A median further than this from the predicted one is another set-point's, K.
const OTHER_SET_POINT_K: f64 = 0.2;
/// Powers further below zero than this share of the greatest are no noise.
const NEGATIVE: f64 = 0.01;

/// Columns of a recording for the model's elements, over the experiment's ticks.
pub struct ComparedRecording {
    /// By input.
    pub power_w: Vec<Vec<f64>>,
    /// By output.
    temperature_c: Vec<Vec<f64>>,
    /// In what it differs from the experiment.
    pub notes: Vec<String>,
}

impl ComparedRecording {
    /// Reads a recording and refuses one that cannot be of this experiment.
    pub fn read(path: &Path, model: &Model, experiment: &Experiment) -> Result<Self, Failure> {
        let refuse = |sentence: String| Err(Failure::in_file(path, sentence));
        refuse_trip(path, experiment)?;
        let labelled = !(model.classes.len() == 1 && model.classes[0] == ALL);
        let selection = Selection {
            inputs: model.inputs.clone(),
            outputs: model.outputs.iter().map(|output| output.name.clone()).collect(),
            event: labelled.then(|| model.event_column.clone().unwrap_or_else(|| recording::EVENT.to_owned())),
            ..Selection::default()
        };
        let (survey, block, labels) = read_all(path, &selection).map_err(Failure::usage)?;
        let (own_s, its_s) = (experiment.sample_period_s, survey.sample_period_s);
        if (its_s / own_s - 1.0).abs() > 1e-3 {
            return refuse(format!(
                "is sampled every {} s and the experiment every {own_s} s: it is no recording of this experiment",
                recording::text::tidy(its_s)
            ));
        }
        let ticks = experiment.ticks as usize;
        if block.len() < ticks {
            return refuse(format!(
                "has {} rows, {} s, and does not cover the experiment of {} s: compare with a whole recording, or shorten `duration_s`",
                block.len(),
                brief(block.len() as f64 * own_s),
                experiment.duration_s()
            ));
        }
        if labelled {
            let differs = (0..ticks).find(|&tick| labels[block.class[tick] as usize] != experiment.event(tick as u32));
            if let Some(tick) = differs {
                return refuse(format!(
                    "has the event `{}` at {} s where the experiment has `{}`: it is no recording of this experiment",
                    labels[block.class[tick] as usize],
                    brief(tick as f64 * own_s),
                    experiment.event(tick as u32)
                ));
            }
        }
        let mut notes = Vec::new();
        if let Some(its) = &survey.conditions {
            let differences = experiment.conditions().differences(its, true);
            if !differences.is_empty() {
                notes.push(format!("was recorded {}: is it a recording of this experiment?", differences.join(", ")));
            }
        }
        let reader = RecordingReader::open(path).map_err(Failure::usage)?;
        if reader.names().iter().any(|name| name == GAS_TEMPERATURE) {
            notes.push(
                "was recorded in a gas of oscillating temperature: is it a recording of this experiment?".to_owned(),
            );
        }
        if let Some((_, text)) = reader.metadata().iter().find(|(key, _)| key == "experiment") {
            notes.extend(of_another_experiment(text, &experiment.source.text));
        }
        if block.len() > ticks {
            let left_s = (block.len() - ticks) as f64 * own_s;
            notes.push(format!("goes on for {} s after the experiment, which are left out", brief(left_s)));
        }
        let cut = |columns: Vec<Vec<f64>>| -> Vec<Vec<f64>> {
            columns.into_iter().map(|column| column[..ticks].to_vec()).collect()
        };
        let power_w = cut(block.inputs);
        for (name, power_w) in model.inputs.iter().zip(&power_w) {
            let greatest_w = power_w.iter().fold(0.0, |most: f64, w| most.max(w.abs()));
            if let Some(tick) = power_w.iter().position(|w| *w < -NEGATIVE * greatest_w) {
                return refuse(format!(
                    "column `{name}` is {} W at {} s: a heater cannot cool; is it another quantity, or of the other sign?",
                    brief(power_w[tick]),
                    brief(tick as f64 * own_s)
                ));
            }
        }
        Ok(Self { power_w, temperature_c: cut(block.outputs), notes })
    }

    /// Ticks at which the recorded loop of an element is at its set-point; with a remark where the
    /// prediction is there alone.
    pub fn arrived(&self, of: &PredictedElement, model: &Model, sample_period_s: f64) -> (Vec<bool>, Option<String>) {
        let Some(recorded_c) = self.temperature_of(of, model) else { return (vec![true; of.held.len()], None) };
        let at = at_set_point(of, recorded_c);
        let alone = of.held.iter().zip(&at).filter(|(held, at)| **held && !**at).count();
        let remark = (alone > 0).then(|| {
            format!(
                "{} is off its set-point for {} s in which the prediction holds it, and which do not count",
                of.name,
                brief(alone as f64 * sample_period_s)
            )
        });
        (at, remark)
    }

    /// A remark on an element that the recording holds at another temperature than the experiment
    /// does.
    pub fn of_another_set_point(&self, of: &PredictedElement, model: &Model) -> Option<String> {
        let recorded_c = self.temperature_of(of, model)?;
        let held = |values: &[f64]| {
            let mut values: Vec<f64> =
                values.iter().zip(&of.held).filter(|(_, held)| **held).map(|(value, _)| *value).collect();
            values.sort_by(f64::total_cmp);
            values.get(values.len() / 2).copied()
        };
        let (its_c, own_c) = (held(recorded_c)?, held(&of.sampled_c)?);
        (of.regulated && (its_c - own_c).abs() > OTHER_SET_POINT_K).then(|| {
            format!(
                "{} is at {its_c:.2} °C where the experiment holds {own_c:.2} °C: is it a recording of this experiment?",
                of.name
            )
        })
    }

    /// Its recorded temperature, °C, by tick.
    pub fn temperature_of(&self, of: &PredictedElement, model: &Model) -> Option<&[f64]> {
        let own = |output: &diffusive::model::ModelOutput| element(&output.name) == recording::in_columns(&of.name);
        self.temperature_c.get(model.outputs.iter().position(own)?).map(Vec::as_slice)
    }
}

/// A remark on powers that are a thousand times those that were predicted.
pub fn of_milliwatts(prediction: &Prediction, means_w: &[Option<(f64, f64)>]) -> Option<String> {
    let means = means_w.iter().zip(&prediction.elements);
    let (factor, name) =
        means.filter_map(|(means_w, of)| means_w.map(|(taken, own)| (taken / own, &of.name))).next()?;
    (300.0..3000.0).contains(&factor).then(|| {
        format!(
            "the powers of {name} are {} times the predicted ones: are they in milliwatts? Watts belong here",
            brief(factor)
        )
    })
}

/// Refuses a recording that has tripped while the experiment ran: what it took from then on no
/// prediction knows.
fn refuse_trip(path: &Path, experiment: &Experiment) -> Result<(), Failure> {
    let mut reader = RecordingReader::open(path).map_err(Failure::usage)?;
    let Some(state) = reader.names().iter().position(|name| name == STATE) else { return Ok(()) };
    reader.select(&[state]);
    let mut row = 0;
    while let Some(chunk) = reader.next_chunk().map_err(Failure::usage)? {
        let Some(ColumnValues::Words(states)) = chunk.first().map(|column| &column.values) else { return Ok(()) };
        for (from, _, word) in states.stretches() {
            let Some(why) = word.strip_prefix("tripped:") else { continue };
            if row + from >= experiment.ticks as usize {
                return Ok(());
            }
            let time_s = brief((row + from) as f64 * experiment.sample_period_s);
            let why = why.replacen(':', ", ", 1).replace('_', " ");
            let low = "its heaters are low from then on: shorten `duration_s` to less than that, or record again";
            return Err(Failure::in_file(path, format!("tripped at {time_s} s ({why}), and {low}")));
        }
        row += states.len();
    }
    Ok(())
}

/// Remarks on another title and on other winds of the experiment that a recording carries along.
fn of_another_experiment(its: &str, own: &str) -> Vec<String> {
    let (Ok(its), Ok(own)) = (its.parse::<toml::Table>(), own.parse::<toml::Table>()) else { return Vec::new() };
    let title =
        |table: &toml::Table| table.get("title").and_then(|title| title.as_str()).unwrap_or_default().to_owned();
    let mut notes = Vec::new();
    if title(&its) != title(&own) {
        notes.push(format!("was recorded of the experiment `{}`, and this is `{}`", title(&its), title(&own)));
    }
    let winds = |table: &toml::Table| -> Vec<toml::Table> {
        let all = table.get("wind").and_then(|winds| winds.as_array());
        all.into_iter().flatten().filter_map(|wind| wind.as_table().cloned()).collect()
    };
    let (its, own) = (winds(&its), winds(&own));
    let difference = its.iter().zip(&own).enumerate().find_map(|(at, (its, own))| {
        let key = its.keys().chain(own.keys()).find(|key| !same(its.get(*key), own.get(*key)))?;
        let word = |value: Option<&toml::Value>| value.map_or("none".to_owned(), toml::Value::to_string);
        Some(format!("`wind[{at}].{key}` is {} there, and {} here", word(its.get(key)), word(own.get(key))))
    });
    let count = (its.len() != own.len())
        .then(|| format!("it has {}, and this experiment {}", count(its.len(), "wind"), own.len()));
    notes.extend(difference.or(count).map(|what| format!("was recorded in other winds: {what}")));
    notes
}

/// 0 and 0.0 are the same.
fn same(a: Option<&toml::Value>, b: Option<&toml::Value>) -> bool {
    let number = |value: &toml::Value| value.as_float().or(value.as_integer().map(|integer| integer as f64));
    match (a.and_then(number), b.and_then(number)) {
        (Some(a), Some(b)) => a == b,
        _ => a == b,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_experiment_is_known_by_its_title_and_by_its_winds() {
        let calm = "title = 'a'\n[[wind]]\nlabel = 'w'\nspeed_m_s = 2\n";
        assert!(of_another_experiment(calm, &calm.replace("= 2", "= 2.0")).is_empty());
        let notes = of_another_experiment(calm, &calm.replace("= 2", "= 5").replace("'a'", "'b'"));
        assert_eq!(notes[0], "was recorded of the experiment `a`, and this is `b`");
        assert_eq!(notes[1], "was recorded in other winds: `wind[0].speed_m_s` is 2 there, and 5 here");
        let more = of_another_experiment(calm, &format!("{calm}[[wind]]\nlabel = 'x'\n"));
        assert_eq!(more, ["was recorded in other winds: it has 1 wind, and this experiment 2"]);
    }
}
