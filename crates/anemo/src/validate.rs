//! `anemo validate`: a model against a record that it has not seen.

use std::path::PathBuf;

use crate::choice::choice;
use crate::columns::Columns;
use crate::fit_recorder::FitRecorder;
use crate::output::Failure;
use crate::picture::PictureArguments;
use diffusive::identify::record::{RecordSource as _, RecordStream, Selection};
use diffusive::identify::validate::{ValidationStart, validate};
use diffusive::model::{Model, ModelError};
use plot::model::validation_figure;

/// Predict a record with a model, and report how well.
///
/// The model runs over the record's inputs. The picture shows measured and predicted, residuals,
/// and the model.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  sed 's/seed = ./seed = 2/' experiments/prbs.toml > experiments/again.toml
  anemo run experiments/again.toml --on sim -o again.parquet
  anemo validate sector1.json again.parquet
  anemo validate heater.json heater-second-half.csv --start continue \\
      --plot heater.svg

A fit of 100 % is perfect, 0 % no better than the record's mean: 100 (1 − |y − ŷ| / |y − mean y|).")]
pub struct Arguments {
    /// The model: a .json file of `anemo identify` or `anemo model`.
    model: PathBuf,
    /// The record: a .parquet or .csv file.
    record: PathBuf,
    #[command(flatten)]
    columns: Columns,
    /// Initial state of the model.
    #[arg(long, default_value = "estimate", value_parser = choice([
        ("estimate", "Offset, and heat stored before the first row, estimated from the record", ValidationStart::Estimate),
        ("continue", "End of the identified record, for the rows that follow it; nothing is estimated", ValidationStart::Continue),
        ("rest", "All states zero, the model's own offset", ValidationStart::Rest),
    ]))]
    start: ValidationStart,
    #[command(flatten)]
    picture: PictureArguments,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

impl From<ModelError> for Failure {
    fn from(error: ModelError) -> Self {
        Self::usage(error)
    }
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let model = Model::read(&arguments.model)?;
    let asked = arguments.columns.selection();
    let or = |given: &[String], own: Vec<String>| if given.is_empty() { own } else { given.to_vec() };
    let selection = Selection {
        inputs: or(&asked.inputs, model.inputs.clone()),
        outputs: or(&asked.outputs, model.outputs.iter().map(|output| output.name.clone()).collect()),
        event: asked.event.clone().or_else(|| model.event_column.clone()),
        gas: model.gas_column().map(str::to_owned),
        ..asked
    };
    let mut stream = RecordStream::open(&arguments.record, &selection).map_err(Failure::usage)?;
    let canvas = arguments.picture.canvas()?;
    let mut fits = FitRecorder::new(canvas.is_some(), stream.survey());
    let validated = validate(&model, &mut stream, arguments.start, &mut |seen| fits.see(seen))?;
    if let Some(canvas) = canvas {
        let fits = fits.fits(validated.outputs.iter().map(|output| &output.whiteness));
        canvas.draw(&validation_figure(&model, &fits, &arguments.record, &arguments.model)).map_err(Failure::work)?;
    }
    crate::output::print_report(&validated, arguments.json)
}
