//! The command `anemo`: one thin file a subcommand.
//!
//! A library, so that its help, its completions, its man pages and its reference page are all
//! written from the one definition of its command line ([`command`]); the binary calls [`main`],
//! and other programs call commands [`in_process`].
//!
//! | exit code | meaning |
//! |---|---|
//! | 0 | done |
//! | 1 | what was asked for makes sense, but failed |
//! | 2 | the command, or a file that it names, is wrong; nothing was started |
//! | 3 | a run or a log that tripped; what was recorded is kept |
//! | 4 | a run or a log that ended early; what there is is kept |
//!
//! A summary goes to stdout, as text or, with `--json`, as one JSON object. Errors go to stderr,
//! one sentence that begins with `anemo:`.

mod analyse;
#[cfg(feature = "studies")]
mod benchmark;
mod board;
mod calibrate;
mod check;
mod choice;
mod columns;
mod combine;
mod convert;
mod design;
mod example;
mod export;
mod feeding;
mod fit_recorder;
mod gram;
mod head;
mod identify;
mod identify_page;
pub mod in_process;
mod laws;
mod live_host;
mod live_table;
mod log;
mod log_files;
mod log_host;
mod log_source;
mod mark;

mod live;
mod merge;
mod meteorology;
mod model_options;
mod mounting_options;
mod output;
mod pace;
mod picture;
mod plot;
mod predict;
mod predict_against;
mod predict_device;
mod program;
mod progress;
mod publish_options;
mod recorded;
mod recover;
mod reduce;
mod replay;
mod run;
mod run_device;
mod self_test;
mod service;
mod settings;
mod status;
#[cfg(feature = "studies")]
mod thesis;
mod validate;
mod wind;

use std::process::ExitCode;

use clap::{CommandFactory as _, Parser, Subcommand};

/// Width of help, also where a terminal is wider.
const MOST_COLUMNS: usize = 80;

/// Thermal sigma-delta anemometers: run experiments on a simulated or real sensor, identify thermal
/// models from the recordings, and predict closed loops with these models.
#[derive(Parser)]
#[command(
    name = "anemo",
    version,
    arg_required_else_help = true,
    max_term_width = MOST_COLUMNS,
    after_help = "\
Examples:
  anemo check experiments/gusts.toml
  anemo run experiments/gusts.toml --on sim -o gusts.parquet --plot gusts.svg
  anemo plot gusts.parquet -o gusts.svg
  anemo run experiments/prbs.toml --on sim -o prbs.parquet
  anemo identify prbs.parquet --output sector1 --free-poles 4 -o sector1.json
  anemo validate sector1.json again.parquet
  anemo analyse sector1.json --pair sector1:sector1 --target 15
  anemo head identify id-*.parquet -o network.json
  anemo calibrate tunnel.parquet --network network.json -o head.toml
  anemo wind winds.parquet --head head.toml --plot winds.svg
  anemo self-test experiments/gusts.toml --on serial:/dev/ttyACM0
  anemo run experiments/gusts.toml --on serial:/dev/ttyACM0 -o gusts.csv
  anemo settings show --on serial:/dev/ttyACM0
  anemo status --on serial:/dev/ttyACM0

again.parquet, id-*.parquet, tunnel.parquet and winds.parquet are made as the
help of `validate`, `head identify`, `calibrate` and `wind` says; heater.csv and
three-winds.csv there are tables of your own."
)]
struct CommandLine {
    #[command(subcommand)]
    command: Subcommands,
}

#[derive(Subcommand)]
enum Subcommands {
    Run(run::Arguments),
    Log(log::Arguments),
    Mark(mark::Arguments),
    Live(live::Arguments),
    Recover(recover::Arguments),
    SelfTest(self_test::Arguments),
    Settings(settings::Arguments),
    Status(status::Arguments),
    Check(check::Arguments),
    Design(design::Arguments),
    Identify(identify::Arguments),
    Gram(gram::Arguments),
    Merge(merge::Arguments),
    Head(head::Arguments),
    #[command(hide = true)]
    Network(head::identify::IdentifyArguments),
    Calibrate(calibrate::Arguments),
    Wind(wind::Arguments),
    Combine(combine::Arguments),
    Meteorology(meteorology::Arguments),
    Validate(validate::Arguments),
    Laws(laws::Arguments),
    Plot(plot::Arguments),
    Example(example::Arguments),
    Export(export::Arguments),
    Convert(convert::Arguments),
    Reduce(reduce::Arguments),
    Analyse(analyse::Arguments),
    Predict(predict::Arguments),
    #[cfg(feature = "studies")]
    Thesis(thesis::Arguments),
    #[cfg(feature = "studies")]
    #[command(alias = "study")]
    Benchmark(benchmark::Arguments),
}

