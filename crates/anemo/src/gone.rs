//! Answers to spellings of the command line that no longer exist: what to type now. Nothing runs.

use crate::output::Failure;

/// A command that has moved: its old words and its new ones, longer words first.
const MOVED: [(&str, &str); 8] = [
    ("settings forget", "board settings erase"),
    ("settings", "board settings"),
    ("status", "board status"),
    ("merge", "model merge"),
    ("reduce", "model reduce"),
    ("export", "model export"),
    ("network", "head identify"),
    ("flash", "board flash"),
];

/// A command that is gone, and what does its work now.
const GONE: [(&str, &str); 8] = [
    ("gram", "`anemo identify` reads several files of one record in one pass: anemo identify part-*.parquet"),
    ("sweep", "the Python package runs sweeps: anemo.sweep(…), see docs/how-to/sweep.md"),
    ("laws", "a script compares laws of response: python/gallery/mems_laws.py"),
    ("convert", "Python and MATLAB read .parquet and .csv recordings: see docs/how-to/read-files.md"),
    ("example", "the tests identify systems that are known exactly: cargo test --release -p diffusive"),
    ("thesis", "a program of the checkout does this: cargo run --release -p studies -- thesis"),
    ("benchmark", "a program of the checkout does this: cargo run --release -p studies -- benchmark"),
    ("study", "a program of the checkout does this: cargo run --release -p studies -- benchmark"),
];

/// An option that is gone, and what to do now.
const GONE_OPTIONS: [(&str, &str); 2] = [
    ("--cross-order", "cross-heating has the rates of all pairs: --order K"),
    ("--cross-mesh", "cross-heating has the rates of all pairs: --mesh FIRST:LAST"),
];

/// Long option of files until `--output` meant columns everywhere.
const OLD_FILE_OPTION: &str = "--output";

/// Refuses a command line whose spelling is gone, with the one that does the same now.
///
/// `command` is the definition of the command line; `words` are those after `anemo`.
pub fn refusal(command: &clap::Command, words: &[String]) -> Option<Failure> {
    let first = words.first()?.as_str();
    if command.find_subcommand(first).is_none() {
        let begins = |old: &str| old.split(' ').eq(words.iter().take(old.split(' ').count()));
        let moved = MOVED.iter().find(|(old, _)| begins(old)).map(|(old, new)| {
            let rest = words[old.split(' ').count()..].iter().map(|word| format!(" {}", quoted(word)));
            format!("`anemo {old}` is now `anemo {new}`; type: anemo {new}{}", rest.collect::<String>())
        });
        let gone =
            || GONE.iter().find(|(old, _)| *old == first).map(|(old, now)| format!("`anemo {old}` is gone; {now}"));
        return moved.or_else(gone).map(Failure::usage);
    }
    let mut leaf = command;
    for word in words {
        let Some(found) = leaf.find_subcommand(word) else { break };
        leaf = found;
    }
    if let Some((old, now)) =
        GONE_OPTIONS.iter().find(|(old, _)| words.iter().any(|word| word.split('=').next() == Some(old)))
    {
        return Some(Failure::usage(format!("`{old}` is gone; {now}")));
    }
    let has = |long: &str| leaf.get_arguments().any(|argument| argument.get_long() == Some(long));
    let names_old = |word: &String| word == OLD_FILE_OPTION || word.starts_with("--output=");
    if words.iter().any(names_old) && !has("output") && has("output-file") {
        let words = words.iter().map(|word| match word.strip_prefix(OLD_FILE_OPTION) {
            Some(value) if names_old(word) => format!(" --output-file{}", quoted(value)),
            _ => format!(" {}", quoted(word)),
        });
        return Some(Failure::usage(format!(
            "`--output FILE` is now `--output-file FILE` or `-o FILE`; type: anemo{}",
            words.collect::<String>()
        )));
    }
    None
}

/// A word as a shell reads it.
fn quoted(word: &str) -> String {
    let plain = |letter: char| letter.is_alphanumeric() || "-_./:=,+*%@".contains(letter);
    if word.chars().all(plain) { word.to_owned() } else { format!("'{}'", word.replace('\'', r"'\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(line: &str) -> Option<String> {
        let words: Vec<String> = shlex::split(line).unwrap();
        refusal(&crate::command(), &words).map(|failure| {
            assert_eq!(failure.code, 2);
            failure.sentence
        })
    }

    #[test]
    fn a_command_that_moved_is_answered_with_the_whole_new_line() {
        assert_eq!(
            answer("reduce 'my model.json' --order 3").unwrap(),
            "`anemo reduce` is now `anemo model reduce`; type: anemo model reduce 'my model.json' --order 3"
        );
        assert!(answer("settings forget --all").unwrap().ends_with("type: anemo board settings erase --all"));
        assert!(answer("settings show --on qemu").unwrap().ends_with("type: anemo board settings show --on qemu"));
    }

    #[test]
    fn a_command_that_is_gone_is_answered_with_what_does_its_work() {
        assert!(answer("thesis rems-dice").unwrap().ends_with("cargo run --release -p studies -- thesis"));
        assert!(answer("gram a.parquet").unwrap().contains("anemo identify part-*.parquet"));
        assert!(answer("identify a.csv --cross-mesh 1:2").unwrap().ends_with("--mesh FIRST:LAST"));
        assert!(answer("identify a.csv --cross-order=3").unwrap().ends_with("--order K"));
    }

    #[test]
    fn the_long_option_of_files_is_answered_where_it_was_one() {
        assert_eq!(
            answer("run a.toml --on sim --output a.csv").unwrap(),
            "`--output FILE` is now `--output-file FILE` or `-o FILE`; type: anemo run a.toml --on sim --output-file a.csv"
        );
        assert!(answer("head compare a.csv --output=b.json").unwrap().ends_with("--output-file=b.json"));
        assert_eq!(answer("identify a.csv --output sector1"), None);
    }

    #[test]
    fn what_exists_and_what_never_existed_is_left_to_the_parser() {
        assert_eq!(
            [answer("run a.toml --on sim -o a.csv"), answer("blow"), answer("--help"), answer("")],
            [const { None }; 4]
        );
    }

    #[test]
    fn every_answer_leads_to_a_command_that_exists() {
        let root = crate::command();
        for (old, new) in MOVED {
            assert!(old.split(' ').all(|word| root.find_subcommand(word).is_none()), "{old} exists");
            let leaf = new.split(' ').try_fold(&root, |found, word| found.find_subcommand(word));
            assert!(leaf.is_some(), "{new} does not exist");
        }
        assert!(GONE.iter().all(|(old, _)| root.find_subcommand(old).is_none()));
        // Files that the answers name are there.
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let named = GONE.iter().flat_map(|(_, now)| now.split(' ')).filter(|word| word.contains('/'));
        for file in named {
            assert!(folder.join(file).is_file(), "{file}");
        }
    }
}
