//! The reference of the command line as Markdown pages, from the definition that the help is
//! printed from.
//!
//! An option that all commands of a group have stands once, with the group; what nearly every
//! command has (`--help`, `--json`) stands at the top of the first page.

use clap::{Arg, ArgAction, Command};

/// A page: its file, its title, what it is about, its commands in order.
struct Page {
    file: &'static str,
    title: &'static str,
    about: &'static str,
    commands: &'static [&'static str],
}

const PAGES: [Page; 3] = [
    Page {
        file: "command-line.md",
        title: "Command line: instruments",
        about: "Commands that run a simulated or real instrument, and look at what it is and what it recorded.",
        commands: &["check", "run", "self-test", "settings", "plot"],
    },
    Page {
        file: "command-line-models.md",
        title: "Command line: thermal models",
        about: "Commands that identify thermal models, judge and convert them, and predict closed loops with them.",
        commands: &["identify", "merge", "validate", "export", "reduce", "analyse", "design", "predict", "example"],
    },
    Page {
        file: "command-line-wind.md",
        title: "Command line: wind",
        about: "Commands that calibrate a head and estimate the wind, and those that measure how well this does.",
        commands: &["head", "calibrate", "wind", "benchmark", "thesis"],
    },
];

const CONVENTIONS: &str = "\
`anemo COMMAND --help` prints what stands here, `-h` a summary of it, `anemo --version` the version. A summary of the \
work goes to stdout. With `--json` it is one JSON object ([keys](json.md)); all commands have this option but {without}. \
Errors go to stderr, one sentence that begins with `anemo:`.

exit code | meaning
---|---
0 | done
1 | what was asked for makes sense, but failed
2 | the command, or a file that it names, is wrong; nothing was started

A file is written in whole or not at all. In a synopsis, `<…>` stands for a word of yours, `[…]` may be left out, and \
what `...` follows may be repeated.
";

/// What an option that prints JSON says if it only says so.
const JSON: &str = "Print one JSON object instead of the ";

/// All pages, as (file, text).
pub fn pages(mut root: Command) -> Vec<(&'static str, String)> {
    root.build();
    let listed: Vec<&str> = PAGES.iter().flat_map(|page| page.commands).copied().collect();
    for command in root.get_subcommands().filter(|command| !command.is_hide_set() && command.get_name() != "help") {
        assert!(listed.contains(&command.get_name()), "{} stands on no page", command.get_name());
    }
    PAGES.iter().map(|page| (page.file, page.text(&root))).collect()
}

impl Page {
    fn text(&self, root: &Command) -> String {
        let mut text = format!("# {}\n\n<!-- Written by `cargo xtask reference`. -->\n\n{}\n", self.title, self.about);
        if self.file == PAGES[0].file {
            let without: Vec<String> = leaves(root).into_iter().filter(|leaf| !prints_json(leaf)).map(name).collect();
            text += &format!("\n{}", CONVENTIONS.replace("{without}", &without.join(", ")));
            text += "\ncommand | what it does\n---|---\n";
            for (page, command) in PAGES.iter().flat_map(|page| page.commands.iter().map(move |name| (page, *name))) {
                let file = if page.file == self.file { "" } else { page.file };
                text += &format!("[{command}]({file}#anemo-{command}) | {}\n", about(find(root, command)));
            }
        } else {
            let links = self.commands.iter().map(|name| format!("[{name}](#anemo-{name})"));
            text += &format!(
                "\n{}. Conventions of all commands and their list: [command line](command-line.md).\n",
                links.collect::<Vec<_>>().join(", ")
            );
        }
        for name in self.commands {
            command(find(root, name), 2, &[], &mut text);
        }
        text
    }
}

fn find<'a>(root: &'a Command, name: &str) -> &'a Command {
    root.find_subcommand(name).unwrap_or_else(|| panic!("there is no command {name}"))
}

/// The subcommands of a group that people are shown.
fn subcommands(command: &Command) -> impl Iterator<Item = &Command> {
    command.get_subcommands().filter(|command| !command.is_hide_set() && command.get_name() != "help")
}

/// Commands that have no subcommands.
fn leaves(root: &Command) -> Vec<&Command> {
    subcommands(root)
        .flat_map(|command| if command.has_subcommands() { leaves(command) } else { vec![command] })
        .collect()
}

fn prints_json(command: &Command) -> bool {
    command.get_arguments().any(|argument| argument.get_long() == Some("json"))
}

fn name(command: &Command) -> String {
    format!("`{}`", command.get_bin_name().unwrap_or_default().trim_start_matches("anemo "))
}

fn about(command: &Command) -> String {
    command.get_about().map(ToString::to_string).unwrap_or_default()
}

