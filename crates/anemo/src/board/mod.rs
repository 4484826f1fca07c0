//! `anemo board`: a sensor board's firmware, settings and state.

mod flash;
mod settings;
mod status;

use crate::output::Failure;

/// Program a board, show and change its settings, show its state.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    command: BoardCommand,
}

#[derive(clap::Subcommand)]
enum BoardCommand {
    Status(status::Arguments),
    Settings(settings::Arguments),
    Flash(flash::Arguments),
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    match &arguments.command {
        BoardCommand::Status(arguments) => status::execute(arguments),
        BoardCommand::Settings(arguments) => settings::execute(arguments),
        BoardCommand::Flash(arguments) => flash::execute(arguments),
    }
}
