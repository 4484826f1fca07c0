//! `anemo predict`: the power that a loop will take over an experiment, and against what it took.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde_json::json;

use super::Failure;
use super::analysis_summary::brief;
use crate::experiment::Experiment;
use crate::identify::record::{Selection, read_all};
use crate::model::export::part::element;
use crate::model::{ALL, Model};
use crate::plot::Canvas;
use crate::plot::model::closed_loop;
use crate::predict::closed::{Predicted, Prediction, Start, predict};
use crate::predict::compare::{Compared, Decimated, decimate};
use crate::predict::scenario::Scenario;
use crate::recording;

/// Window of the comparison in s, if none is given.
const WINDOW_S: f64 = 1.0;
/// And in ticks, at least.
const LEAST_TICKS: usize = 20;

/// Predict the power that an experiment's loops will take, from a model that was identified open loop.
///
/// Two predictions are made: the limit of infinitely fast sampling, in which a held element takes the equivalent control, and the
/// same model under the one-bit rule at the experiment's sample period. What is compared is the second with the first or, with
/// --against, a recording with the first: both decimated alike, without edges of the wind and ways to the set-point.
#[derive(clap::Args)]
#[command(after_help = "\
Labels of the experiment's winds must be classes of the model. Elements that the model does not know are left out.

Examples:
  anemo predict model.json experiments/winds.toml
  anemo predict model.json experiments/winds.toml --against winds.parquet --plot winds.svg
  anemo predict model.json experiments/winds.toml --from rest -o power.csv")]
pub struct Arguments {
    /// The model: a JSON file of `anemo identify`.
    model: PathBuf,
    /// The experiment: a TOML file.
    experiment: PathBuf,
    /// A recording of this experiment to compare with.
    #[arg(long, value_name = "RECORDING")]
    against: Option<PathBuf>,
    /// What the structure begins with.
    #[arg(long, value_enum, value_name = "STATE", default_value = "standby")]
    from: From,
    /// Window of the decimator, s: 1 s, or 20 sample periods if those are longer.
    #[arg(long, value_name = "S")]
    window: Option<f64>,
    /// Write predicted powers (`limit_w:`, `sampled_w:`) of every tick into this .csv or .parquet file.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Draw predicted and taken power into this .svg file.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum From {
    /// Every element has long been at its low level, as an instrument that stands by.
    Standby,
    /// Nothing was ever heated.
    Rest,
    /// As the record ended that the model was identified from.
    End,
}

/// One element's comparison.
struct Row<'a> {
    of: &'a Predicted,
    decimated: Decimated,
    compared: Option<Compared>,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let model = Model::read(&arguments.model).map_err(Failure::usage)?;
    let experiment = Experiment::read(&arguments.experiment)?;
    let refuse = |path: &Path, sentence: String| Failure::usage(format!("{}: {sentence}", path.display()));
    let (scenario, mut notes) =
        Scenario::of(&experiment, &model).map_err(|sentence| refuse(&arguments.experiment, sentence))?;
    let canvas = arguments.plot.as_deref().map(Canvas::create).transpose().map_err(Failure::usage)?;
    let start = match arguments.from {
        From::Standby => Start::Standby,
        From::Rest => Start::Rest,
        From::End => Start::End,
    };
    let prediction = predict(&model, &scenario, start).map_err(|sentence| refuse(&arguments.model, sentence))?;
    let taken = match &arguments.against {
        Some(path) => Some(taken(path, &model, &experiment).map_err(|sentence| refuse(path, sentence))?),
        None => None,
    };
    if let (Some(taken), Some(path)) = (&taken, &arguments.against) {
        notes.extend(taken.of_other_set_points(&prediction, &model).map(|note| format!("{}: {note}", path.display())));
    }
    let ratio = ratio(arguments.window, scenario.sample_period_s).map_err(Failure::usage)?;
    let mut rows = Vec::new();
    for (at, of) in prediction.elements.iter().enumerate() {
        let other = taken.as_ref().map_or(&of.sampled_w, |taken| &taken.power_w[at]);
        let good: Vec<bool> = if of.regulated { of.held.clone() } else { vec![true; of.held.len()] };
        let decimated = decimate(&of.limit_w, other, &good, &prediction.class, ratio, scenario.sample_period_s)
            .map_err(Failure::usage)?;
        let compared = decimated.compare();
        if compared.is_none() {
            notes.push(format!(
                "{}: no window of {} s lies on the surface and in one wind, so that nothing can be compared",
                of.name,
                brief(ratio as f64 * scenario.sample_period_s)
            ));
        }
        rows.push(Row { of, decimated, compared });
    }
    if let Some(path) = &arguments.output {
        write(path, &prediction)?;
    }
    if let Some(canvas) = canvas {
        let charts = rows.iter().map(|row| (row.of.name.as_str(), row.decimated.rows.as_slice()));
        let what = if taken.is_some() { "recorded" } else { "one-bit rule on the model" };
        let svg = closed_loop::prediction_page(&experiment.title, what, charts, &spans(&prediction, &model));
        canvas.write(&svg.map_err(Failure::work)?).map_err(Failure::work)?;
    }
    if arguments.json {
        return super::print_json(&as_json(arguments, &prediction, &rows, ratio, &notes));
    }
    super::print(&summary(arguments, &prediction, &rows, ratio, &notes))
}

