//! `anemo predict`: the power that a loop will take over an experiment, and against what it took.

use std::path::{Path, PathBuf};

use super::Failure;
use super::analysis_summary::brief;
use super::predict_against::{Taken, of_milliwatts};
use super::predict_summary::{Row, Said};
use crate::experiment::Experiment;
use crate::model::Model;
use crate::plot::Canvas;
use crate::plot::model::closed_loop;
use crate::predict::closed::{Prediction, Start, predict};
use crate::predict::compare::{decimate, fits};
use crate::predict::scenario::Scenario;
use crate::recording;

/// Window of the comparison in s, if none is given.
const WINDOW_S: f64 = 1.0;
/// And in ticks, at least.
const LEAST_TICKS: usize = 20;
/// Where the search for the decimator's longest window begins, in ticks.
const MOST_TICKS: usize = 1 << 12;

/// Predict the power that an experiment's loops will take, from a model that was identified open loop.
///
/// Two predictions are made: the limit of infinitely fast sampling, in which a held element takes the equivalent control, and the
/// same model under the one-bit rule at the experiment's sample period. What is compared is the second with the first or, with
/// --against, a recording with the first: both decimated alike, without edges of the wind and ways to the set-point.
#[derive(clap::Args)]
#[command(after_help = "\
Labels of the experiment's winds must be classes of the model. Elements that the model does not know are left out.
Elements that are heated as their drives say are not compared: nothing is predicted of them.

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
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
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

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let read: Vec<&Path> =
        [&arguments.model, &arguments.experiment].into_iter().chain(&arguments.against).map(PathBuf::as_path).collect();
    super::keep(&read, &[arguments.output.as_deref(), arguments.plot.as_deref()])?;
    let model = Model::read(&arguments.model).map_err(Failure::usage)?;
    let experiment = Experiment::read(&arguments.experiment)?;
    let refuse = |path: &Path, sentence: String| Failure::usage(format!("{}: {sentence}", path.display()));
    let (scenario, mut notes) =
        Scenario::of(&experiment, &model).map_err(|sentence| refuse(&arguments.experiment, sentence))?;
    notes.extend(model.doubt(None));
    let ratio = ratio(arguments.window, scenario.sample_period_s).map_err(Failure::usage)?;
    let canvas = arguments.plot.as_deref().map(Canvas::create).transpose().map_err(Failure::usage)?;
    let start = match arguments.from {
        From::Standby => Start::Standby,
        From::Rest => Start::Rest,
        From::End => Start::End,
    };
    let prediction = predict(&model, &scenario, start).map_err(|sentence| refuse(&arguments.model, sentence))?;
    let against = arguments.against.as_deref();
    let read = |path| Taken::read(path, &model, &experiment).map_err(|sentence| refuse(path, sentence));
    let taken = against.map(read).transpose()?;
    let mut of_recording = taken.as_ref().map_or(Vec::new(), |taken| taken.notes.clone());
    let (mut rows, mut means_w) = (Vec::new(), Vec::new());
    for (at, of) in prediction.elements.iter().enumerate() {
        let mut good = if of.regulated { of.held.clone() } else { vec![false; of.held.len()] };
        if let (Some(taken), true) = (&taken, of.regulated) {
            of_recording.extend(taken.of_another_set_point(of, &model));
            let (arrived, remark) = taken.arrived(of, &model, scenario.sample_period_s);
            good.iter_mut().zip(arrived).for_each(|(good, arrived)| *good &= arrived);
            of_recording.extend(remark);
        }
        let other = taken.as_ref().map_or(&of.sampled_w, |taken| &taken.power_w[at]);
        let decimated = decimate(&of.limit_w, other, &good, &prediction.class, ratio, scenario.sample_period_s)
            .map_err(Failure::usage)?;
        let compared = decimated.compare();
        if compared.is_none() && of.regulated {
            notes.push(format!(
                "{}: no window of {} s lies on the surface and in one wind, so that nothing can be compared",
                of.name,
                brief(ratio as f64 * scenario.sample_period_s)
            ));
        }
        means_w.push(compared.as_ref().map(|of| (of.mean_w, of.mean_w - of.bias_w)));
        rows.push(Row { of, decimated, compared });
    }
    of_recording.extend(of_milliwatts(&prediction, &means_w));
    if let Some(path) = against {
        notes.extend(of_recording.iter().map(|note| format!("{}: {note}", path.display())));
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
    let said = Said { prediction: &prediction, rows: &rows, ratio, against, notes: &notes };
    if arguments.json {
        return super::print_json(&said.as_json());
    }
    super::print(&said.summary())
}

fn ratio(window_s: Option<f64>, period_s: f64) -> Result<usize, String> {
    match window_s {
        None => Ok(((WINDOW_S / period_s).round() as usize).max(LEAST_TICKS)),
        Some(window_s) if window_s.is_finite() && window_s >= 2.0 * period_s => {
            let ratio = (window_s / period_s).round() as usize;
            let most = (1..=MOST_TICKS).rev().find(|most| fits(*most)).unwrap_or(1);
            if ratio <= most {
                return Ok(ratio);
            }
            let most_s = brief(most as f64 * period_s);
            Err(format!(
                "--window is {window_s} s: it must be {most_s} s at most, {most} sample periods of {period_s} s"
            ))
        }
        Some(window_s) => {
            Err(format!("--window is {window_s} s: it must be two sample periods of {period_s} s at least"))
        }
    }
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
