//! `anemo identify`: from a record to a diffusive model. Measured and predicted values of every row
//! are collected for a picture, for `validate`, too.

use std::path::{Path, PathBuf};

use crate::identify_page;
use crate::model_options::ModelOptions;
use crate::options::PictureArguments;
use crate::output::Failure;
use crate::progress::progress_bar;
use diffusive::identify::record::{Survey, open};
use diffusive::identify::report::IdentifyReport;
use diffusive::identify::{FitRow, identify};
use diffusive::model::Whiteness;
use plot::model::{FitSeries, figure};

/// Identify a thermal model from a record, with standard errors.
///
/// The model is diffusive: thermal resistances on a logarithmic grid of rates (diffusive mesh).
///
/// The record is a recording of `anemo run`, or any table that a logger writes with the time in its
/// first column. Gaps end a segment, across which nothing is taken. Options not given are chosen by
/// their evidence, or by block cross-validation, and the reasons printed. The picture shows
/// time-constant spectrum (diffusive symbol), fit, the offset's drift if it has one, residuals,
/// frequency response and structure function.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo identify prbs.parquet --output sector1 --free-poles 4 \\
      -o sector1.json --plot sector1.svg
  anemo identify prbs.parquet --output sector1 sector2 sector3 sector4 \\
      --free-poles 4 -o sectors.json
  anemo identify prbs.parquet --input sector1 sector2 \\
      --output sector1 sector2 --tie -o tied.json
  anemo identify heater.csv --input power --output temperature -o heater.json
  anemo identify heater.csv -o eight.json --order 8 --mesh 0.006:30 \\
      --ridge 1e-6
  anemo identify heater.csv heater-second-half.csv -o both.json \\
      --report both.html
  anemo identify three-winds.csv --event wind --non-negative all \\
      -o winds.json --plot winds.svg
  anemo identify three-winds.csv --event wind --structure conductance \\
      --non-negative all --gas-temperature 18.0 -o conductance.json
  anemo identify charge.parquet --input bit1_mems bit0_mems \\
      --output voltage_shift_v_mems --initial-state rest --drift none \\
      -o charge.json

A row holds the outputs at its time, and the inputs from then on.")]
pub struct Arguments {
    /// The record: .parquet or .csv files; several are segments of one record, or one segment where
    /// each goes on where the one before ended.
    #[arg(required = true, value_name = "RECORD")]
    records: Vec<PathBuf>,
    /// Write the model to this .json file.
    #[arg(short, long, value_name = "FILE")]
    output_file: Option<PathBuf>,
    #[command(flatten)]
    model: ModelOptions,
    #[command(flatten)]
    picture: PictureArguments,
    /// Write a report into this .html file: record, gains, fit, choices, warnings, what the next
    /// record should be, and the pictures. It needs no other file, and prints on A4.
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let records: Vec<&Path> = arguments.records.iter().map(PathBuf::as_path).collect();
    let written = [arguments.output_file.as_deref(), arguments.picture.path(), arguments.report.as_deref()];
    crate::output::keep(&records, &written)?;
    crate::output::writable(arguments.output_file.as_deref(), "a model", "json")?;
    crate::output::writable(arguments.report.as_deref(), "a report", "html")?;
    let (selection, gas) = arguments.model.selection();
    let mut stream = open(&named(&arguments.records)?, &selection).map_err(Failure::usage)?;
    let options = arguments.model.options(stream.survey(), gas)?;
    let canvas = arguments.picture.canvas()?;
    let mut fits = FitRecorder::new(canvas.is_some() || arguments.report.is_some(), stream.survey());
    let model = identify(&mut *stream, &options, &mut progress_bar(), &mut |seen| fits.see(seen))?;
    if let Some(path) = &arguments.output_file {
        model.write(path).map_err(Failure::work)?;
    }
    let fits = fits.fits(model.outputs.iter().map(|output| &output.whiteness));
    let notes = &stream.survey().notes;
    let report = IdentifyReport { model: &model, notes, written: arguments.output_file.as_deref() };
    if let Some(path) = &arguments.report {
        crate::output::write_text(path, &identify_page::page(&report, &figure(&model, &fits))?)?;
    }
    if let Some(canvas) = canvas {
        canvas.draw(&figure(&model, &fits)).map_err(Failure::work)?;
    }
    crate::output::print_report(&report, arguments.json)
}

/// The files that patterns name: no shell knows the names of objects.
fn named(files: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let named: Result<Vec<_>, _> = files.iter().map(|path| recording::named_by(path)).collect();
    Ok(named.map_err(Failure::usage)?.concat())
}

/// One series an output; none if nobody is going to draw them.
pub struct FitRecorder {
    series: Vec<FitSeries>,
    /// Series as they were before the first row.
    empty: Vec<FitSeries>,
    /// By output: the row that comes next.
    next: Vec<u64>,
    first_time_s: f64,
}

impl FitRecorder {
    /// For the outputs of a record, if they are going to be drawn.
    pub fn new(is_drawn: bool, survey: &Survey) -> Self {
        let unit = |name: &String| recording::stated_unit(name).unwrap_or_default().to_owned();
        let outputs = survey.outputs.iter().filter(|_| is_drawn);
        let empty: Vec<_> = outputs.map(|name| FitSeries::new(name.clone(), unit(name))).collect();
        Self { series: empty.clone(), next: vec![0; empty.len()], empty, first_time_s: survey.first_time_s }
    }

    pub fn see(&mut self, seen: &FitRow<'_>) {
        let time_s = self.first_time_s + seen.since_s;
        for (output, series) in self.series.iter_mut().enumerate() {
            // Outputs on other meshes have a reading of their own.
            if (seen.predicted[output] + seen.measured[output]).is_finite() {
                // The last ones count of rows that come again, by a better model.
                if seen.row < std::mem::replace(&mut self.next[output], seen.row + 1) {
                    *series = self.empty[output].clone();
                }
                let of = |values: &[f64]| values.get(output).copied().unwrap_or(0.0);
                let drift = (of(seen.drift), of(seen.drift_se));
                series.push(time_s, seen.measured[output], seen.predicted[output], drift, seen.class);
            }
        }
    }

    /// Fits of the rows that were seen, with the whiteness of the residuals of every output.
    pub fn fits<'w>(mut self, whiteness: impl IntoIterator<Item = &'w Option<Whiteness>>) -> Vec<FitSeries> {
        self.series.iter_mut().zip(whiteness).for_each(|(series, white)| series.whiteness.clone_from(white));
        self.series
    }
}