fn ratio(window_s: Option<f64>, period_s: f64) -> Result<usize, String> {
    match window_s {
        None => Ok(((WINDOW_S / period_s).round() as usize).max(LEAST_TICKS)),
        Some(window_s) if window_s.is_finite() && window_s >= 2.0 * period_s => {
            Ok((window_s / period_s).round() as usize)
        }
        Some(window_s) => {
            Err(format!("--window is {window_s} s: it must be two sample periods of {period_s} s at least"))
        }
    }
}

/// What a recording has of the model's elements, over the experiment's ticks.
struct Taken {
    /// By input.
    power_w: Vec<Vec<f64>>,
    /// By output.
    temperature_c: Vec<Vec<f64>>,
}

/// A median further than this from the predicted one is another set-point's, K.
const OTHER_SET_POINT_K: f64 = 0.2;

impl Taken {
    /// A remark on every element that the recording holds at another temperature than the experiment does.
    fn of_other_set_points(&self, prediction: &Prediction, model: &Model) -> impl Iterator<Item = String> {
        let remark = move |of: &Predicted| {
            let own = |output: &crate::model::Output| element(&output.name) == of.name;
            let recorded_c = self.temperature_c.get(model.outputs.iter().position(own)?)?;
            let held = |values: &[f64]| {
                let mut values: Vec<f64> =
                    values.iter().zip(&of.held).filter(|(_, held)| **held).map(|(value, _)| *value).collect();
                values.sort_by(f64::total_cmp);
                values.get(values.len() / 2).copied()
            };
            let (its_c, own_c) = (held(recorded_c)?, held(&of.sampled_c)?);
            (of.regulated && (its_c - own_c).abs() > OTHER_SET_POINT_K).then(|| {
                format!("{} is at {its_c:.2} °C where the experiment holds {own_c:.2} °C: is it a recording of this experiment?", of.name)
            })
        };
        prediction.elements.iter().filter_map(remark).collect::<Vec<_>>().into_iter()
    }
}

/// Reads a recording and refuses one that cannot be of this experiment.
fn taken(path: &Path, model: &Model, experiment: &Experiment) -> Result<Taken, String> {
    let labelled = !(model.classes.len() == 1 && model.classes[0] == ALL);
    let selection = Selection {
        inputs: model.inputs.clone(),
        outputs: model.outputs.iter().map(|output| output.name.clone()).collect(),
        event: labelled.then(|| model.event_column.clone().unwrap_or_else(|| recording::EVENT.to_owned())),
        gas: None,
    };
    let tidy = |error: crate::identify::record::RecordError| {
        let words = error.to_string();
        words.strip_prefix(&format!("{}: ", path.display())).map_or(words.clone(), str::to_owned)
    };
    let (survey, block, labels) = read_all(path, &selection).map_err(tidy)?;
    let (own_s, its_s) = (experiment.sample_period_s, survey.sample_period_s);
    if (its_s / own_s - 1.0).abs() > 1e-3 {
        return Err(format!(
            "is sampled every {} s and the experiment every {own_s} s: it is no recording of this experiment",
            recording::tidy(its_s)
        ));
    }
    let ticks = experiment.ticks as usize;
    if block.len() < ticks {
        return Err(format!(
            "has {} rows, {} s, and does not cover the experiment of {} s: compare with a whole recording, or shorten `duration_s`",
            block.len(),
            brief(block.len() as f64 * own_s),
            experiment.duration_s()
        ));
    }
    if labelled {
        let differs = (0..ticks).find(|&tick| labels[block.class[tick] as usize] != experiment.event(tick as u32));
        if let Some(tick) = differs {
            return Err(format!(
                "has the event `{}` at {} s where the experiment has `{}`: it is no recording of this experiment",
                labels[block.class[tick] as usize],
                brief(tick as f64 * own_s),
                experiment.event(tick as u32)
            ));
        }
    }
    let cut = |columns: Vec<Vec<f64>>| columns.into_iter().map(|column| column[..ticks].to_vec()).collect();
    Ok(Taken { power_w: cut(block.inputs), temperature_c: cut(block.outputs) })
}

