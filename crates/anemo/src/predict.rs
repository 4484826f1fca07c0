//! `anemo predict`: the power that a loop will take over an experiment, and against what it took;
//! for an experiment on a MEMS capacitor, its symbols and shifts.

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use crate::options::{PictureArguments, choice};
use crate::output::Failure;
use crate::predict_against::{ComparedRecording, of_milliwatts};
use crate::progress::on_interrupt;
use crate::record::RecordingOutputs;
use dielectric::experiment::DeviceExperiment;
use dielectric::predict::DevicePredictError;
use dielectric::run::{layout, metadata, phases_of};
use diffusive::model::Model;
use diffusive::predict::closed::{LoopStart, Prediction, predict};
use diffusive::predict::compare::{decimate, fits};
use diffusive::predict::prediction_report::{PredictedElementReport, PredictionReport};
use host_sim::experiment::Experiment;
use host_sim::run::RunError;
use plot::closed_loop;
use plot::closed_loop::PredictedCharts;
use recording::text::four_digits as brief;
use recording::{Recording, WriterOptions};

/// Window of the comparison in s, if none is given.
const WINDOW_S: f64 = 1.0;
/// And in ticks, at least.
const LEAST_TICKS: usize = 20;
/// Where the search for the decimator's longest window begins, in ticks.
const MOST_TICKS: usize = 1 << 12;

/// Predict the powers of an experiment's loops from a model.
///
/// The model was identified open loop.
///
/// `design` chooses a loop from requirements. `analyse` examines one given loop at its set-point.
/// `predict` predicts the powers of a whole experiment.
///
/// There are two predictions: the limit of infinitely fast sampling, in which the power of a
/// regulated element is the equivalent control, and the one-bit rule at the experiment's sample
/// period. The second or, with --against, a recording is compared with the first. Both are
/// decimated alike; changes of the wind and approaches to the set-point are left out. The picture
/// shows powers and temperatures.
///
/// An experiment on a MEMS capacitor (with a `device`) runs on the model under the very controller:
/// mean symbols and shifts, which set-points can be held, and where a loop of first order locks.
#[derive(clap::Args)]
#[command(after_help = "\
Labels of the experiment's winds must be classes of the model. Only regulated elements that the model \
knows are predicted.

Examples:
  anemo predict sectors.json experiments/held.toml
  anemo predict sectors.json experiments/held.toml --against held.parquet \\
      --plot held.svg
  anemo predict sectors.json experiments/held.toml --from rest -o power.csv
  anemo predict charge.json experiments/mems/hold.toml --plot hold.svg")]
pub struct Arguments {
    /// The model: a .json file of `anemo identify` or `anemo model`.
    model: PathBuf,
    /// The experiment: a TOML file.
    experiment: PathBuf,
    /// A recording of this experiment to compare with.
    #[arg(long, value_name = "RECORDING")]
    against: Option<PathBuf>,
    /// Initial state of the structure.
    #[arg(long, value_name = "STATE", default_value = "standby", value_parser = choice([
        ("standby", "Every element has long been at its low level, as in standby", LoopStart::Standby),
        ("rest", "Nothing was ever heated", LoopStart::Rest),
        ("end", "End of the record from which the model was identified", LoopStart::End),
    ]))]
    from: LoopStart,
    /// Window of the decimator, s, 2 to 1625 sample periods; by default 1 s, or 20 of them if
    /// longer.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    window: Option<f64>,
    /// Write predicted powers (`limit_w_…`, `sampled_w_…`) of every tick to this .csv or .parquet
    /// file.
    #[arg(short, long = "output-file", value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    picture: PictureArguments,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

