//! The functions of the Python package, one a command, from the definition that the help is printed
//! from: names, defaults and texts are those of the command line.

use clap::{Arg, ArgAction, Command};

/// Commands that work on files and models, what they are called in Python, and what they give.
const FUNCTIONS: [(&str, &str, &str); 18] = [
    ("identify", "identify", "Model"),
    ("validate", "validate", "Report"),
    ("model merge", "merge", "Model"),
    ("model reduce", "reduce", "Model"),
    ("model export", "export", "Report"),
    ("analyse", "analyse", "Report"),
    ("design", "design", "Report"),
    ("predict", "predict", "Report"),
    ("check", "check", "Report"),
    ("run", "simulate", "Table"),
    ("plot", "plot", "Report"),
    ("head identify", "identify_head", "Network"),
    ("head check", "check_head", "Report"),
    ("head compare", "compare_heads", "Report"),
    ("calibrate", "calibrate", "Head"),
    ("wind", "wind", "Table"),
    ("combine", "combine", "Table"),
    ("meteorology", "meteorology", "Report"),
];

/// Options that mean nothing here: results are objects, and what is simulated runs in process.
const WITHOUT: [&str; 9] = ["json", "help", "version", "on", "firmware", "link", "flash", "acknowledge", "segment"];

/// Words that Python keeps for itself.
const KEYWORDS: [&str; 6] = ["as", "class", "from", "in", "is", "with"];

const HEAD: &str = "\
# Written by `cargo xtask reference` from the definition of the command line.
\"\"\"The commands as functions: what stands in the help of a command stands here.\"\"\"

from __future__ import annotations

from ._anemo import Model, Table
from ._call import Number, Paths, Source, Words, call, flag, several
from ._results import Head, Network, Report
";

/// The text of `anemo/_commands.py`.
pub fn module(mut root: Command) -> String {
    root.build();
    let mut text = HEAD.to_owned();
    for (command, name, gives) in FUNCTIONS {
        let found = command.split(' ').fold(&root, |found, word| {
            found.find_subcommand(word).unwrap_or_else(|| panic!("there is no command {command}"))
        });
        text += &function(found, command, name, gives);
    }
    let names: Vec<String> = FUNCTIONS.iter().map(|(_, name, _)| format!("    \"{name}\",\n")).collect();
    text + &format!("\n\n__all__ = [\n{}]\n", names.concat())
}

fn function(command: &Command, words: &str, name: &str, gives: &str) -> String {
    let positionals: Vec<&Arg> = command.get_positionals().collect();
    let options: Vec<&Arg> = command
        .get_arguments()
        .filter(|arg| !arg.is_positional() && !arg.is_hide_set())
        .filter(|arg| arg.get_long().is_some_and(|long| !WITHOUT.contains(&long)))
        .collect();
    let mut parameters = Vec::new();
    for arg in &positionals {
        let id = identifier(arg.get_id().as_str());
        parameters.push(match is_repeated(arg) {
            true => format!("*{id}: Source"),
            false if arg.is_required_set() => format!("{id}: Source"),
            false => format!("{id}: Source | None = None"),
        });
    }
    if !positionals.iter().any(|arg| is_repeated(arg)) && !options.is_empty() {
        parameters.push("*".to_owned());
    }
    parameters.extend(options.iter().map(|arg| format!("{}: {}", option_name(arg), annotation(arg))));
    let given: Vec<String> = positionals
        .iter()
        .map(|arg| format!("{}{}", if is_repeated(arg) { "*" } else { "" }, identifier(arg.get_id().as_str())))
        .collect();
    let passed: Vec<String> = options
        .iter()
        .map(|arg| format!("            \"--{}\": {},\n", arg.get_long().unwrap_or_default(), passed(arg)))
        .collect();
    let parameters: Vec<String> = parameters.iter().map(|parameter| format!("    {parameter},\n")).collect();
    let given = if given.is_empty() { "()".to_owned() } else { format!("({},)", given.join(", ")) };
    format!(
        "\n\ndef {name}(\n{}) -> {gives}:\n    \"\"\"{}\"\"\"\n    return call(\n        \"{words}\",\n        {given},\n        {{\n{}        }},\n        {gives},\n    )\n",
        parameters.concat(),
        documentation(command, &positionals, &options),
        passed.concat(),
    )
}

fn is_repeated(arg: &Arg) -> bool {
    matches!(arg.get_action(), ArgAction::Append)
}

fn identifier(name: &str) -> String {
    let name = name.replace('-', "_");
    if KEYWORDS.contains(&name.as_str()) { format!("{name}_") } else { name }
}

fn option_name(arg: &Arg) -> String {
    identifier(arg.get_long().unwrap_or_default())
}

/// Way in which an option's value is handed on.
fn passed(arg: &Arg) -> String {
    let name = option_name(arg);
    match arg.get_action() {
        ArgAction::SetTrue => format!("flag({name})"),
        ArgAction::Append => format!("several({name})"),
        _ => name,
    }
}

fn annotation(arg: &Arg) -> &'static str {
    let name = arg.get_value_names().and_then(|names| names.first()).map_or("", |name| name.as_str());
    match arg.get_action() {
        ArgAction::SetTrue => "bool = False",
        ArgAction::Append => "Words = None",
        _ if ["FILE", "RECORDING", "FILE|FOLDER"].contains(&name) => "Paths = None",
        _ => "Number = None",
    }
}

/// Text of the help, in the order of a docstring.
fn documentation(command: &Command, positionals: &[&Arg], options: &[&Arg]) -> String {
    let about = command.get_long_about().or(command.get_about()).map(ToString::to_string).unwrap_or_default();
    let mut text = wrapped(&about, "    ").trim_start().to_owned();
    text += "\n\n    Parameters\n    ----------\n";
    for arg in positionals.iter().chain(options) {
        let name = if arg.is_positional() { identifier(arg.get_id().as_str()) } else { option_name(arg) };
        let help = arg.get_long_help().or(arg.get_help()).map(ToString::to_string).unwrap_or_default();
        let values: Vec<String> = arg
            .get_possible_values()
            .iter()
            .filter(|_| !matches!(arg.get_action(), ArgAction::SetTrue))
            .map(choice)
            .collect();
        let default: Vec<&str> = arg.get_default_values().iter().filter_map(|value| value.to_str()).collect();
        text += &format!("    {name}\n{}\n", wrapped(&help, "        "));
        values.iter().for_each(|value| text += &format!("{}\n", wrapped(value, "        ")));
        if let (false, [default]) = (matches!(arg.get_action(), ArgAction::SetTrue), &default[..]) {
            text += &format!("        By default {default}.\n");
        }
    }
    format!("{}\n    ", text.trim_end().replace('\\', "\\\\"))
}

fn choice(value: &clap::builder::PossibleValue) -> String {
    let help = value.get_help().map(|help| format!(": {help}")).unwrap_or_default();
    format!("- \"{}\"{help}", value.get_name())
}

/// Paragraphs filled to 100 columns.
fn wrapped(text: &str, indent: &str) -> String {
    let paragraph = |paragraph: &str| {
        let mut lines = vec![indent.to_owned()];
        for word in paragraph.split_whitespace() {
            let last = lines.last_mut().expect("there is a line");
            if last.trim().is_empty() {
                last.push_str(word);
            } else if last.chars().count() + 1 + word.chars().count() <= 100 {
                last.push(' ');
                last.push_str(word);
            } else {
                lines.push(format!("{indent}{word}"));
            }
        }
        lines.join("\n")
    };
    text.split("\n\n").map(paragraph).collect::<Vec<_>>().join("\n\n")
}