/// Commands that had another name before version 0.2: they still run, and are answered with the new
/// one.
const RENAMED: [(&[&str], &str); 3] =
    [(&["network"], "head identify"), (&["study"], "benchmark"), (&["settings", "forget"], "settings erase")];

/// The definition of the command line.
pub fn command() -> clap::Command {
    CommandLine::command()
}

/// Why a command line is refused, if it is; `words` are those behind `anemo`. A name from before
/// version 0.2 is refused, too.
pub fn refusal(words: &[String]) -> Option<String> {
    let parsed = CommandLine::try_parse_from(std::iter::once("anemo".to_owned()).chain(words.iter().cloned()));
    let refused = parsed.err().filter(clap::Error::use_stderr);
    renamed(words).or_else(|| refused.map(|error| one_sentence(&error, words.first().map(String::as_str))))
}

/// What to say to a command by an older name.
fn renamed(words: &[String]) -> Option<String> {
    let (old, new) =
        RENAMED.iter().find(|(old, _)| words.iter().zip(*old).filter(|(own, old)| own == old).count() == old.len())?;
    Some(format!("`anemo {}` is now called `anemo {new}`", old.join(" ")))
}

/// Does what the command line of this process asks for.
pub fn main() -> ExitCode {
    let words: Result<Vec<String>, std::ffi::OsString> =
        std::env::args_os().skip(1).map(std::ffi::OsString::into_string).collect();
    ExitCode::from(match words {
        Ok(words) => main_of(words),
        Err(word) => {
            output::complain(&format!("`{}` is no text in UTF-8: rename what it names", word.display()));
            2
        }
    })
}

/// The same for these words, which are those behind `anemo`; gives the exit code.
pub fn main_of(words: Vec<String>) -> u8 {
    if let Some(sentence) = renamed(&words) {
        output::complain(&sentence);
    }
    let arguments = match CommandLine::try_parse_from(std::iter::once("anemo".to_owned()).chain(words.iter().cloned()))
    {
        Ok(arguments) => arguments,
        Err(error)
            if error.use_stderr()
                && error.kind() != clap::error::ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand =>
        {
            output::complain(&one_sentence(&error, words.first().map(String::as_str)));
            return 2;
        }
        Err(error) => {
            // Help and version. That nobody reads them is no failure.
            return match error.print() {
                Err(unprinted) if unprinted.kind() != std::io::ErrorKind::BrokenPipe => {
                    output::complain(&format!("it cannot be printed: {unprinted}"));
                    1
                }
                _ => u8::from(error.use_stderr()) * 2,
            };
        }
    };
    progress::show_fetches();
    match execute(&arguments.command) {
        Ok(()) => 0,
        Err(failure) => {
            output::complain(&failure.sentence);
            failure.code
        }
    }
}

