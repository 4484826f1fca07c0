//! The program `studies`: the experiments of the thesis, and the benchmark of instrument and
//! identification, on simulated sensors.
//!
//! Results go to stdout, as tables or, with `--json`, as one JSON object. Errors go to stderr, one
//! sentence that begins with `studies:`; the exit code is 1, or 2 if the command line is wrong.

mod command;

use std::process::ExitCode;

use clap::Parser as _;
use command::{benchmark, thesis};

/// Run the experiments of the thesis, or measure instrument and identification, on simulated
/// sensors.
#[derive(clap::Parser)]
#[command(name = "studies", version, arg_required_else_help = true, max_term_width = 80)]
enum StudiesCommand {
    Thesis(thesis::Arguments),
    Benchmark(benchmark::Arguments),
}

fn main() -> ExitCode {
    let done = match StudiesCommand::parse() {
        StudiesCommand::Thesis(arguments) => thesis::execute(&arguments),
        StudiesCommand::Benchmark(arguments) => benchmark::execute(&arguments),
    };
    let Err(error) = done else { return ExitCode::SUCCESS };
    eprintln!("studies: {error:#}");
    ExitCode::FAILURE
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory as _;

    #[test]
    fn the_command_line_is_well_formed_and_every_example_of_its_help_parses() {
        let mut command = StudiesCommand::command();
        command.build();
        command.clone().debug_assert();
        let mut examples = 0;
        for own in command.get_subcommands().filter_map(clap::Command::get_after_help) {
            for line in own.to_string().lines().filter_map(|line| line.strip_prefix("  ")) {
                examples += 1;
                let parsed = StudiesCommand::try_parse_from(line.split(' '));
                assert!(parsed.is_ok(), "{line}: {}", parsed.err().unwrap());
            }
        }
        assert_eq!(examples, 12);
    }
}
