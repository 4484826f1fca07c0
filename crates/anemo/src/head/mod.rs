//! `anemo head`: what is known of a head by its file, and what is identified of it.
//!
//! | file | what |
//! |---|---|
//! | [`new`] | a head's file and first experiments to begin with |
//! | [`check`] | what the file comes to: network, powers, winds, warnings |
//! | [`compare`] | a head beside a reference anemometer |
//! | `figure` | its picture |
//! | [`identify`] | the network of its elements in quiescent gas, from records |

pub mod check;
pub mod compare;
mod figure;
pub mod identify;
pub mod new;

use crate::output::Failure;

/// Begin a head, check it, identify it, compare it with a reference.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    command: HeadCommand,
}

#[derive(clap::Subcommand)]
enum HeadCommand {
    New(new::NewArguments),
    Check(check::CheckArguments),
    Compare(compare::CompareArguments),
    Identify(identify::IdentifyArguments),
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    match &arguments.command {
        HeadCommand::New(arguments) => new::begin(arguments),
        HeadCommand::Check(arguments) => check::check_head(arguments),
        HeadCommand::Compare(arguments) => compare::compare_with_reference(arguments),
        HeadCommand::Identify(arguments) => identify::identify_network(arguments),
    }
}
