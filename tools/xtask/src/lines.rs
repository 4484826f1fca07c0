//! Lines of code and words of pages, crate by crate and folder by folder.
//!
//! Every column counts lines of code: those that are neither blank nor begin as a comment. A crate
//! is the folder of the nearest `Cargo.toml`.
//!
//! - code: Rust sources of libraries and binaries, Python packages, scripts of the pages
//! - doc comments: `///`, `//!` and docstrings of code
//! - tests: as [`crate::sources`] tells them, crates that are there to test others, Python's tests
//! - examples: `examples/` and `benches/` of crates, and the Python package's gallery. What moves
//!   there is still there
//! - generated: Python that a job writes; no part of `all`
//!
//! Words are those of README.md, CONTRIBUTING.md and all pages of `docs`.

use crate::sources::{self, LineKind, RustFile};
use crate::{pages, shell};
use anyhow::{Context, Result};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Crates that are there to test others.
const TEST_EQUIPMENT: [&str; 3] = ["fuzz", "silicon", "tests"];
/// First line of a file that a job has written.
const GENERATED_MARK: &str = "# Written by `cargo xtask";

#[derive(clap::Args, Default)]
pub struct LinesOptions {
    /// Count this checkout instead of this tree
    #[arg(long, value_name = "FOLDER")]
    root: Option<PathBuf>,
}

/// Lines by column.
type LineCount = [usize; COLUMNS.len()];
const COLUMNS: [&str; 5] = ["code", "doc comments", "tests", "examples", "generated"];
const CODE: usize = 0;
const DOC_COMMENTS: usize = 1;
const TESTS: usize = 2;
const EXAMPLES: usize = 3;
const GENERATED: usize = 4;

pub fn run(options: &LinesOptions) -> Result<()> {
    let root = options.root.clone().unwrap_or_else(shell::root);
    let mut counts: BTreeMap<String, LineCount> = BTreeMap::new();
    for file in sources::rust_files(&root)? {
        add_rust(counts.entry(name(&file.crate_folder)).or_default(), &file);
    }
    for extension in ["py", "pyi"] {
        for path in sources::files_with_extension(&root, extension)? {
            let text = read(&path)?;
            let path = path.strip_prefix(&root).unwrap_or(&path).to_string_lossy().replace('\\', "/");
            add_python(counts.entry(name(&sources::crate_folder(&root, &path))).or_default(), &path, &text);
        }
    }
    let all: LineCount = std::array::from_fn(|column| counts.values().map(|count| count[column]).sum());
    let print = |name: &str, cells: [String; COLUMNS.len()]| {
        let [code, docs, tests, examples, generated] = cells;
        println!("{name:<16} {code:>8} {docs:>12} {tests:>8} {examples:>8} {generated:>9}");
    };
    print("lines", COLUMNS.map(str::to_owned));
    counts.iter().for_each(|(name, count)| print(name, count.map(|lines| lines.to_string())));
    print("all", all.map(|lines| lines.to_string()));
    let mut words: BTreeMap<String, usize> = BTreeMap::new();
    for path in pages::all(&root)? {
        let page = path.strip_prefix(&root).unwrap_or(&path).with_extension("");
        let place = page.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(&page);
        *words.entry(place.display().to_string()).or_default() += read(&path)?.split_whitespace().count();
    }
    println!("\nwords");
    words.iter().for_each(|(place, words)| println!("{place:<24} {words:>8}"));
    println!("{:<24} {:>8}", "all", words.values().sum::<usize>());
    Ok(())
}

fn read(path: &Path) -> Result<String> {
    std::fs::read_to_string(path).with_context(|| format!("{} cannot be read", path.display()))
}

/// Last folder of a path, under which a crate is known wherever it lies.
fn name(folder: &str) -> String {
    folder.rsplit('/').next().unwrap_or(folder).to_owned()
}

fn add_rust(count: &mut LineCount, file: &RustFile) {
    let is_equipment = TEST_EQUIPMENT.contains(&name(&file.crate_folder).as_str());
    for (kind, &is_test) in file.kinds.iter().zip(&file.in_tests) {
        match kind {
            LineKind::Code if file.is_example() => count[EXAMPLES] += 1,
            LineKind::Code => count[if is_test || is_equipment { TESTS } else { CODE }] += 1,
            LineKind::Documentation if !is_test && !is_equipment => count[DOC_COMMENTS] += 1,
            LineKind::Documentation | LineKind::Empty => (),
        }
    }
}

fn add_python(count: &mut LineCount, path: &str, text: &str) {
    let is_in = |folders: &[&str]| path.split('/').rev().skip(1).any(|part| folders.contains(&part));
    let (mut code, mut docstrings) = (0, 0);
    // Kind of the text between triple quotes that a line begins within.
    let mut open = None;
    for line in text.lines().map(str::trim) {
        let quotes = line.matches("\"\"\"").count();
        let kind = match open {
            _ if line.is_empty() => continue,
            Some(kind) => kind,
            None if line.starts_with('#') => continue,
            None if line.trim_start_matches('r').starts_with("\"\"\"") => LineKind::Documentation,
            None => LineKind::Code,
        };
        *(if kind == LineKind::Code { &mut code } else { &mut docstrings }) += 1;
        if quotes % 2 == 1 {
            open = if open.is_none() { Some(kind) } else { None };
        }
    }
    let column = match () {
        () if text.starts_with(GENERATED_MARK) => GENERATED,
        () if is_in(&["tests"]) => TESTS,
        () if is_in(&["examples", "benches", "gallery"]) => EXAMPLES,
        () => {
            count[DOC_COMMENTS] += docstrings;
            CODE
        }
    };
    count[column] += code;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_is_code_or_doc_comment_or_test_or_example_or_nothing() {
        use LineKind::{Code, Documentation, Empty};
        let count = |path: &str, crate_folder: &str, in_tests: [bool; 5]| {
            let mut count = LineCount::default();
            let kinds = vec![Documentation, Empty, Documentation, Code, Code];
            let (path, crate_folder, text) = (path.into(), crate_folder.into(), String::new());
            add_rust(&mut count, &RustFile { path, crate_folder, text, in_tests: in_tests.to_vec(), kinds });
            (count[CODE], count[DOC_COMMENTS], count[TESTS], count[EXAMPLES])
        };
        assert_eq!(count("crates/a/src/lib.rs", "crates/a", [false; 5]), (2, 2, 0, 0));
        assert_eq!(count("a/src/b.rs", "a", [false, false, true, true, false]), (1, 1, 1, 0));
        assert_eq!(count("a/benches/b.rs", "a", [true; 5]), (0, 0, 0, 2));
        assert_eq!(count("tools/silicon/src/b.rs", "tools/silicon", [false; 5]), (0, 0, 2, 0));
    }

    #[test]
    fn docstrings_are_told_from_texts_and_generated_files_from_written_ones() {
        let text =
            "\"\"\"Doc.\n\n# still\n\"\"\"\n# why\nA = \"\"\"\n# text\n\"\"\"\ndef f():\n    r\"\"\"Doc.\"\"\"\n";
        let count = |path: &str, text: &str| {
            let mut count = LineCount::default();
            add_python(&mut count, path, text);
            count
        };
        assert_eq!(count("p/a.py", text), [4, 4, 0, 0, 0]);
        assert_eq!(count("p/tests/a.py", text), [0, 0, 4, 0, 0]);
        assert_eq!(count("p/gallery/a.py", text), [0, 0, 0, 4, 0]);
        let written = format!("{GENERATED_MARK} reference`.\n{text}");
        assert_eq!(count("p/a.py", &written), [0, 0, 0, 0, 4]);
    }
}
