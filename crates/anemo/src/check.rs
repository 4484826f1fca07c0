//! `anemo check`: what an experiment would do, without doing it.

use std::path::PathBuf;

use crate::instrument::On;
use crate::output::Failure;
use dielectric::experiment::DeviceCheck;
use host_sim::run::CheckReport;
use wire::BoardKind;

/// Read an experiment and its head, and report what would run.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  anemo check experiments/gusts.toml --on serial")]
pub struct Arguments {
    /// The experiment: a TOML file.
    experiment: PathBuf,
    /// Judge it by what this instrument grants: elements, currents, temperatures, sample period.
    #[arg(long, value_name = "sim|qemu|serial", default_value = "sim", value_parser = whose)]
    on: On,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(experiment) = crate::run_device::experiment_of(&arguments.experiment)? {
        if arguments.on.board() == Some(BoardKind::Sensor) {
            return Err(Failure::usage(crate::run_device::NO_CAPACITORS));
        }
        return crate::output::print_report(&DeviceCheck::new(&experiment), arguments.json);
    }
    let (experiment, judgement) = crate::output::read_experiment(&arguments.experiment, arguments.on.board())?;
    crate::output::note_corrections(&experiment.head);
    crate::output::print_report(&CheckReport::new(&experiment, judgement), arguments.json)
}

/// Whose limits hold; a serial port need not be named, as nothing is opened.
fn whose(text: &str) -> Result<On, Failure> {
    if text == "serial" { Ok(On::Serial(String::new())) } else { text.parse() }
}
