//! `anemo validate`: a model against a record that it has not seen.

use std::path::PathBuf;

use super::Failure;
use super::fits::Fits;
use super::identify::Columns;
use crate::identify::record::{Selection, Source as _, Stream};
use crate::identify::validate::{Scored, Start, ValidateError, Validated, validate};
use crate::model::{Gas, Model, ModelError};

/// Predict a record with a model, and say how well.
///
/// The model runs over the record's inputs. The offset, and the heat that was stored before the first row, are estimated from the
/// record's outputs, unless the start says otherwise.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo validate model.json other-day.csv
  anemo validate model.json second-half.csv --start continue

A fit of 100 % is perfect, 0 % no better than the record's mean: 100 (1 − |y − ŷ| / |y − mean y|).")]
pub struct Arguments {
    /// The model: a .json file.
    model: PathBuf,
    /// The record: a .parquet or .csv file.
    record: PathBuf,
    #[command(flatten)]
    columns: Columns,
    /// What the model starts from.
    #[arg(long, value_enum, default_value = "estimate")]
    start: StartName,
    /// Draw measured and predicted, residuals, and the model into this .svg file.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum StartName {
    /// Offset and stored heat estimated from the record.
    Estimate,
    /// Where the identified record ended: nothing is taken from the outputs.
    Continue,
    /// All states zero, the model's own offset.
    Rest,
}

impl From<ModelError> for Failure {
    fn from(error: ModelError) -> Self {
        Self::usage(error)
    }
}

impl From<ValidateError> for Failure {
    fn from(error: ValidateError) -> Self {
        Self::work(error)
    }
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let model = Model::read(&arguments.model)?;
    let Columns { input, output, event } = &arguments.columns;
    let or = |given: &[String], own: Vec<String>| if given.is_empty() { own } else { given.to_vec() };
    let selection = Selection {
        inputs: or(input, model.inputs.clone()),
        outputs: or(output, model.outputs.iter().map(|output| output.name.clone()).collect()),
        event: event.clone().or_else(|| model.event_column.clone()),
        gas: model.wind.as_ref().and_then(|wind| match &wind.gas {
            Gas::Column(name) => Some(name.clone()),
            Gas::ConstantC(_) | Gas::EstimatedC(_) => None,
        }),
    };
    let mut stream = Stream::open(&arguments.record, &selection).map_err(Failure::usage)?;
    let start = match arguments.start {
        StartName::Estimate => Start::Estimate,
        StartName::Continue => Start::Continue,
        StartName::Rest => Start::Rest,
    };
    let mut fits = Fits::new(arguments.plot.as_deref(), stream.survey())?;
    let validated = validate(&model, &mut stream, start, &mut |seen| fits.see(seen))?;
    let whiteness: Vec<_> = validated.outputs.iter().map(|output| output.whiteness.clone()).collect();
    fits.draw(&model, &whiteness)?;
    if arguments.json {
        return super::print_json(&json(&validated));
    }
    super::print(&summary(&validated))
}

fn json(validated: &Validated) -> serde_json::Value {
    let of = |scored: &Scored| {
        serde_json::json!({
            "name": scored.name,
            "rmse": scored.rmse,
            "fit_percent": fit_percent(scored),
            "offset_c": scored.offset_c,
            "whiteness": scored.whiteness,
        })
    };
    let first = &validated.outputs[0];
    serde_json::json!({
        "rmse": first.rmse,
        "fit_percent": fit_percent(first),
        "offset_c": first.offset_c,
        "n": validated.rows,
        "start": start(validated.start),
        "warnings": validated.warnings,
        "outputs": validated.outputs.iter().map(of).collect::<Vec<_>>(),
    })
}

/// A constant output has none.
fn fit_percent(scored: &Scored) -> Option<f64> {
    scored.constant.is_none().then_some(scored.fit_percent)
}

fn start(start: Start) -> &'static str {
    match start {
        Start::Estimate => "estimate",
        Start::Continue => "continue",
        Start::Rest => "rest",
    }
}

fn summary(validated: &Validated) -> String {
    let from = match validated.start {
        Start::Estimate => "offset and stored heat estimated from the record",
        Start::Continue => "going on where the identified record ended",
        Start::Rest => "from rest, with the model's offset",
    };
    let mut text = format!("{} rows, {from}\n", validated.rows);
    for scored in &validated.outputs {
        let fit = fit_percent(scored).map_or("no fit".to_owned(), |percent| format!("fit {percent:.2} %"));
        text.push_str(&format!("{}: {fit}, rmse {:.4}, offset {:.4}\n", scored.name, scored.rmse, scored.offset_c));
    }
    for warning in &validated.warnings {
        text.push_str(&format!("\nwarning: {warning}\n"));
    }
    text
}
