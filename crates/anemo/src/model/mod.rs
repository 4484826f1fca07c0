//! `anemo model`: work on model files that `anemo identify` has written.

mod export;
mod merge;
mod reduce;

use crate::output::Failure;

/// Reduce, merge and export models.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    command: ModelCommand,
}

#[derive(clap::Subcommand)]
enum ModelCommand {
    Reduce(reduce::Arguments),
    Merge(merge::Arguments),
    Export(export::Arguments),
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    match &arguments.command {
        ModelCommand::Reduce(arguments) => reduce::execute(arguments),
        ModelCommand::Merge(arguments) => merge::execute(arguments),
        ModelCommand::Export(arguments) => export::execute(arguments),
    }
}
