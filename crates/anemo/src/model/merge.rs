//! `anemo model merge`: models that were identified one source at a time, as one.

use std::path::PathBuf;

use crate::output::Failure;
use diffusive::model::Model;
use diffusive::model::merge::{MergeReport, merge};

/// Merge models of different pairs of input and output into one.
///
/// The merged model adds up their responses.
///
/// For elements driven one after the other: identify each from its own record, with all outputs,
/// and merge. An output of several models has the offset and residuals of the first; `anemo
/// validate` estimates offsets anew.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo identify id-sector1.parquet --input sector1 \\
      --output sector1 sector2 -o heats1.json
  anemo identify id-sector2.parquet --input sector2 \\
      --output sector1 sector2 -o heats2.json
  anemo model merge heats1.json heats2.json -o both.json")]
pub struct Arguments {
    /// The models: two or more .json files.
    #[arg(required = true, num_args = 2.., value_name = "MODEL")]
    models: Vec<PathBuf>,
    /// Write the merged model to this .json file.
    #[arg(short, long = "output-file", value_name = "FILE")]
    output: PathBuf,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let read: Vec<_> = arguments.models.iter().map(PathBuf::as_path).collect();
    crate::output::keep(&read, &[Some(&arguments.output)])?;
    crate::output::writable(&arguments.output, "a model", "json")?;
    let mut models = Vec::with_capacity(arguments.models.len());
    for path in &arguments.models {
        models.push((path.display().to_string(), Model::read(path).map_err(Failure::usage)?));
    }
    let merged = merge(&models).map_err(Failure::usage)?;
    merged.write(&arguments.output).map_err(Failure::work)?;
    let report = MergeReport { model: &merged };
    crate::output::tell(&report)?;
    if arguments.json {
        return crate::output::print_json(&report);
    }
    crate::output::print(&format!("{report}\nmodel written to {}\n", arguments.output.display()))
}
