//! Steps that a page asks to be run: transcripts of a terminal, scripts in Python.

use super::elision::ELISION;
use crate::markdown::{self, Part};

/// Expectation of a block's commands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Expectation {
    Success,
    /// The last one fails.
    Failure,
    /// They need a sensor board, and are not run.
    Board,
}

#[derive(Debug, PartialEq)]
pub enum Step {
    Command(ShownCommand),
    Python { line: usize, script: String, runs: bool },
}

/// A command of a transcript and what is shown below it.
#[derive(Debug, PartialEq)]
pub struct ShownCommand {
    /// Line of the page, from 1, as of everything here.
    pub line: usize,
    pub command: String,
    pub expectation: Expectation,
    /// First line of the output, or the line where it would be.
    pub output_line: usize,
    pub output: Vec<String>,
    /// Indent of the block.
    pub indent: usize,
}

/// The steps of a page in their order, and blocks that cannot be understood: line and reason.
pub fn steps(text: &str) -> (Vec<Step>, Vec<(usize, &'static str)>) {
    let mut steps = Vec::new();
    let mut faults = Vec::new();
    let mut parts = markdown::parts(text).into_iter().filter(|part| !part.is_empty_line()).peekable();
    while let Some(part) = parts.next() {
        let Part::Block(block) = part else { continue };
        let mut words = block.info.split_whitespace();
        let language = words.next();
        let expectation = match (words.next(), words.next()) {
            (None, _) => Expectation::Success,
            (Some("fails"), None) => Expectation::Failure,
            (Some("board"), None) => Expectation::Board,
            _ => {
                faults.push((block.line, "behind the language only `fails` or `board` is known"));
                continue;
            }
        };
        match language {
            Some("console") => {
                let commands = transcript(&block, expectation);
                if commands.is_empty() || block.lines.first().is_some_and(|first| !first.starts_with("$ ")) {
                    faults.push((block.line, "a transcript begins with a command: `$ `"));
                }
                steps.extend(commands.into_iter().map(Step::Command));
            }
            Some("bash") => {
                let output = match parts.peek() {
                    Some(Part::Block(after)) if after.info == "text" => Some(after),
                    _ => None,
                };
                steps.extend(pasted(&block, output, expectation).into_iter().map(Step::Command));
            }
            Some("python") => {
                let script = block.lines.join("\n");
                steps.push(Step::Python { line: block.line, script, runs: expectation != Expectation::Board });
            }
            None | Some("sh" | "shell" | "text" | "terminal") => {
                if let Some(at) = block.lines.iter().position(|line| line.starts_with("$ ")) {
                    faults.push((block.line + 1 + at, "a command stands in a block ```console, so that it is run"));
                }
            }
            Some(_) => {}
        }
    }
    (steps, faults)
}

/// Commands of a block that a reader pastes as it is, with the output that a block of text shows
/// after it. Each job of cargo is a command of its own, anything else one script.
fn pasted(
    block: &markdown::FencedBlock,
    output: Option<&markdown::FencedBlock>,
    expectation: Expectation,
) -> Vec<ShownCommand> {
    let shown = |line: usize, command: String| ShownCommand {
        line,
        command,
        expectation,
        output_line: output.map_or(line, |output| output.line + 1),
        // Without a block of text any output will do.
        output: output
            .map_or(vec![ELISION.to_owned()], |output| output.lines.iter().map(|&line| line.to_owned()).collect()),
        indent: output.map_or(0, |output| output.indent),
    };
    let lines = block.lines.iter().enumerate().filter(|(_, line)| !line.trim().is_empty());
    if output.is_none() && lines.clone().all(|(_, line)| line.starts_with("cargo ")) {
        return lines.map(|(at, line)| shown(block.line + 1 + at, (*line).to_owned())).collect();
    }
    vec![shown(block.line + 1, format!("set -e\n{}", block.lines.join("\n")))]
}

fn transcript(block: &markdown::FencedBlock, expectation: Expectation) -> Vec<ShownCommand> {
    let mut commands: Vec<ShownCommand> = Vec::new();
    for (at, text) in block.lines.iter().enumerate() {
        let line = block.line + 1 + at;
        if let Some(command) = text.strip_prefix("$ ") {
            // Expectation of all but the last command of a block that fails.
            if let Some(before) = commands.last_mut().filter(|_| expectation == Expectation::Failure) {
                before.expectation = Expectation::Success;
            }
            let command = command.to_owned();
            let (output_line, indent) = (line + 1, block.indent);
            commands.push(ShownCommand { line, command, expectation, output_line, output: Vec::new(), indent });
        } else if let Some(command) = commands.last_mut() {
            if let Some(more) = text.strip_prefix("> ").filter(|_| command.output.is_empty()) {
                command.command += &format!("\n{more}");
                command.output_line = line + 1;
            } else {
                command.output.push((*text).to_owned());
            }
        }
    }
    // Empty lines part a command from the one before.
    for command in &mut commands {
        while command.output.last().is_some_and(|line| line.trim().is_empty()) {
            command.output.pop();
        }
    }
    commands
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_transcript_has_commands_with_what_is_shown_below_them() {
        let text = "# Page\n```console fails\n$ one \\\n> more\nout\n\n$ two\n```\n\n```python\nx = 1\n```\n";
        let (steps, faults) = steps(text);
        let command = |line, command: &str, expectation, output_line, output: &[&str]| {
            let output = output.iter().map(|&line| line.to_owned()).collect();
            Step::Command(ShownCommand {
                line,
                command: command.to_owned(),
                expectation,
                output_line,
                output,
                indent: 0,
            })
        };
        assert_eq!(
            steps,
            [
                command(3, "one \\\nmore", Expectation::Success, 5, &["out"]),
                command(7, "two", Expectation::Failure, 8, &[]),
                Step::Python { line: 10, script: "x = 1".into(), runs: true },
            ]
        );
        assert!(faults.is_empty());
    }

    #[test]
    fn a_block_to_paste_is_one_script_with_the_text_after_it_as_its_output() {
        let text = "```bash\none\ntwo\n```\n\n```text\nout\n…\n```\n```bash\ncargo xtask demo  # see\n\ncargo xtask test\n```\n```text\nno output\n```\n```bash\nthree\n```\nProse.\n```text\nfree\n```\n";
        let (steps, faults) = steps(text);
        assert!(faults.is_empty(), "{faults:?}");
        let found: Vec<_> = steps
            .iter()
            .map(|step| match step {
                Step::Command(shown) => (shown.line, shown.command.as_str(), shown.output_line, shown.output.join("|")),
                Step::Python { .. } => panic!("there is no script"),
            })
            .collect();
        assert_eq!(found[0], (2, "set -e\none\ntwo", 7, "out|…".to_owned()));
        assert_eq!(found[1].3, "no output");
        assert_eq!(found[2], (19, "set -e\nthree", 19, "…".to_owned()));
        let (steps, _) = super::steps("```bash\ncargo xtask demo\ncargo xtask test\n```\n");
        assert_eq!(steps.len(), 2);
    }

    #[test]
    fn a_command_that_would_not_be_run_is_found() {
        let (steps, faults) =
            steps("```\nno command\n$ anemo run\n```\n```console maybe\n$ x\n```\n```console\nout\n```\n");
        assert!(steps.is_empty());
        assert_eq!(faults.iter().map(|(line, _)| *line).collect::<Vec<_>>(), [3, 5, 8]);
    }
}