fn write(path: &Path, prediction: &Prediction) -> Result<(), Failure> {
    let names: Vec<(String, String)> = (prediction.elements.iter())
        .map(|of| (format!("limit_w:{}", of.name), format!("sampled_w:{}", of.name)))
        .collect();
    let columns: Vec<(&str, &[f64])> = (names.iter().zip(&prediction.elements))
        .flat_map(|((limit, sampled), of)| [(limit.as_str(), &of.limit_w[..]), (sampled.as_str(), &of.sampled_w[..])])
        .collect();
    recording::write_columns(path, prediction.sample_period_s, &columns, &Vec::new()).map_err(Failure::usage)
}

/// Winds as (from s, to s, class, label).
fn spans(prediction: &Prediction, model: &Model) -> Vec<(f64, f64, usize, String)> {
    let mut spans = Vec::new();
    let mut at = 0;
    for stretch in prediction.class.chunk_by(|a, b| a == b) {
        let time_s = |tick: usize| tick as f64 * prediction.sample_period_s;
        spans.push((time_s(at), time_s(at + stretch.len()), stretch[0], model.classes[stretch[0]].clone()));
        at += stretch.len();
    }
    spans
}

fn as_json(
    arguments: &Arguments,
    prediction: &Prediction,
    rows: &[Row<'_>],
    ratio: usize,
    notes: &[String],
) -> serde_json::Value {
    let first = rows.iter().find(|row| row.of.regulated).or(rows.first()).and_then(|row| row.compared.as_ref());
    let seconds =
        |(from, to): (usize, usize)| [from as f64 * prediction.sample_period_s, to as f64 * prediction.sample_period_s];
    let element = |row: &Row<'_>| {
        let compared = row.compared.as_ref();
        json!({
            "name": row.of.name,
            "regulated": row.of.regulated,
            "rms_w": compared.map(|of| of.rms_w),
            "bias_w": compared.map(|of| of.bias_w),
            "mean_w": compared.map(|of| of.mean_w),
            "n": compared.map_or(0, |of| of.count),
            "first_met_s": row.of.first_met_s,
            "saturated_s": row.of.saturated().into_iter().map(seconds).collect::<Vec<_>>(),
        })
    };
    json!({
        "rms_w": first.map(|of| of.rms_w),
        "bias_w": first.map(|of| of.bias_w),
        "mean_w": first.map(|of| of.mean_w),
        "window_s": ratio as f64 * prediction.sample_period_s,
        "ticks": prediction.class.len(),
        "against": arguments.against.as_ref().map(|path| path.display().to_string()),
        "elements": rows.iter().map(element).collect::<Vec<_>>(),
        "notes": notes,
    })
}

fn summary(arguments: &Arguments, prediction: &Prediction, rows: &[Row<'_>], ratio: usize, notes: &[String]) -> String {
    let period_s = prediction.sample_period_s;
    let mut text = format!(
        "{} ticks of {period_s} s, decimated by windows of {} s\n",
        prediction.class.len(),
        brief(ratio as f64 * period_s)
    );
    // Writing to a string cannot fail.
    for note in notes {
        let _ = writeln!(text, "  {note}");
    }
    let what =
        arguments.against.as_ref().map_or("one-bit rule on the model".to_owned(), |path| path.display().to_string());
    for row in rows {
        let _ = writeln!(text, "\n{}", row.of.name);
        if row.of.regulated {
            let _ = match row.of.first_met_s {
                Some(time_s) => writeln!(text, "  meets its set-point after {} s", brief(time_s)),
                None => writeln!(text, "  NEVER MEETS ITS SET-POINT"),
            };
        }
        for (from, to) in row.of.saturated() {
            let _ = writeln!(
                text,
                "  off its set-point's surface from {} to {} s",
                brief(from as f64 * period_s),
                brief(to as f64 * period_s)
            );
        }
        if let Some(of) = &row.compared {
            let _ = writeln!(
                text,
                "  {what} against the limit, {} outputs: {} W rms ({:.2} %), bias {} W ({:.3} %), mean {} W",
                of.count,
                brief(of.rms_w),
                100.0 * of.rms_w / of.mean_w,
                brief(of.bias_w),
                100.0 * of.bias_w / of.mean_w,
                brief(of.mean_w)
            );
        }
    }
    text
}
