//! `anemo check`: what an experiment would do, without doing it.

use std::path::PathBuf;

use crate::output::Failure;
use host_sim::run::CheckReport;

/// Read an experiment and its head, and report what would run.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  anemo check experiments/gusts.toml")]
pub struct Arguments {
    /// The experiment: a TOML file.
    experiment: PathBuf,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let (experiment, judgement) = crate::output::read_experiment(&arguments.experiment)?;
    crate::output::print_report(&CheckReport::new(&experiment, judgement), arguments.json)
}
