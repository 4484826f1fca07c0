//! `anemo laws`: simple laws of response beside a diffusive model, by what they forecast.

use std::path::{Path, PathBuf};

use crate::columns::Columns;
use crate::output::Failure;
use crate::picture::PictureArguments;
use crate::progress::progress_bar;
use diffusive::identify::record::RecordStream;
use diffusive::laws::{FittedPart, compare};
use plot::laws::laws_figure;

/// Compare simple laws of response (exponentials, stretched exponential, square root of time) with
/// a diffusive model, by what they forecast.
///
/// All are fitted to the first part of a record of one input and one output, such as symbols ±1 and
/// the voltage shift of a dielectric that charges, or power and temperature of a heater. The rest
/// is forecast from its input, and no output of it is looked at. Each law has an unknown rest
/// value, and for the time before the record an unknown decay of its own shape. The diffusive model
/// is that of `anemo identify` without options. The picture shows the output, every law, and the
/// residuals of each.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo laws heater.csv --input power --output temperature
  anemo laws heater.csv heater-second-half.csv --until 900 --plot laws.svg
  anemo laws heater.csv --held-out 0.3 --json

Errors held out are compared in ten blocks: a law is `alike` if its squared
error is greater than the least by no more than two standard errors of the
difference.")]
pub struct Arguments {
    /// The record: .parquet or .csv files, each of which goes on where the one before ended.
    #[arg(required = true, value_name = "RECORD")]
    records: Vec<PathBuf>,
    #[command(flatten)]
    columns: Columns,
    /// Fit the rows before this time, s; the others are held out.
    #[arg(long, value_name = "S", allow_negative_numbers = true, conflicts_with = "held_out")]
    until: Option<f64>,
    /// Share of the rows that is held out, at the end; 0.5 if neither is given.
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    held_out: Option<f64>,
    #[command(flatten)]
    picture: PictureArguments,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

impl Arguments {
    fn part(&self) -> Result<FittedPart, Failure> {
        crate::output::finite(&[("--until", self.until)])?;
        match (self.until, self.held_out) {
            (Some(until_s), _) => Ok(FittedPart::UntilS(until_s)),
            (None, Some(share)) if share > 0.0 && share < 1.0 => Ok(FittedPart::HeldOut(share)),
            (None, Some(share)) => {
                Err(Failure::usage(format!("--held-out is {share}: a share above 0 and below 1 belongs there")))
            }
            (None, None) => Ok(FittedPart::default()),
        }
    }
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let part = arguments.part()?;
    let records: Vec<&Path> = arguments.records.iter().map(PathBuf::as_path).collect();
    crate::output::keep(&records, &[arguments.picture.path()])?;
    let canvas = arguments.picture.canvas()?;
    let selection = arguments.columns.selection();
    let mut stream = RecordStream::open_all(&arguments.records, &selection).map_err(Failure::usage)?;
    let report = compare(&mut stream, part, &mut progress_bar())?;
    if let Some(canvas) = canvas {
        canvas.draw(&laws_figure(&report)).map_err(Failure::work)?;
    }
    crate::output::print_report(&report, arguments.json)
}
