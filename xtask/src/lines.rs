//! How many lines of code the project has, crate by crate.
//!
//! A line of code is any that is neither empty nor a comment alone (`//`, `///`, `//!`) and does
//! not belong to tests, as [`crate::sources`] tells them: a crate's `tests/`, `benches/` and
//! `examples/`, the crates `tests`, `fuzz` and `silicon` as a whole, `tests.rs`, and what stands
//! below `#[cfg(test)]`. Doc comments are counted beside it, and of tests all lines. Only Rust
//! counts, every `.rs` file of it, formatted: no tables, texts or TOML.

use crate::sources::{self, RustFile};
use anyhow::{Result, bail};
use std::collections::BTreeMap;

/// What the project means to come down to.
const BAR_LINES: usize = 41_000;
/// What it has come down to: more lines of code are refused. Lower it with every deletion; raise it
/// only for what somebody can do with the new lines.
const MOST_LINES: usize = 85_300;
/// A crate that is there to test another: its lines are tests as a whole.
const TEST_EQUIPMENT: &str = "silicon";

#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct LineCount {
    code: usize,
    doc_comments: usize,
    tests: usize,
}

pub fn run() -> Result<()> {
    let counts = count(&sources::rust_files()?);
    let mut all = LineCount::default();
    let line = |name: &str, count: &LineCount| {
        println!("{name:<16} {:>8} {:>12} {:>8}", count.code, count.doc_comments, count.tests);
    };
    println!("{:<16} {:>8} {:>12} {:>8}", "crate", "code", "doc comments", "tests");
    for (name, count) in &counts {
        line(name, count);
        all.code += count.code;
        all.doc_comments += count.doc_comments;
        all.tests += count.tests;
    }
    line("all", &all);
    judge(all.code)
}

fn judge(code: usize) -> Result<()> {
    if code > MOST_LINES {
        bail!(
            "{code} lines of code, {MOST_LINES} are allowed (`MOST_LINES` in xtask/src/lines.rs); delete what is superseded"
        );
    }
    println!("{code} lines of code; {BAR_LINES} are the bar, {MOST_LINES} are allowed");
    Ok(())
}

/// By crate, which is the first folder of a path.
fn count(files: &[RustFile]) -> BTreeMap<String, LineCount> {
    let mut counts: BTreeMap<String, LineCount> = BTreeMap::new();
    for file in files {
        let name = file.path.split('/').next().unwrap_or_default();
        let count = counts.entry(name.to_owned()).or_default();
        for (line, &is_test) in file.text.lines().zip(&file.in_tests) {
            let is_test = is_test || name == TEST_EQUIPMENT;
            let line = line.trim();
            if is_test {
                count.tests += 1;
            } else if line.starts_with("///") || line.starts_with("//!") {
                count.doc_comments += 1;
            } else if !line.is_empty() && !line.starts_with("//") {
                count.code += 1;
            }
        }
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_is_code_or_doc_comment_or_test_or_nothing() {
        let text = "//! Doc.\n\n// Why.\n/// Doc.\nfn f() {} // code\n".to_owned();
        let files = [
            RustFile { path: "a/src/lib.rs".into(), text: text.clone(), in_tests: vec![false; 5] },
            RustFile { path: "a/src/b.rs".into(), text: text.clone(), in_tests: vec![false, false, true, true, true] },
            RustFile { path: "c/src/lib.rs".into(), text, in_tests: vec![true; 5] },
        ];
        let counts = count(&files);
        assert_eq!(counts["a"], LineCount { code: 1, doc_comments: 3, tests: 3 });
        assert_eq!(counts["c"], LineCount { code: 0, doc_comments: 0, tests: 5 });
    }

    #[test]
    fn one_line_too_many_is_refused() {
        assert!(judge(MOST_LINES).is_ok());
        let error = judge(MOST_LINES + 1).expect_err("one too many").to_string();
        assert!(error.starts_with(&format!("{} lines of code, {MOST_LINES} are allowed", MOST_LINES + 1)), "{error}");
    }
}