/// Does what a subcommand asks for.
fn execute(command: &Subcommands) -> Result<(), output::Failure> {
    match command {
        Subcommands::Run(arguments) => run_device::execute(arguments),
        Subcommands::Log(arguments) => log::execute(arguments),
        Subcommands::Mark(arguments) => mark::execute(arguments),
        Subcommands::Live(arguments) => live::execute(arguments),
        Subcommands::Recover(arguments) => recover::execute(arguments),
        Subcommands::SelfTest(arguments) => self_test::execute(arguments),
        Subcommands::Settings(arguments) => settings::execute(arguments),
        Subcommands::Status(arguments) => status::execute(arguments),
        Subcommands::Check(arguments) => check::execute(arguments),
        Subcommands::Design(arguments) => design::execute(arguments),
        Subcommands::Identify(arguments) => identify::execute(arguments),
        Subcommands::Gram(arguments) => gram::execute(arguments),
        Subcommands::Merge(arguments) => merge::execute(arguments),
        Subcommands::Head(arguments) => head::execute(arguments),
        Subcommands::Network(arguments) => head::identify::identify_network(arguments),
        Subcommands::Calibrate(arguments) => calibrate::execute(arguments),
        Subcommands::Wind(arguments) => wind::execute(arguments),
        Subcommands::Combine(arguments) => combine::execute(arguments),
        Subcommands::Meteorology(arguments) => meteorology::execute(arguments),
        Subcommands::Validate(arguments) => validate::execute(arguments),
        Subcommands::Laws(arguments) => laws::execute(arguments),
        Subcommands::Plot(arguments) => plot::execute(arguments),
        Subcommands::Example(arguments) => example::execute(arguments),
        Subcommands::Export(arguments) => export::execute(arguments),
        Subcommands::Convert(arguments) => convert::execute(arguments),
        Subcommands::Reduce(arguments) => reduce::execute(arguments),
        Subcommands::Analyse(arguments) => analyse::execute(arguments),
        Subcommands::Predict(arguments) => predict_device::execute(arguments),
        #[cfg(feature = "studies")]
        Subcommands::Thesis(arguments) => thesis::execute(arguments),
        #[cfg(feature = "studies")]
        Subcommands::Benchmark(arguments) => benchmark::execute(arguments),
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
    let known = CommandLine::command();
    let command = command.filter(|name| known.find_subcommand(name).is_some());
    let command = command.map_or(String::new(), |name| format!("{name} "));
    format!("{joined} (see `anemo {command}--help`)")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_well_formed() {
        CommandLine::command().debug_assert();
    }

    /// What stands behind the options in the help of a command and of all below it.
    fn texts(command: &clap::Command) -> Vec<String> {
        let own = command.get_after_help().map(ToString::to_string);
        own.into_iter().chain(command.get_subcommands().flat_map(texts)).collect()
    }

    #[test]
    fn no_line_of_an_example_is_wrapped() {
        let texts = texts(&command());
        let wide = texts.iter().flat_map(|text| text.lines()).filter(|line| line.starts_with("  "));
        let wide: Vec<&str> = wide.filter(|line| line.chars().count() > MOST_COLUMNS).collect();
        assert!(wide.is_empty(), "{wide:#?}");
    }

    #[test]
    fn every_example_of_the_help_parses() {
        let (mut refused, mut examples) = (Vec::new(), 0);
        for text in texts(&command()) {
            for line in text.replace("\\\n", " ").lines().filter(|line| line.starts_with("  ")) {
                let words = shlex::split(line.trim_end_matches("; done")).unwrap_or_default();
                if let Some(begin) = words.iter().position(|word| word == "anemo") {
                    examples += 1;
                    refused.extend(refusal(&words[begin + 1..]).map(|reason| format!("{line}: {reason}")));
                }
            }
        }
        assert!(refused.is_empty(), "{refused:#?}");
        assert!(examples > 50, "{examples}");
    }

    #[test]
    fn an_older_name_is_answered_with_the_new_one() {
        let said = |words: &[&str]| renamed(&words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>());
        assert_eq!(said(&["study", "wind"]).unwrap(), "`anemo study` is now called `anemo benchmark`");
        assert_eq!(
            said(&["settings", "forget", "--all"]).unwrap(),
            "`anemo settings forget` is now called `anemo settings erase`"
        );
        assert_eq!([said(&["settings", "show"]), said(&["settings"]), said(&[])], [None, None, None]);
        let parsed = CommandLine::try_parse_from(["anemo", "settings", "forget", "--all", "--on", "qemu"]);
        assert!(matches!(parsed.unwrap().command, Subcommands::Settings(_)));
    }

    #[test]
    fn a_wrong_option_is_one_sentence_with_the_right_one() {
        let error =
            CommandLine::try_parse_from(["anemo", "run", "a.toml", "--on", "sim", "--plto", "x.svg"]).err().unwrap();
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
            one_sentence(&CommandLine::try_parse_from(arguments).err().unwrap(), arguments.get(1).copied())
        };
        let wrong = sentence(&["anemo", "wind", "a.parquet", "--bandwidth", "fast"]);
        assert!(wrong.ends_with("(see `anemo wind --help`)"), "{wrong}");
        let missing = sentence(&["anemo", "calibrate"]);
        assert!(missing.ends_with("(see `anemo calibrate --help`)"), "{missing}");
        let unknown = sentence(&["anemo", "blow"]);
        assert!(unknown.ends_with("(see `anemo --help`)"), "{unknown}");
    }
}
