//! Several models as one, by superposition: each identified from a record in which only its own
//! inputs were driven.
//!
//! ```text
//! y_j = offset_j + Σ_i (H_ij u_i)          every H_ij from the model that has the pair i → j
//! ```
//!
//! It holds for linear systems, hence for structure `symbol`; wind as feedback couples all
//! elements, and is identified from one record of all of them. What several models say of one
//! output, its offset and its residuals, is taken from the first: validation estimates the offset
//! again for every record. Rates are in rad/s, so sample periods may differ; dead times are counted
//! in the finest of them.

use std::collections::BTreeSet;

use super::ModelError;
use super::content::{Chosen, Model, ModelOutput, Pair, Provenance, Structure};

/// By how much a dead time may miss a whole number of samples, in samples.
const WHOLE: f64 = 1e-6;

/// A merged model. It prints as a summary, and serialises to the model itself.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[serde(transparent)]
pub struct MergeReport<'a> {
    /// The model.
    pub model: &'a Model,
}

impl std::fmt::Display for MergeReport<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let merged = self.model;
        for pair in &merged.pairs {
            for (label, class) in &pair.classes {
                let label = if merged.classes.len() > 1 { format!(", {label}") } else { String::new() };
                let (gain, se) = (class.steady_gain_k_per_w, class.se_steady_gain_k_per_w);
                let rates = pair.mesh_rad_s.len();
                writeln!(f, "{} → {}{label}: {rates} rates, steady gain {gain:.5} ± {se:.2}", pair.input, pair.output)?;
            }
        }
        for output in &merged.outputs {
            writeln!(f, "{}: offset {:.4}, of the first model that has it", output.name, output.offset_c)?;
        }
        merged.warnings.iter().try_for_each(|warning| writeln!(f, "\nwarning: {warning}"))
    }
}

/// Joins models of different pairs. Each comes with the name that a refusal calls it by.
///
/// # Errors
/// The models and what keeps them apart.
pub fn merge(models: &[(String, Model)]) -> Result<Model, ModelError> {
    let [(first_name, first), others @ ..] = models else {
        return Err(model_error!("there is nothing to merge: name at least two models"));
    };
    refuse_if!(others.is_empty(), model_error!("there is only {first_name}: name at least two models"));
    let finest = models.iter().min_by(|a, b| a.1.sample_period_s.total_cmp(&b.1.sample_period_s));
    let sample_period_s = finest.map_or(first.sample_period_s, |(_, model)| model.sample_period_s);
    let mut inputs: Vec<String> = Vec::new();
    let mut outputs: Vec<(ModelOutput, &str)> = Vec::new();
    let mut pairs: Vec<(Pair, &str)> = Vec::new();
    let mut reasons = vec![format!("merged from {} models: their answers are added up", models.len())];
    for (name, model) in models {
        alike(first_name, first, name, model)?;
        inputs.extend(model.inputs.iter().filter(|input| !inputs.contains(input)).cloned().collect::<Vec<_>>());
        for output in &model.outputs {
            match outputs.iter().find(|(known, _)| known.name == output.name) {
                None => outputs.push((output.clone(), name)),
                Some((known, of)) => reasons.push(format!(
                    "`{}`: offset {:.4} and residuals are those of {of}; {name} has offset {:.4}",
                    known.name, known.offset_c, output.offset_c
                )),
            }
        }
        for pair in &model.pairs {
            let Pair { input, output, dead_time_samples: samples, .. } = pair;
            if let Some((_, of)) = pairs.iter().find(|(known, _)| known.input == *input && known.output == *output) {
                return Err(model_error!(
                    "{of} and {name} both have the pair {input} → {output}, which can come from one record only: identify one of them without `{input}`"
                ));
            }
            let own_period_s = model.sample_period_s;
            let dead_time_samples = in_samples(pair, own_period_s, sample_period_s).map_err(|exact| {
                model_error!(
                    "{name}: pair {input} → {output} answers {samples} samples of {own_period_s} s late, which is {exact:.4} samples of the finest period, {sample_period_s} s: identify it again from a record sampled like the others"
                )
            })?;
            pairs.push((Pair { dead_time_samples, ..pair.clone() }, name));
        }
        reasons.extend(model.chosen.reasons.iter().map(|reason| format!("{name}: {reason}")));
    }
    let mut warnings: Vec<String> = Vec::new();
    for (name, model) in models {
        warnings.extend(model.warnings.iter().map(|warning| format!("{name}: {warning}")));
    }
    let outputs: Vec<ModelOutput> = outputs.into_iter().map(|(output, _)| output).collect();
    let pairs: Vec<Pair> = pairs.into_iter().map(|(pair, _)| pair).collect();
    Ok(Model {
        sample_period_s,
        offset_c: outputs[0].offset_c,
        residual_rms: outputs[0].residual_rms,
        fit_percent: outputs[0].fit_percent,
        forecast_rms: outputs[0].forecast_rms,
        supported: models.iter().all(|(_, model)| model.supported),
        warnings,
        advice: Vec::new(),
        chosen: Chosen {
            non_negative: pairs.iter().all(|pair| pair.non_negative),
            dead_time_samples: pairs[0].dead_time_samples,
            cross_validation: None,
            reasons,
            ..first.chosen.clone()
        },
        provenance: provenance(models, &inputs),
        end: None,
        inputs,
        outputs,
        pairs,
        ..first.clone()
    })
}

