//! `anemo benchmark`: the numbers that the instrument has to reach, measured on the simulated
//! sensors.

use std::path::PathBuf;

use crate::output::Failure;
use crate::progress::announce;
use studies::benchmark::wind::{self, BenchmarkReport, page};

/// Measure what the whole instrument has to reach, on the simulated sensors.
///
/// Both spheres are identified and calibrated, and their estimates judged in 500 new winds, in
/// steps, turbulence and an oscillating gas temperature: speed and direction, response, drift,
/// coherence. It takes some minutes on two cores.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo benchmark wind
  anemo benchmark wind -o out --heads out/heads --json")]
pub struct Arguments {
    /// What is measured.
    #[arg(value_name = "wind")]
    name: BenchmarkName,
    /// The folder for the page, which is written anew.
    #[arg(short, long, value_name = "FOLDER", default_value = "docs/results")]
    output: PathBuf,
    /// The folder with the experiments of the spheres.
    #[arg(long, value_name = "FOLDER", default_value = "experiments/wind")]
    experiments: PathBuf,
    /// Also write the calibrated heads into this folder.
    #[arg(long, value_name = "FOLDER")]
    heads: Option<PathBuf>,
    /// Print one JSON object instead of the tables.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum BenchmarkName {
    Wind,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let BenchmarkName::Wind = arguments.name;
    crate::output::is_experiments(&arguments.experiments)?;
    for folder in [Some(&arguments.output), arguments.heads.as_ref()].into_iter().flatten() {
        std::fs::create_dir_all(folder)
            .map_err(|error| Failure::in_file(folder, format!("cannot be made: {error}")))?;
    }
    let all = wind::both(&arguments.experiments, &announce)?;
    crate::output::write_text(&arguments.output.join("wind.md"), &page::page(&all).map_err(Failure::work)?)?;
    if let Some(folder) = &arguments.heads {
        for of in &all {
            crate::output::write_text(&folder.join(format!("{}-calibrated.toml", of.sphere.folder)), &of.text)?;
        }
    }
    crate::output::print_report(&BenchmarkReport(&all), arguments.json)
}
