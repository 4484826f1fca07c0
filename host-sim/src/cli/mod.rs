//! The command line: one file a subcommand, and what they share.
//!
//! | exit code | meaning |
//! |---|---|
//! | 0 | done |
//! | 1 | what was asked for makes sense, but failed |
//! | 2 | the command, or a file that it names, is wrong; nothing was started |
//!
//! A summary goes to stdout, as text or, with `--json`, as one JSON object. Errors go to stderr, one sentence that begins with `anemo:`.

mod analyse;
mod analysis_summary;
mod attended;
mod board;
mod calibrate;
mod check;
mod design;
mod example;
mod export;
mod fits;
mod identify;
mod merge;
mod model_summary;
mod network;
mod network_summary;
mod plot;
mod predict;
mod predict_against;
mod predict_summary;
mod reduce;
mod run;
mod self_test;
mod settings;
mod study;
mod thesis;
mod validate;
mod wind;

use std::fmt::Display;
use std::io::{ErrorKind, Write as _};
use std::process::ExitCode;

use clap::{CommandFactory as _, Parser, Subcommand};

use crate::experiment::Experiment;
use crate::run::RunError;
use crate::toml_file::FileError;

/// Thermal sigma-delta anemometers: run experiments on a simulated or real sensor, identify thermal
/// models from what they recorded, and predict closed loops with them.
#[derive(Parser)]
#[command(
    name = "anemo",
    version,
    arg_required_else_help = true,
    after_help = "\
Examples:
  anemo check experiments/gusts.toml
  anemo run experiments/gusts.toml --on sim -o gusts.parquet --plot gusts.svg
  anemo run experiments/gusts.toml --on serial:/dev/ttyUSB0 -o gusts.csv
  anemo self-test experiments/gusts.toml --on serial:/dev/ttyUSB0
  anemo settings show --on serial:/dev/ttyUSB0
  anemo plot gusts.parquet -o gusts.svg
  anemo identify prbs.parquet --output sector1 --free-poles 4 -o model.json
  anemo validate model.json another-day.parquet
  anemo analyse model.json --element sector1 --target 15
  anemo network id-*.parquet -o network.json
  anemo calibrate tunnel*.parquet --network network.json -o head.toml
  anemo wind day.parquet --head head.toml --plot wind.svg"
)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Run(run::Arguments),
    SelfTest(self_test::Arguments),
    Settings(settings::Arguments),
    Check(check::Arguments),
    Design(design::Arguments),
    Identify(identify::Arguments),
    Merge(merge::Arguments),
    Network(network::Arguments),
    Calibrate(calibrate::Arguments),
    Wind(wind::Arguments),
    Validate(validate::Arguments),
    Plot(plot::Arguments),
    Example(example::Arguments),
    Export(export::Arguments),
    Reduce(reduce::Arguments),
    Analyse(analyse::Arguments),
    Predict(predict::Arguments),
    Thesis(thesis::Arguments),
    Study(study::Arguments),
}

/// Why the command ends, and with which exit code.
#[derive(Debug)]
struct Failure {
    code: u8,
    sentence: String,
}

impl Failure {
    /// The command or a file that it names is wrong.
    fn usage(error: impl Display) -> Self {
        Self { code: 2, sentence: error.to_string() }
    }

    /// The work itself failed.
    fn work(error: impl Display) -> Self {
        Self { code: 1, sentence: error.to_string() }
    }
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        Self::usage(error)
    }
}

impl From<RunError> for Failure {
    fn from(error: RunError) -> Self {
        match error {
            RunError::Refused(error) => Self::usage(error),
            RunError::Instrument(_) | RunError::Recording(_) | RunError::Interrupted { .. } => Self::work(error),
        }
    }
}

/// Runs the command of this process's arguments.
pub fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error)
            if error.use_stderr()
                && error.kind() != clap::error::ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand =>
        {
            let command = std::env::args().nth(1);
            complain(&one_sentence(&error, command.as_deref()));
            return ExitCode::from(2);
        }
        Err(error) => {
            // Help and version. That nobody reads them is no failure.
            let _ = error.print();
            return ExitCode::from(u8::from(error.use_stderr()) * 2);
        }
    };
    let outcome = match arguments.command {
        Command::Run(arguments) => run::execute(&arguments),
        Command::SelfTest(arguments) => self_test::execute(&arguments),
        Command::Settings(arguments) => settings::execute(&arguments),
        Command::Check(arguments) => check::execute(&arguments),
        Command::Design(arguments) => design::execute(&arguments),
        Command::Identify(arguments) => identify::execute(&arguments),
        Command::Merge(arguments) => merge::execute(&arguments),
        Command::Network(arguments) => network::execute(&arguments),
        Command::Calibrate(arguments) => calibrate::execute(&arguments),
        Command::Wind(arguments) => wind::execute(&arguments),
        Command::Validate(arguments) => validate::execute(&arguments),
        Command::Plot(arguments) => plot::execute(&arguments),
        Command::Example(arguments) => example::execute(&arguments),
        Command::Export(arguments) => export::execute(&arguments),
        Command::Reduce(arguments) => reduce::execute(&arguments),
        Command::Analyse(arguments) => analyse::execute(&arguments),
        Command::Predict(arguments) => predict::execute(&arguments),
        Command::Thesis(arguments) => thesis::execute(&arguments),
        Command::Study(arguments) => study::execute(&arguments),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            complain(&failure.sentence);
            ExitCode::from(failure.code)
        }
    }
}