/// Refuses a model whose answers cannot be added to the first's.
fn alike(first_name: &str, first: &Model, name: &str, model: &Model) -> Result<(), ModelError> {
    if model.structure != Structure::Symbol {
        return Err(model_error!(
            "{name}: structure `conductance` cannot be merged, because its wind couples all elements: identify all of them from one record"
        ));
    }
    model
        .refuse_losses("cannot be merged, because what an element loses is in all that it heats: identify all of them from one record")
        .map_err(|error| error.about(name))?;
    let sorted = |model: &Model| BTreeSet::from_iter(model.classes.clone());
    if sorted(first) != sorted(model) {
        return Err(model_error!(
            "{first_name} was identified for the classes {}, {name} for {}: identify them in the same conditions",
            first.classes.join(", "),
            model.classes.join(", ")
        ));
    }
    if first.event_column != model.event_column {
        let column = |model: &Model| model.event_column.clone().unwrap_or_else(|| "none".to_owned());
        return Err(model_error!(
            "{first_name} has the event column {}, {name} has {}: give the column one name in all records",
            column(first),
            column(model)
        ));
    }
    Ok(())
}

/// A dead time in samples of another period; how many it would be, if they are not whole.
fn in_samples(pair: &Pair, own_period_s: f64, sample_period_s: f64) -> Result<usize, f64> {
    let exact = pair.dead_time_samples as f64 * own_period_s / sample_period_s;
    if (exact - exact.round()).abs() <= WHOLE { Ok(exact.round() as usize) } else { Err(exact) }
}

