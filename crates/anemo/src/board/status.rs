//! `anemo board status`: state of a board or of a log.

use std::path::PathBuf;

use crate::instrument::On;
use crate::log_files::LogStatus;
use crate::output::Failure;
use host_sim::instrument::serial::Serial;

/// Show the state of a board, or of a log.
///
/// A board reports state, lock, trips and the first of them, and counts of faults; a log reports
/// rows, state and last events.
///
/// It changes nothing: a board that runs goes on. Three trips in ten minutes lock a board until its
/// supply or its reset pin restarts it; both forget the counts, too.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo board status --on serial:/dev/ttyACM0
  anemo board status mast/")]
pub struct Arguments {
    /// The folder of a log.
    #[arg(required_unless_present = "on")]
    log: Option<PathBuf>,
    /// The board.
    #[arg(long, value_name = "serial:DEVICE", conflicts_with = "log")]
    on: Option<On>,
    /// Print one JSON object instead of the lines.
    #[arg(long)]
    json: bool,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(folder) = &arguments.log {
        let missing = |error| Failure::in_file(folder, format!("there is no status of a log: {error}"));
        return crate::output::print_report(&LogStatus::read(folder).map_err(missing)?, arguments.json);
    }
    let Some(On::Serial(device)) = &arguments.on else {
        return Err(Failure::usage(
            "--on: sim, qemu and silicon begin with the command and end with it; name a board at a port, as in serial:/dev/ttyACM0",
        ));
    };
    let status = Serial::open(device).and_then(|mut board| board.status()).map_err(Failure::work)?;
    crate::output::print_report(&status, arguments.json)
}
