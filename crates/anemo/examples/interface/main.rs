//! The interface of the command, written from its one definition: `interface <folder>`, or
//! `interface --parse`.
//!
//! The folder gets `completions/` (bash, zsh, fish, elvish, PowerShell), `man/` (`anemo.1` and a
//! page a subcommand), `reference/` (the Markdown pages of `docs/reference`) and
//! `_commands.py` (the functions of the Python package).
//!
//! `--parse` reads command lines from stdin, one a line, as `anemo run gusts.toml --on sim`, and
//! starts nothing. Each that `anemo` would refuse is answered with `NUMBER: reason` on stdout, by
//! the number of its line from 1; the exit code is 1 then. Words are quoted as in a shell; what
//! follows a word `|`, `>`, `2>`, `&&`, `||`, `;` or `&` is not read, nor is a comment.

mod python;
mod reference;

use clap::ValueEnum as _;
use std::io::{BufRead as _, Write as _};
use std::path::Path;
use std::process::ExitCode;

fn main() -> std::io::Result<ExitCode> {
    match std::env::args().nth(1).as_deref() {
        Some("--parse") => parse(),
        Some(folder) => write(Path::new(folder)).map(|()| ExitCode::SUCCESS),
        None => Err(std::io::Error::other("usage: interface <folder> | --parse")),
    }
}

fn parse() -> std::io::Result<ExitCode> {
    let mut code = ExitCode::SUCCESS;
    for (number, line) in std::io::stdin().lock().lines().enumerate() {
        if let Some(reason) = refusal(&line?) {
            writeln!(std::io::stdout(), "{}: {reason}", number + 1)?;
            code = ExitCode::FAILURE;
        }
    }
    Ok(code)
}

fn refusal(line: &str) -> Option<String> {
    let Some(words) = shlex::split(line) else { return Some("a quote is not closed".to_owned()) };
    let ends = |word: &String| ["|", ">", "2>", "&&", "||", ";", "&"].contains(&word.as_str());
    let words: Vec<String> = words.into_iter().take_while(|word| !ends(word)).collect();
    match words.split_first() {
        Some((name, arguments)) if name == "anemo" => anemo::refusal(arguments),
        Some(_) => Some("does not begin with anemo".to_owned()),
        None => None,
    }
}

fn write(folder: &Path) -> std::io::Result<()> {
    let [completions, man, pages] = ["completions", "man", "reference"].map(|name| folder.join(name));
    for folder in [&completions, &man, &pages] {
        std::fs::create_dir_all(folder)?;
    }
    for (file, text) in reference::pages(anemo::command()) {
        std::fs::write(pages.join(file), text)?;
    }
    std::fs::write(folder.join("_commands.py"), python::module(anemo::command()))?;
    for shell in clap_complete::Shell::value_variants() {
        clap_complete::generate_to(*shell, &mut anemo::command(), "anemo", &completions)?;
    }
    clap_mangen::generate_to(anemo::command(), &man)?;
    for page in std::fs::read_dir(man)? {
        let page = page?.path();
        std::fs::write(&page, as_it_is(&std::fs::read_to_string(&page)?))?;
    }
    Ok(())
}

/// A man page whose indented lines, examples and tables, are neither filled nor justified.
fn as_it_is(page: &str) -> String {
    let (mut text, mut is_open) = (String::new(), false);
    for line in page.replace(".SH EXTRA", ".SH NOTES").lines() {
        if line.starts_with("  ") != is_open {
            is_open = !is_open;
            text += if is_open { ".nf\n" } else { ".fi\n" };
        }
        text += line;
        text.push('\n');
    }
    text
}