/// A command and its subcommands, whose `shared` rows stand with the group.
fn command(command_: &Command, level: usize, shared: &[Row], text: &mut String) {
    *text += &format!("\n{} {}\n", "#".repeat(level), command_.get_bin_name().unwrap_or_default());
    let whole = command_.get_long_about().map(ToString::to_string).unwrap_or_else(|| about(command_) + ".");
    *text += &format!("\n{}\n", whole.trim_end().replace("..", "."));
    let rows: Vec<Row> = command_.get_arguments().filter_map(Row::of).filter(|row| !shared.contains(row)).collect();
    if !command_.has_subcommands() {
        let usage = command_.clone().render_usage().to_string();
        *text += &format!("\n```text\n{}\n```\n", usage.trim_start_matches("Usage: ").trim_end());
        table(&rows, text);
    }
    let groups: Vec<&Command> = subcommands(command_).collect();
    let common = match groups.as_slice() {
        [first, others @ ..] if !others.is_empty() => {
            let has = |command: &Command, row: &Row| command.get_arguments().filter_map(Row::of).any(|own| own == *row);
            let rows = first.get_arguments().filter_map(Row::of);
            rows.filter(|row| others.iter().all(|other| has(other, row))).collect()
        }
        _ => Vec::new(),
    };
    if !common.is_empty() {
        *text += "\nOptions of all its commands:\n";
        table(&common, text);
    }
    if let Some(after) = command_.get_after_help() {
        after
            .to_string()
            .trim()
            .split("\n\n")
            .for_each(|paragraph| *text += &format!("\n{}\n", in_markdown(paragraph)));
    }
    for subcommand in groups {
        command(subcommand, level + 1, &common, text);
    }
}

/// A paragraph of a help text: sentences, or lines that are set as they are below a line that ends
/// in a colon.
fn in_markdown(paragraph: &str) -> String {
    match paragraph.split_once(":\n  ") {
        Some(("Examples" | "Example", lines)) => format!("```sh\n{}\n```", lines.replace("\n  ", "\n")),
        Some((title, lines)) => format!("{title}:\n\n```text\n{}\n```", lines.replace("\n  ", "\n")),
        None => paragraph.replace('\n', " "),
    }
}

/// An option in a table.
#[derive(PartialEq)]
struct Row {
    option: String,
    meaning: String,
    default: String,
}

impl Row {
    /// Nothing for what stands at the top of the first page.
    fn of(argument: &Arg) -> Option<Self> {
        let help = argument.get_long_help().or(argument.get_help()).map(ToString::to_string).unwrap_or_default();
        if argument.is_hide_set() || argument.get_id() == "help" || help.starts_with(JSON) {
            return None;
        }
        let takes_value = matches!(argument.get_action(), ArgAction::Set | ArgAction::Append);
        let values = argument.get_value_names().unwrap_or_default().iter().map(|name| name.to_string());
        let values: Vec<String> = values.map(|name| name.replace('|', "\\|")).collect();
        let short = argument.get_short().map(|short| format!("-{short}, ")).unwrap_or_default();
        let option = match argument.get_long() {
            Some(long) if takes_value => format!("`{short}--{long} {}`", values.join(" ")),
            Some(long) => format!("`{short}--{long}`"),
            None => format!("`{}`", values.join(" ")),
        };
        let mut meaning = help.replace("\n\n", " ").replace('\n', " ").replace('|', "\\|");
        let possible = argument.get_possible_values();
        if takes_value && !possible.is_empty() && !argument.is_hide_possible_values_set() {
            let said = |value: &clap::builder::PossibleValue| match value.get_help() {
                Some(help) => format!("`{}`: {}", value.get_name(), uncapitalised(&help.to_string())),
                None => format!("`{}`", value.get_name()),
            };
            let told = possible.iter().all(|value| meaning.contains(&format!("`{}`", value.get_name())));
            if !told {
                let values: Vec<_> = possible.iter().map(said).collect();
                meaning += &format!(". {}", values.join("; "));
            }
        }
        if let Some(variable) = argument.get_env() {
            meaning += &format!("; environment: `{}`", variable.to_string_lossy());
        }
        let default: Vec<_> = argument.get_default_values().iter().map(|value| value.to_string_lossy()).collect();
        let default =
            if takes_value && !default.is_empty() { format!("`{}`", default.join(" ")) } else { String::new() };
        Some(Self { option, meaning: meaning.trim_start_matches(". ").to_owned(), default })
    }
}

/// A sentence as it goes on behind a colon; names and units keep their capitals.
fn uncapitalised(text: &str) -> String {
    let mut letters = text.chars();
    match (letters.next(), letters.clone().next()) {
        (Some(first), Some(second)) if second.is_lowercase() || second == ' ' => {
            first.to_lowercase().chain(letters).collect()
        }
        _ => text.to_owned(),
    }
}

fn table(rows: &[Row], text: &mut String) {
    if rows.is_empty() {
        return;
    }
    let defaults = rows.iter().any(|row| !row.default.is_empty());
    *text += if defaults { "\noption | meaning | default\n---|---|---\n" } else { "\noption | meaning\n---|---\n" };
    for Row { option, meaning, default } in rows {
        *text += &if defaults { format!("{option} | {meaning} | {default}") } else { format!("{option} | {meaning}") };
        *text = text.trim_end().to_owned() + "\n";
    }
}
