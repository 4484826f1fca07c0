//! Commands that a page shows and that are not run: jobs of `cargo xtask` must exist, command lines
//! of `anemo` must parse.

use super::transcript::{Expectation, Step};
use crate::markdown;
use anyhow::{Context, Result};
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

/// Programs that change more than a page's folder.
const NOT_RUN: [&str; 4] = ["cargo", "git", "rustup", "sudo"];

/// Tells whether a step is only checked by its names.
pub fn is_not_run(step: &Step) -> bool {
    match step {
        Step::Command(shown) => shown.expectation == Expectation::Board || changes_more(&shown.command),
        Step::Python { runs, .. } => !runs,
    }
}

fn changes_more(command: &str) -> bool {
    command.split_whitespace().next().is_some_and(|first| NOT_RUN.contains(&first))
}

/// Checks the names of a page and returns lines with faults.
pub fn check(
    text: &str,
    steps: &[Step],
    jobs: &clap::Command,
    interface: Option<&Path>,
) -> Result<Vec<(usize, String)>> {
    let mut faults = Vec::new();
    let shown = steps.iter().filter(|step| is_not_run(step)).filter_map(|step| match step {
        Step::Command(shown) => Some((shown.line, shown.command.replace("\\\n", " "))),
        Step::Python { .. } => None,
    });
    let mut lines: Vec<(usize, String)> = shown.collect();
    let shown = lines.len();
    let is_command =
        |code: &str| code.starts_with("anemo ") || code.starts_with("cargo xtask ") && !has_placeholder(code);
    lines.extend(markdown::inline_code(text).into_iter().filter(|(_, code)| is_command(code)));
    let mut parsed = Vec::new();
    for (at, (line, command)) in lines.into_iter().enumerate() {
        faults.extend(job_fault(&command, jobs).map(|fault| (line, fault)));
        if command.starts_with("anemo ") && !has_placeholder(&command) {
            parsed.push((line, command, at >= shown));
        }
    }
    if let Some(interface) = interface {
        faults.extend(refused(&parsed, interface)?);
    }
    Ok(faults)
}

/// Tells whether a command line stands for others: it has `…`, `<name>` or `NAME`.
fn has_placeholder(command: &str) -> bool {
    let capitals = |word: &str| !word.is_empty() && word.chars().all(|c| c.is_ascii_uppercase());
    command.contains(['…', '<', '[']) || command.split(|c: char| !c.is_alphanumeric()).any(capitals)
}

/// Why `cargo xtask` would not understand this, if it is a job of it.
fn job_fault(command: &str, jobs: &clap::Command) -> Option<String> {
    let words = command.split(" #").next()?.split_whitespace().collect::<Vec<_>>();
    let arguments = words.strip_prefix(&["cargo", "xtask"])?;
    let refused = jobs.clone().try_get_matches_from([&["cargo xtask"], arguments].concat()).err();
    let message = refused.filter(clap::Error::use_stderr)?.to_string();
    Some(format!("`{command}`: {}", message.lines().next().unwrap_or_default()))
}

/// Tells whether code within the text only mentions an option without its value.
fn is_mention(reason: &str) -> bool {
    ["a value is required", "required arguments were not provided"].iter().any(|of| reason.contains(of))
}

/// Lines that `anemo` would refuse, and why; the last of each tells whether it stands within the
/// text.
fn refused(lines: &[(usize, String, bool)], interface: &Path) -> Result<Vec<(usize, String)>> {
    let mut child = Command::new(interface)
        .arg("--parse")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .with_context(|| format!("{} cannot be started", interface.display()))?;
    // Fewer than fit into a pipe.
    let asked: String = lines.iter().map(|(_, command, _)| whole(command) + "\n").collect();
    child.stdin.take().context("no input")?.write_all(asked.as_bytes())?;
    let output = child.wait_with_output()?;
    let answers = String::from_utf8_lossy(&output.stdout).into_owned();
    let fault = |answer: &str| {
        let (number, reason) = answer.split_once(": ")?;
        let (line, command, is_inline) = lines.get(number.parse::<usize>().ok()?.checked_sub(1)?)?;
        (!is_inline || !is_mention(reason)).then(|| (*line, format!("`{command}`: {reason}")))
    };
    Ok(answers.lines().filter_map(fault).collect())
}

/// A command line that is only the name of a command, as `anemo head identify`, asks for its help.
fn whole(command: &str) -> String {
    let is_name = |word: &str| word.chars().all(|c| c.is_ascii_lowercase() || c == '-') && !word.starts_with('-');
    if command.split_whitespace().all(is_name) { format!("{command} --help") } else { command.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pages::transcript;

    #[test]
    fn an_unknown_job_or_option_of_a_job_is_found() {
        let text = "`cargo xtask dmo`, `cargo xtask …`\n```console\n$ cargo xtask cost --write # all\n$ cargo xtask cost --wite\n```\n";
        let write = clap::Arg::new("write").long("write").action(clap::ArgAction::SetTrue);
        let jobs = clap::Command::new("cargo xtask").subcommand(clap::Command::new("cost").arg(write));
        let faults = check(text, &transcript::steps(text).0, &jobs, None).expect("nothing is started");
        assert_eq!(faults.iter().map(|(line, _)| *line).collect::<Vec<_>>(), [4, 1]);
        assert!(faults[1].1.starts_with("`cargo xtask dmo`: error: unrecognized subcommand 'dmo'"), "{}", faults[1].1);
    }

    #[test]
    fn a_placeholder_is_a_word_in_capitals() {
        assert!(has_placeholder("anemo run EXPERIMENT --on sim"));
        assert!(has_placeholder("anemo run gusts.toml --on serial:DEVICE"));
        assert!(!has_placeholder("anemo run gusts.toml --on serial:/dev/ttyACM0 -o id-*.parquet"));
        assert_eq!(whole("anemo head identify"), "anemo head identify --help");
        assert_eq!(whole("anemo plot a.parquet"), "anemo plot a.parquet");
    }
}
