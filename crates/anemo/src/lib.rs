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
//! | 4 | a run or a log that ended early; recorded rows are kept |
//!
//! A summary goes to stdout, as text or, with `--json`, as one JSON object. Errors go to stderr,
//! one sentence that begins with `anemo:`.

mod analyse;
mod board;
mod calibrate;
mod check;
mod combine;
mod design;
mod feeding;
mod gone;
mod head;
mod identify;
mod identify_page;
pub mod in_process;
mod instrument;
mod live;
mod log;
mod log_files;
mod log_host;
mod log_source;
mod mark;
mod meteorology;
mod model;
mod model_options;
mod options;
mod output;
mod plot;
mod predict;
mod predict_against;
mod progress;
mod publishing;
mod record;
mod recover;
mod run;
mod run_device;
mod self_test;
mod validate;
mod wind;

use std::process::ExitCode;

use clap::error::ErrorKind;
use clap::{CommandFactory as _, FromArgMatches as _, Parser, Subcommand};

/// Width of help, also where a terminal is wider.
const MOST_COLUMNS: usize = 80;

/// Run thermal sigma-delta anemometers, identify thermal models, measure wind.
#[derive(Parser)]
#[command(
    name = "anemo",
    version,
    arg_required_else_help = true,
    max_term_width = MOST_COLUMNS,
    after_help = "\
Examples:
  anemo run experiments/gusts.toml --on sim -o gusts.parquet --plot gusts.svg
  anemo identify heater.csv --output temperature -o heater.json
  anemo wind winds.parquet --head head.toml --plot winds.svg

`anemo COMMAND --help` has options and examples of each command."
)]
struct CommandLine {
    #[command(subcommand)]
    command: Subcommands,
}

/// Declares the commands by groups of the help: the enum that clap reads, where each runs, and how
/// many each group has.
macro_rules! commands {
    ($($heading:literal { $($name:ident: $module:ident),+ $(,)? })+) => {
        #[derive(Subcommand)]
        enum Subcommands {
            $($($name($module::Arguments),)+)+
        }

        /// Runs a command.
        fn execute(command: &Subcommands) -> Result<(), output::Failure> {
            match command {
                $($(Subcommands::$name(arguments) => $module::execute(arguments),)+)+
            }
        }

        /// Headings of the help, each with the number of its commands, in the order of the commands.
        const GROUPS: &[(&str, usize)] = &[$(($heading, [$(stringify!($name)),+].len())),+];
    };
}

commands! {
    "Instrument" {
        Check: check,
        Run: run,
        Live: live,
        Log: log,
        Mark: mark,
        SelfTest: self_test,
        Board: board,
    }
    "Thermal models" {
        Identify: identify,
        Validate: validate,
        Analyse: analyse,
        Design: design,
        Predict: predict,
        Model: model,
    }
    "Wind" {
        Head: head,
        Calibrate: calibrate,
        Wind: wind,
        Combine: combine,
        Meteorology: meteorology,
    }
    "Files" {
        Plot: plot,
        Recover: recover,
    }
}

/// Definition of the command line.
pub fn command() -> clap::Command {
    let command = CommandLine::command();
    let list = list_of_commands(&command);
    command.help_template(format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{list}Options:\n{{options}}{{after-help}}"
    ))
}

/// Groups of the help: headings, each with the names of its commands.
pub fn groups() -> Vec<(&'static str, Vec<String>)> {
    let command = CommandLine::command();
    let mut names = command.get_subcommands().map(|command| command.get_name().to_owned());
    GROUPS.iter().map(|(heading, count)| (*heading, names.by_ref().take(*count).collect())).collect()
}

/// Lines of the help: commands by groups, each with what it does.
fn list_of_commands(command: &clap::Command) -> String {
    let mut list = String::new();
    for (heading, names) in groups() {
        list += &format!("{heading}:\n");
        for name in names {
            let about = command.find_subcommand(&name).and_then(clap::Command::get_about);
            list += &format!("  {name:<12} {}\n", about.map(ToString::to_string).unwrap_or_default());
        }
        list.push('\n');
    }
    list
}

/// Command line that runs nothing.
enum Unparsed {
    /// Help or version, which is printed.
    Shown(clap::Error),
    Refused(output::Failure),
}

/// Parses the words after `anemo`.
fn parsed(words: &[String]) -> Result<CommandLine, Unparsed> {
    let command = command();
    if let Some(failure) = gone::refusal(&command, words) {
        return Err(Unparsed::Refused(failure));
    }
    let matches = command.try_get_matches_from(std::iter::once("anemo").chain(words.iter().map(String::as_str)));
    matches.and_then(|matches| CommandLine::from_arg_matches(&matches)).map_err(|error| match error.kind() {
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => Unparsed::Shown(error),
        _ if error.use_stderr() => Unparsed::Refused(output::Failure::usage(one_sentence(&error, words))),
        _ => Unparsed::Shown(error),
    })
}

/// Reason for which a command line is refused; `words` are those after `anemo`.
pub fn refusal(words: &[String]) -> Option<String> {
    match parsed(words).err()? {
        Unparsed::Refused(failure) => Some(failure.sentence),
        Unparsed::Shown(error) => error.use_stderr().then(|| one_sentence(&error, words)),
    }
}

