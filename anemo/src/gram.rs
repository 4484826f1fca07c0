//! `anemo gram`: sums of the parts of a record, from which `anemo identify` makes the model of the
//! whole.

use std::fmt::{self, Display, Formatter};
use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::identify::{is_gram, named};
use crate::model_options::ModelOptions;
use crate::output::Failure;
use crate::progress::progress_bar;
use diffusive::identify::parts::{GramError, GramFile, GramPlan, PartStarts, SummedRows, join_files};
use diffusive::identify::record::{RecordSource as _, RecordStream};

/// Sum the parts of a long record, on as many machines as there are, for `anemo identify`.
///
/// First a plan is made of all parts, in their order: it holds what is tried, and where each part
/// stands. Then each part is summed by itself, with the plan. Sums of neighbours may be joined.
/// From all sums `anemo identify` makes the model of the whole record with `--losses none`, to the
/// last digit. Parts are files that go on where the one before ended, recordings of the same head,
/// or both; gaps may be anywhere.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo gram heater.csv heater-second-half.csv -o heater.plan
  anemo gram heater.csv --plan heater.plan -o first.gram
  anemo gram heater-second-half.csv --plan heater.plan -o second.gram
  anemo gram first.gram second.gram -o both.gram
  anemo identify both.gram -o heater.json")]
pub struct Arguments {
    /// All parts of a record, or all recordings, for a plan; with --plan, one of them; or .gram
    /// files of neighbours, in any order, to be joined.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Sum a part of the record for which this plan was made.
    #[arg(long, value_name = "FILE")]
    plan: Option<PathBuf>,
    /// Write the plan to this .plan file, or the sums to this .gram file.
    #[arg(short, long, value_name = "FILE")]
    output_file: PathBuf,
    #[command(flatten)]
    model: ModelOptions,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

impl From<GramError> for Failure {
    fn from(error: GramError) -> Self {
        Self::usage(error)
    }
}

/// What was written.
#[derive(Serialize)]
struct GramReport<'a> {
    record: &'a Path,
    record_rows: u64,
    /// More than one where files do not go on where the one before ended, or have gaps.
    segments: usize,
    parts: usize,
    /// First row and number of rows of the sums; none of a plan.
    first_row: Option<u64>,
    rows: Option<u64>,
    written: &'a Path,
    bytes: u64,
}

impl Display for GramReport<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { record_rows, segments, parts, bytes, .. } = self;
        let segments = format!("{segments} segment{}", if *segments == 1 { "" } else { "s" });
        let (record, written) = (self.record.display(), self.written.display());
        match (self.first_row, self.rows) {
            (Some(first), Some(rows)) => {
                let to = first + rows;
                writeln!(f, "sums of rows {} to {to} of {record_rows} written to {written}, {bytes} bytes", first + 1)
            }
            _ => writeln!(
                f,
                "plan of {record_rows} rows in {segments} of {record} in {parts} parts written to {written}, {bytes} bytes"
            ),
        }
    }
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { files, plan, output_file, model, json } = arguments;
    let read: Vec<&Path> = files.iter().chain(plan).map(PathBuf::as_path).collect();
    crate::output::keep(&read, &[Some(output_file)])?;
    let is_join = files.iter().any(|path| is_gram(path));
    let is_plan = plan.is_none() && !is_join;
    if is_plan {
        crate::output::writable(output_file, "a plan", "plan")?;
    } else {
        crate::output::writable(output_file, "a file of sums", "gram")?;
        model.refuse_any("anemo gram")?;
    }
    let (plan, sums) = match plan {
        Some(_) if is_join => {
            return Err(Failure::usage("--plan is for a part of a record: leave it out to join sums"));
        }
        None if is_join => join_files(&named(files)?)?,
        None => {
            let (plan, starts) = planned(&named(files)?, model)?;
            let bytes = GramFile::write_plan(output_file, &plan, &starts).map_err(Failure::work)?;
            return report(&plan, None, (output_file, bytes), *json);
        }
        Some(path) => {
            let [part] = &files[..] else {
                return Err(Failure::usage("--plan sums one part at a time: name one record"));
            };
            let file = GramFile::open(path)?;
            let plan = file.plan.clone();
            let sums = plan.sum_file(&file.starts()?, part, &mut progress_bar())?;
            (plan, sums)
        }
    };
    let bytes = GramFile::write(output_file, &plan, &sums).map_err(Failure::work)?;
    report(&plan, Some(&sums), (output_file, bytes), *json)
}

fn report(
    plan: &GramPlan,
    sums: Option<&SummedRows>,
    (written, bytes): (&Path, u64),
    json: bool,
) -> Result<(), Failure> {
    let report = GramReport {
        record: plan.record(),
        record_rows: plan.rows(),
        segments: plan.segments(),
        parts: plan.parts.len(),
        first_row: sums.map(|sums| sums.first_row),
        rows: sums.map(|sums| sums.rows),
        written,
        bytes,
    };
    crate::output::print_report(&report, json)
}

fn planned(files: &[PathBuf], model: &ModelOptions) -> Result<(GramPlan, PartStarts), Failure> {
    let (selection, gas) = model.selection();
    let survey = RecordStream::open(&files[0], &selection).map_err(Failure::usage)?.survey().clone();
    let options = model.options(&survey, gas)?;
    Ok(GramPlan::of_files(files, &selection, &options, &mut progress_bar())?)
}
