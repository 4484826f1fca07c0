//! `anemo status`: how a board fares.

use crate::board::On;
use crate::output::Failure;
use host_sim::instrument::serial::Serial;

/// How a board fares: state, lock, trips and the first of them, faults counted.
///
/// It changes nothing: a board that runs goes on. Three trips in ten minutes lock a board until its
/// supply or its reset pin restarts it; both forget the counts, too.
#[derive(clap::Args)]
#[command(after_help = "\
Example:
  anemo status --on serial:/dev/ttyACM0")]
pub struct Arguments {
    /// The board.
    #[arg(long, value_name = "serial:DEVICE")]
    on: On,
    /// Print one JSON object instead of the lines.
    #[arg(long)]
    json: bool,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let On::Serial(device) = &arguments.on else {
        return Err(Failure::usage(
            "--on: sim, qemu and silicon begin with the command and end with it; name a board at a port, as in serial:/dev/ttyACM0",
        ));
    };
    let status = Serial::open(device).and_then(|mut board| board.status()).map_err(Failure::work)?;
    crate::output::print_report(&status, arguments.json)
}