/// All records, one behind the other; the range of an input is the widest that any of them drove it
/// through.
fn provenance(models: &[(String, Model)], inputs: &[String]) -> Provenance {
    let of = |input: &String| {
        let ranges = models.iter().filter_map(|(_, model)| {
            let at = model.inputs.iter().position(|name| name == input)?;
            model.provenance.input_range.get(at).copied()
        });
        ranges.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]).unwrap_or([0.0, 1.0])
    };
    let all = || models.iter().map(|(_, model)| &model.provenance);
    Provenance {
        tool: format!("anemo {}", env!("CARGO_PKG_VERSION")),
        records: all().flat_map(|of| of.records.clone()).collect(),
        rows: all().map(|of| of.rows).sum(),
        duration_s: all().map(|of| of.duration_s).sum(),
        uneven_times: all().any(|of| of.uneven_times),
        input_range: inputs.iter().map(of).collect(),
        // Records in different gases have no conditions in common.
        conditions: all().map(|of| of.conditions.clone()).reduce(|a, b| a.filter(|a| b.as_ref() == Some(a))).flatten(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::forward::Forward;
    use crate::model::testing;

    /// `a` heats `y`, and a second model in which `b` does.
    fn two() -> [(String, Model); 2] {
        let a = testing::model(&[0.1, 2.0], &[30.0, 4.0]);
        let mut b = testing::model(&[0.05], &[7.0]);
        b.inputs = vec!["power_w_b".to_owned()];
        b.pairs[0].input = "power_w_b".to_owned();
        b.outputs[0].offset_c = 21.5;
        b.provenance.input_range = vec![[0.0, 0.3]];
        [("a.json".to_owned(), a), ("b.json".to_owned(), b)]
    }

    #[test]
    fn the_answer_to_both_inputs_is_the_sum_of_the_answers() {
        let models = two();
        let merged = merge(&models).unwrap();
        assert_eq!(merged.inputs, ["power_w_a", "power_w_b"]);
        assert_eq!((merged.outputs.len(), merged.pairs.len()), (1, 2));
        let mut forwards: Vec<Forward> =
            [&merged, &models[0].1, &models[1].1].map(|model| Forward::at_rest(model, 0.1)).into();
        for n in 0..500 {
            let (u, v) = (libm::sin(f64::from(n) * 0.07), f64::from(n % 50) * 0.01);
            let mut y = [[0.0]; 3];
            for ((forward, inputs), y) in forwards.iter_mut().zip([&[u, v][..], &[u], &[v]]).zip(&mut y) {
                forward.row(inputs, 0, 0.0, y);
            }
            // the offset once, from the first; rounding of some ten operations on 100 K
            assert!((y[0][0] - (y[1][0] + y[2][0] - 21.5)).abs() < 1e-12, "row {n}: {y:?}");
        }
    }

    #[test]
    fn a_merged_model_is_a_model_like_any_other_and_tells_where_it_came_from() {
        let models = two();
        let merged = merge(&models).unwrap();
        assert_eq!(Model::from_json(&merged.to_json()).unwrap(), merged);
        assert_eq!(merged.provenance.rows, 2 * models[0].1.provenance.rows);
        assert_eq!(merged.provenance.input_range[1], [0.0, 0.3]);
        assert_eq!(merged.offset_c, 20.0);
        assert!(merged.chosen.reasons.iter().any(|reason| reason.contains("b.json has offset 21.5")));
        assert!(merged.end.is_none());
    }

    #[test]
    fn dead_times_are_counted_in_the_finest_period_if_they_are_whole() {
        let mut models = two();
        models[1].1.sample_period_s = 0.25;
        models[1].1.pairs[0].dead_time_samples = 2;
        assert_eq!(merge(&models).unwrap().pairs[1].dead_time_samples, 5);
        models[1].1.pairs[0].dead_time_samples = 3;
        let sentence = merge(&models).unwrap_err().to_string();
        assert!(
            sentence.starts_with(
                "b.json: pair power_w_b → temperature_c_a answers 3 samples of 0.25 s late, which is 7.5000"
            ),
            "{sentence}"
        );
    }

    #[test]
    fn what_cannot_be_added_up_is_refused_by_name() {
        let refused = |change: fn(&mut [(String, Model); 2]), expected: &str| {
            let mut models = two();
            change(&mut models);
            let sentence = merge(&models).unwrap_err().to_string();
            assert!(sentence.contains(expected), "{sentence}");
        };
        refused(
            |models| models[1].1 = models[0].1.clone(),
            "a.json and b.json both have the pair power_w_a → temperature_c_a",
        );
        refused(|models| models[1].1.structure = Structure::Conductance, "b.json: structure `conductance`");
        refused(
            |models| testing::add_loss(&mut models[1].1, 1e-4),
            "b.json: has `losses` that grow with temperature, and cannot be merged",
        );
        refused(
            |models| models[1].1.classes = vec!["calm".to_owned(), "gust".to_owned()],
            "a.json was identified for the classes all, b.json for calm, gust",
        );
        refused(
            |models| models[1].1.event_column = Some("wind".to_owned()),
            "a.json has the event column none, b.json has wind",
        );
        assert!(merge(&two()[..1]).unwrap_err().to_string().contains("only a.json"));
    }
}