/// Runs the command line of this process.
pub fn main() -> ExitCode {
    let words: Result<Vec<String>, std::ffi::OsString> =
        std::env::args_os().skip(1).map(std::ffi::OsString::into_string).collect();
    ExitCode::from(match words {
        Ok(words) => main_of(&words),
        Err(word) => {
            output::complain(&format!("`{}` is not valid UTF-8; rename the file", word.display()));
            2
        }
    })
}

/// Runs a command line and returns its exit code; `words` are those after `anemo`.
pub fn main_of(words: &[String]) -> u8 {
    let done = match parsed(words) {
        Ok(arguments) => execute(&arguments.command),
        Err(Unparsed::Refused(failure)) => Err(failure),
        Err(Unparsed::Shown(error)) => match error.print() {
            // A reader that has gone away is not a failure.
            Err(unprinted) if unprinted.kind() != std::io::ErrorKind::BrokenPipe => {
                Err(output::Failure::work(format!("it cannot be printed: {unprinted}")))
            }
            _ => return u8::from(error.use_stderr()) * 2,
        },
    };
    done.map_or_else(
        |failure| {
            output::complain(&failure.sentence);
            failure.code
        },
        |()| 0,
    )
}

/// Clap's message without its usage block, in one line, with the help to look into.
fn one_sentence(error: &clap::Error, words: &[String]) -> String {
    let text = error.to_string();
    let parts =
        text.lines().take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more information"));
    let parts: Vec<&str> = parts.map(str::trim).filter(|line| !line.is_empty()).collect();
    let joined = parts.join("; ").replace(":; ", ": ");
    let joined = joined.strip_prefix("error: ").unwrap_or(&joined);
    let (mut known, mut name) = (&CommandLine::command(), String::new());
    for word in words {
        let Some(found) = known.find_subcommand(word) else { break };
        (known, name) = (found, format!("{name}{word} "));
    }
    format!("{joined} (see `anemo {name}--help`)")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_well_formed() {
        CommandLine::command().debug_assert();
    }

    /// Text behind the options in the help of a command and of all below it.
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
    fn every_command_is_listed_once_in_a_line_of_the_help() {
        let command = command();
        let listed: Vec<String> = groups().into_iter().flat_map(|(_, names)| names).collect();
        let known: Vec<&str> = command.get_subcommands().map(clap::Command::get_name).collect();
        assert_eq!(listed, known);
        assert!(known.len() <= 22, "{}", known.len());
        let help = command.clone().render_help().to_string();
        for name in known {
            assert_eq!(help.lines().filter(|line| line.starts_with(&format!("  {name} "))).count(), 1, "{name}");
        }
        assert!(help.lines().all(|line| line.chars().count() <= MOST_COLUMNS), "{help}");
    }

    /// A command and all below it.
    fn all_commands(command: &clap::Command) -> Vec<&clap::Command> {
        std::iter::once(command).chain(command.get_subcommands().flat_map(all_commands)).collect()
    }

    #[test]
    fn output_is_a_column_and_the_short_option_a_file_everywhere() {
        let root = command();
        let arguments: Vec<&clap::Arg> =
            all_commands(&root).into_iter().flat_map(clap::Command::get_arguments).collect();
        let value = |argument: &clap::Arg| argument.get_value_names().unwrap_or_default()[0].to_string();
        let columns = arguments.iter().filter(|argument| argument.get_long() == Some("output"));
        assert!(columns.map(|argument| value(argument)).all(|value| value == "COLUMN"));
        let files: Vec<_> = arguments.iter().filter(|argument| argument.get_short() == Some('o')).collect();
        assert!(files.len() > 10, "{}", files.len());
        for file in files {
            assert_eq!(file.get_long(), Some("output-file"));
            assert!(["FILE", "FOLDER", "FILE|FOLDER"].contains(&value(file).as_str()), "{}", value(file));
        }
    }

    #[test]
    fn a_wrong_option_is_one_sentence_with_the_right_one() {
        let sentence = refusal(&["run", "a.toml", "--on", "sim", "--plto", "x.svg"].map(str::to_owned)).unwrap();
        assert!(
            sentence.starts_with("unexpected argument '--plto' found; tip: a similar argument exists: '--plot'"),
            "{sentence}"
        );
        assert!(!sentence.contains('\n'));
        assert!(sentence.ends_with("(see `anemo run --help`)"), "{sentence}");
    }

    #[test]
    fn a_wrong_value_leads_to_the_help_of_its_command() {
        let sentence =
            |words: &[&str]| refusal(&words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>()).unwrap();
        let wrong = sentence(&["wind", "a.parquet", "--bandwidth", "fast"]);
        assert!(wrong.ends_with("(see `anemo wind --help`)"), "{wrong}");
        let missing = sentence(&["calibrate"]);
        assert!(missing.ends_with("(see `anemo calibrate --help`)"), "{missing}");
        let unknown = sentence(&["blow"]);
        assert!(unknown.ends_with("(see `anemo --help`)"), "{unknown}");
    }
}