fn predict_for_head(arguments: &Arguments) -> Result<(), Failure> {
    let model = Model::read(&arguments.model).map_err(Failure::usage)?;
    let experiment = Experiment::read(&arguments.experiment)?;
    let (scenario, mut notes) = host_sim::experiment::scenario(&experiment, &model)
        .map_err(|error| Failure::in_file(&arguments.experiment, error))?;
    notes.extend(model.support_warning(None));
    let ratio = ratio(arguments.window, scenario.sample_period_s)?;
    let canvas = arguments.picture.canvas()?;
    let prediction =
        predict(&model, &scenario, arguments.from).map_err(|error| Failure::in_file(&arguments.model, error))?;
    let against = arguments.against.as_deref();
    let taken = against.map(|path| ComparedRecording::read(path, &model, &experiment)).transpose()?;
    let mut of_recording = taken.as_ref().map_or(Vec::new(), |taken| taken.notes.clone());
    let (mut powers, mut elements, mut means_w) = (Vec::new(), Vec::new(), Vec::new());
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
        elements.push(PredictedElementReport::new(of, compared.as_ref(), scenario.sample_period_s));
        powers.push(decimated);
    }
    of_recording.extend(of_milliwatts(&prediction, &means_w));
    if let Some(path) = against {
        notes.extend(of_recording.iter().map(|note| format!("{}: {note}", path.display())));
    }
    if let Some(path) = &arguments.output {
        write(path, &prediction)?;
    }
    if let Some(canvas) = canvas {
        let what = if taken.is_some() { "recorded" } else { "one-bit rule" };
        // Only the temperature is predicted of elements that no loop holds.
        let any = prediction.elements.iter().any(|of| of.regulated);
        let elements = prediction.elements.iter().zip(&powers).filter(|(of, _)| of.regulated || !any);
        let charts = elements.map(|(of, decimated)| PredictedCharts {
            name: &of.name,
            powers: &decimated.rows,
            temperatures_c: [taken.as_ref().and_then(|taken| taken.temperature_of(of, &model)), Some(&of.sampled_c)],
            target_c: &of.target_c,
        });
        let charts: Vec<_> = charts.collect();
        let spans = spans(&prediction, &model);
        let figure = closed_loop::prediction_figure(&experiment.title, what, &charts, scenario.sample_period_s, &spans);
        canvas.draw(&figure).map_err(Failure::work)?;
    }
    let against = against.map(|path| path.display().to_string());
    let run = (prediction.class.len(), prediction.sample_period_s);
    let report = PredictionReport::new(elements, run, ratio, against, notes);
    crate::output::print_report(&report, arguments.json)
}

fn ratio(window_s: Option<f64>, period_s: f64) -> Result<usize, Failure> {
    match window_s {
        None => Ok(((WINDOW_S / period_s).round() as usize).max(LEAST_TICKS)),
        Some(window_s) if window_s.is_finite() && window_s >= 2.0 * period_s => {
            let ratio = (window_s / period_s).round() as usize;
            let most = (1..=MOST_TICKS).rev().find(|most| fits(*most)).unwrap_or(1);
            if ratio <= most {
                return Ok(ratio);
            }
            let most_s = brief(most as f64 * period_s);
            Err(Failure::usage(format!(
                "--window is {window_s} s: it must be {most_s} s at most, {most} sample periods of {period_s} s"
            )))
        }
        Some(window_s) => Err(Failure::usage(format!(
            "--window is {window_s} s: it must be two sample periods of {period_s} s at least"
        ))),
    }
}

fn write(path: &Path, prediction: &Prediction) -> Result<(), Failure> {
    let names: Vec<(String, String)> = (prediction.elements.iter())
        .map(|of| (recording::column_name("limit_w_", &of.name), recording::column_name("sampled_w_", &of.name)))
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

/// An experiment on a head, or on a device.
pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let of_device = crate::run_device::experiment_of(&arguments.experiment)?;
    let read: Vec<&Path> =
        [&arguments.model, &arguments.experiment].into_iter().chain(&arguments.against).map(PathBuf::as_path).collect();
    crate::output::keep(&read, &[arguments.output.as_deref(), arguments.picture.path()])?;
    match of_device {
        Some(experiment) => predict_of_device(arguments, &experiment),
        None => predict_for_head(arguments),
    }
}

fn predict_of_device(arguments: &Arguments, experiment: &DeviceExperiment) -> Result<(), Failure> {
    if arguments.window.is_some() {
        return Err(Failure::usage("--window: of a device the halves of its phases are compared; leave it out"));
    }
    if arguments.from != LoopStart::Standby {
        return Err(Failure::usage("--from: a device begins without charge; leave it out"));
    }
    let model = Model::read(&arguments.model).map_err(Failure::usage)?;
    let options = WriterOptions::default();
    let layout = layout(experiment, false);
    let known = metadata(experiment, "model");
    let mut rows = RecordingOutputs::create(arguments.output.as_deref(), &arguments.picture, layout, &known, &options)?;
    let interrupted = on_interrupt();
    let predicted = dielectric::predict::predict(&model, experiment, &mut |row| {
        rows.push(row)?;
        if interrupted.load(Ordering::Relaxed) { Err(RunError::Interrupted) } else { Ok(()) }
    });
    let mut report = predicted.map_err(|error| match error {
        DevicePredictError::Model(error) => Failure::in_file(&arguments.model, error),
        DevicePredictError::Run(error) => Failure::work(error),
    })?;
    rows.finish(&Vec::new())?;
    if let Some(path) = &arguments.against {
        let recording = Recording::read(path).map_err(Failure::usage)?;
        if recording.metadata("experiment").is_some_and(|text| text != experiment.source.text) {
            report.warnings.push(format!("{} is a recording of another experiment", path.display()));
        }
        report.against = Some(phases_of(experiment, &recording).map_err(Failure::usage)?);
    }
    crate::output::print_report(&report, arguments.json)
}