fn complain(sentence: &str) {
    let _ = writeln!(std::io::stderr(), "anemo: {sentence}");
}

/// Prints a result. A reader that has gone away (`| head`) does not make the command fail.
fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::work(format!("the result cannot be printed: {error}")))
        }
        _ => Ok(()),
    }
}

fn print_json(value: &impl serde::Serialize) -> Result<(), Failure> {
    let json = serde_json::to_string(value).map_err(Failure::work)?;
    print(&format!("{json}\n"))
}

/// Writes a text file, in whole or not at all.
fn write_text(path: &std::path::Path, text: &str) -> Result<(), Failure> {
    let failed = |error: std::io::Error| Failure::work(format!("{}: cannot be written: {error}", path.display()));
    let (temporary, mut file) = crate::recording::Temporary::create(path).map_err(failed)?;
    file.write_all(text.as_bytes()).map_err(failed)?;
    drop(file);
    temporary.keep().map_err(failed)
}

/// Refuses a file that could only fail to be written once the work is done; `what` has a name with this extension.
fn writable(path: &std::path::Path, what: &str, extension: &str) -> Result<(), Failure> {
    if !path.extension().is_some_and(|own| own.eq_ignore_ascii_case(extension)) {
        return Err(Failure::usage(format!("{}: the name of {what} ends in .{extension}", path.display())));
    }
    // Dropped, it is gone again.
    crate::recording::Temporary::create(path)
        .map(drop)
        .map_err(|error| Failure::usage(format!("{}: cannot be written: {error}", path.display())))
}

/// Reads an experiment and lets a controller in this process judge it, so that nothing is started that would be refused.
fn read_experiment(path: &std::path::Path) -> Result<(Experiment, crate::run::Judgement), Failure> {
    let experiment = Experiment::read(path)?;
    let judgement = crate::run::rehearse(&experiment)?;
    Ok((experiment, judgement))
}

/// Refuses to write over a file that is read, by whatever path.
fn keep(read: &[&std::path::Path], written: &[Option<&std::path::Path>]) -> Result<(), Failure> {
    let whole: Vec<_> = read.iter().filter_map(|path| path.canonicalize().ok()).collect();
    let lost = written.iter().flatten().find(|path| path.canonicalize().is_ok_and(|path| whole.contains(&path)));
    lost.map_or(Ok(()), |path| {
        Err(Failure::usage(format!(
            "{}: is read by this command, and would be overwritten: name another file",
            path.display()
        )))
    })
}

/// An option's numbers, none of which may be infinite or no number.
fn finite(options: &[(&str, Option<f64>)]) -> Result<(), String> {
    match options.iter().find(|(_, value)| value.is_some_and(|value| !value.is_finite())) {
        Some((name, _)) => Err(format!("{name} must be a finite number")),
        None => Ok(()),
    }
}

/// Clap's message to a command without its usage block, in one line.
fn one_sentence(error: &clap::Error, command: Option<&str>) -> String {
    let text = error.to_string();
    let parts =
        text.lines().take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more information"));
    let parts: Vec<&str> = parts.map(str::trim).filter(|line| !line.is_empty()).collect();
    let joined = parts.join("; ").replace(":; ", ": ");
    let joined = joined.strip_prefix("error: ").unwrap_or(&joined);
    // The help of the subcommand that was meant, if there is such a one.
    let known = Arguments::command();
    let command = command.filter(|name| known.find_subcommand(name).is_some());
    let command = command.map_or(String::new(), |name| format!("{name} "));
    format!("{joined} (see `anemo {command}--help`)")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_well_formed() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn a_wrong_option_is_one_sentence_with_the_right_one() {
        let error =
            Arguments::try_parse_from(["anemo", "run", "a.toml", "--on", "sim", "--plto", "x.svg"]).err().unwrap();
        let sentence = one_sentence(&error, Some("run"));
        assert!(
            sentence.starts_with("unexpected argument '--plto' found; tip: a similar argument exists: '--plot'"),
            "{sentence}"
        );
        assert!(!sentence.contains('\n'));
        assert!(sentence.ends_with("(see `anemo run --help`)"), "{sentence}");
    }

    #[test]
    fn a_wrong_value_leads_to_the_help_of_its_command() {
        let sentence = |arguments: &[&str]| {
            one_sentence(&Arguments::try_parse_from(arguments).err().unwrap(), arguments.get(1).copied())
        };
        let wrong = sentence(&["anemo", "wind", "a.parquet", "--bandwidth", "fast"]);
        assert!(wrong.ends_with("(see `anemo wind --help`)"), "{wrong}");
        let missing = sentence(&["anemo", "calibrate"]);
        assert!(missing.ends_with("(see `anemo calibrate --help`)"), "{missing}");
        let unknown = sentence(&["anemo", "blow"]);
        assert!(unknown.ends_with("(see `anemo --help`)"), "{unknown}");
    }
}
