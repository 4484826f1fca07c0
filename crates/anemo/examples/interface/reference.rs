//! The reference of the command line as Markdown pages, from the definition that the help is
//! printed from.
//!
//! An option that all commands of a group have stands once, with the group; what nearly every
//! command has (`--help`, `--json`) stands at the top of the first page.

use clap::{Arg, ArgAction, Command};

/// A page, its commands in order.
struct Page {
    file: &'static str,
    /// Subject of its commands, in a word.
    kind: &'static str,
    about: &'static str,
    commands: &'static [&'static str],
}

const PAGES: [Page; 6] = [
    Page {
        file: "command-line.md",
        kind: "instruments",
        about: "Run a simulated or real instrument, and look at it.",
        commands: &["check", "run", "live", "log", "mark", "self-test", "board"],
    },
    Page {
        file: "command-line-recordings.md",
        kind: "recordings",
        about: "Draw recordings and models, close recordings.",
        commands: &["plot", "recover"],
    },
    Page {
        file: "command-line-models.md",
        kind: "thermal models",
        about: "Identify thermal models, validate, reduce, merge and export them.",
        commands: &["identify", "validate", "model"],
    },
    Page {
        file: "command-line-loops.md",
        kind: "closed loops",
        about: "Design a loop, analyse a given loop, predict a whole experiment.",
        commands: &["analyse", "design", "predict"],
    },
    Page {
        file: "command-line-heads.md",
        kind: "heads",
        about: "Begin a head, check it, and calibrate it.",
        commands: &["head", "calibrate"],
    },
    Page {
        file: "command-line-wind.md",
        kind: "wind",
        about: "Estimate the wind, combine instruments, average.",
        commands: &["wind", "combine", "meteorology"],
    },
];

const CONVENTIONS: &str = "\
`anemo COMMAND --help` prints what stands here, `-h` a summary. `--json` prints one JSON object ([keys](json.md)) in \
place of the summary; only {without} lack it. Errors: [messages](messages.md).

A file is written in whole or not at all. Below a command's name stands what it needs: `<…>` is a word of yours, `[…]` \
may be left out, what `...` follows may be repeated.
";

/// Help of an option that prints JSON if it only says so.
const JSON: &str = "Print one JSON object instead of the ";

/// All pages, as (file, text).
pub fn pages(mut root: Command) -> Vec<(&'static str, String)> {
    root.build();
    let listed: Vec<&str> = PAGES.iter().flat_map(|page| page.commands).copied().collect();
    for command in subcommands(&root) {
        assert!(listed.contains(&command.get_name()), "{} stands on no page", command.get_name());
    }
    let mut said = Said::default();
    PAGES.iter().map(|page| (page.file, page.text(&root, &mut said))).collect()
}

impl Page {
    fn text(&self, root: &Command, said: &mut Said) -> String {
        let mut text = format!(
            "# Command line: {}\n\n<!-- Written by `cargo xtask reference`. -->\n\n{}\n",
            self.kind, self.about
        );
        if self.file == PAGES[0].file {
            let without: Vec<String> = leaves(root).into_iter().filter(|leaf| !prints_json(leaf)).map(name).collect();
            text += &format!("\n{}", CONVENTIONS.replace("{without}", &without.join(", ")));
            text += "\n";
            for page in &PAGES {
                text += &format!("- {}: {}\n", page.kind, page.links());
            }
        } else {
            text += &format!("\n{}. [Conventions of all commands](command-line.md)\n", self.links());
        }
        said.file = self.file;
        for name in self.commands {
            command(find(root, name), 2, &[], said, &mut text);
        }
        // A link within the page needs no file.
        text.replace(&format!("]({}#", self.file), "](#")
    }

    fn links(&self) -> String {
        let links = self.commands.iter().map(|name| format!("[{name}]({}#anemo-{name})", self.file));
        links.collect::<Vec<_>>().join(", ")
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

/// Rows that stand on this page or one before, and a link to the command where.
#[derive(Default)]
struct Said {
    /// Name of this page.
    file: &'static str,
    rows: Vec<(Row, String)>,
}

/// A command and its subcommands, whose `shared` rows stand with the group.
fn command(command_: &Command, level: usize, shared: &[Row], said: &mut Said, text: &mut String) {
    *text += &format!("\n{} {}\n", "#".repeat(level), command_.get_bin_name().unwrap_or_default());
    let whole = command_.get_long_about().map(ToString::to_string).unwrap_or_else(|| about(command_) + ".");
    *text += &format!("\n{}\n", whole.trim_end().replace("..", "."));
    let rows: Vec<Row> = command_.get_arguments().filter_map(Row::of).filter(|row| !shared.contains(row)).collect();
    if !command_.has_subcommands() {
        let usage = command_.clone().render_usage().to_string().replace(" [OPTIONS]", "");
        *text += &format!("\n`{}`\n", usage.trim_start_matches("Usage: ").trim_end());
        table(rows, command_, said, text);
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
        table(common.clone(), command_, said, text);
    }
    if let Some(after) = command_.get_after_help() {
        after
            .to_string()
            // Lines below an empty one still belong to the examples.
            .replace("\n\n  ", "\n  ")
            .trim()
            .split("\n\n")
            .for_each(|paragraph| *text += &format!("\n{}\n", in_markdown(paragraph)));
    }
    for subcommand in groups {
        command(subcommand, level + 1, &common, said, text);
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
#[derive(Clone, PartialEq)]
struct Row {
    name: String,
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
        let name = argument.get_long().map_or(values.join(" "), |long| format!("--{long}"));
        Some(Self { name, option, meaning: meaning.trim_start_matches(". ").to_owned(), default })
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

/// A row that stands somewhere already is its name, and where.
fn table(rows: Vec<Row>, of: &Command, said: &mut Said, text: &mut String) {
    if rows.is_empty() {
        return;
    }
    let of = of.get_bin_name().unwrap_or_default();
    let mut again: Vec<(String, Vec<String>)> = Vec::new();
    let mut new = Vec::new();
    for row in rows {
        match said.rows.iter().find(|(known, _)| *known == row) {
            Some((_, place)) => {
                let name = format!("`{}`", row.name);
                match again.iter_mut().find(|(known, _)| known == place) {
                    Some((_, names)) => names.push(name),
                    None => again.push((place.clone(), vec![name])),
                }
            }
            None => new.push(row),
        }
    }
    // The bars stand close, so that they are not counted as words.
    let defaults = new.iter().any(|row| !row.default.is_empty());
    *text += if defaults { "\noption| meaning| default\n---|---|---\n" } else { "\noption| meaning\n---|---\n" };
    for Row { option, meaning, default, .. } in &new {
        *text += &if defaults { format!("{option}| {meaning}| {default}") } else { format!("{option}| {meaning}") };
        *text = text.trim_end().to_owned() + "\n";
    }
    for (place, names) in again {
        *text += &format!("{}| as of {place}\n", names.join(" "));
    }
    let place = format!("[{}]({}#{})", of.trim_start_matches("anemo "), said.file, of.replace(' ', "-"));
    said.rows.extend(new.into_iter().map(|row| (row, place.clone())));
}
