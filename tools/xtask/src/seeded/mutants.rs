//! Mutants of the sensor board's own files and of its drivers.
//!
//! cargo-mutants finds them, but cannot try them: no host compiles the former, and its tests of the
//! drivers know no registers. `mutants.toml` says which files, and leaves out with a reason what
//! nobody could notice.

use super::{SeededChange, read};
use crate::{install, shell};
use anyhow::{Context, Result};
use serde::Deserialize;

/// Modules of `tools/silicon/tests/scenarios`, the quickest first: most mutants end in the first two.
const SCENARIOS: [&str; 12] = [
    "boot::",
    "ticks::",
    "front_end::",
    "supply::",
    "guard::",
    "stop::",
    "proof::",
    "supervision::",
    "crashes::",
    "self_test::",
    "cut_off::",
    "settings::",
];

/// Mutant as `cargo mutants --list --json` prints it.
#[derive(Deserialize)]
struct Mutant {
    name: String,
    file: String,
    span: Span,
    replacement: String,
}

#[derive(Deserialize)]
struct Span {
    start: TextPlace,
    /// Behind the last character.
    end: TextPlace,
}

/// Both from 1, the column in characters.
#[derive(Deserialize)]
struct TextPlace {
    line: usize,
    column: usize,
}

impl TextPlace {
    /// Byte of a text.
    fn offset(&self, text: &str) -> Option<usize> {
        let line = text.split_inclusive('\n').nth(self.line.checked_sub(1)?)?;
        let before: usize = text.split_inclusive('\n').take(self.line - 1).map(str::len).sum();
        let within: usize = line.chars().take(self.column.checked_sub(1)?).map(char::len_utf8).sum();
        Some(before + within)
    }
}

impl Mutant {
    fn seeded(self) -> Result<SeededChange> {
        let sound = read(&shell::root().join(&self.file))?;
        let text = self.applied_to(&sound).with_context(|| format!("{}: its place is not in the file", self.name))?;
        let scenarios = SCENARIOS.map(String::from).to_vec();
        // A driver's own tests run on the host, and are quicker.
        let has_unit_tests = self.file.contains("/drivers/");
        Ok(SeededChange { name: self.name, path: self.file, text, has_unit_tests, scenarios, shows: String::new() })
    }

    fn applied_to(&self, sound: &str) -> Option<String> {
        let (start, end) = (self.span.start.offset(sound)?, self.span.end.offset(sound)?);
        Some([sound.get(..start)?, &self.replacement, sound.get(end..)?].concat())
    }
}

/// All mutants, or those of a shard.
pub fn list(shard: Option<&str>) -> Result<Vec<SeededChange>> {
    let mut mutants = shell::program(install::tool(&install::CARGO_MUTANTS)?);
    mutants.args([
        "mutants",
        "--config",
        "tools/xtask/src/seeded/mutants.toml",
        "--package",
        "firmware",
        "--list",
        "--json",
    ]);
    mutants.args(shard.iter().flat_map(|shard| ["--shard", shard]));
    let mutants: Vec<Mutant> = serde_json::from_str(&shell::captured(&mut mutants)?)?;
    mutants.into_iter().map(Mutant::seeded).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mutant_replaces_its_span_in_characters() {
        let json = r#"{"name": "n", "file": "f", "function": null, "genre": "BinaryOperator", "replacement": "!=",
            "span": {"start": {"line": 2, "column": 7}, "end": {"line": 2, "column": 9}}}"#;
        let mutant: Mutant = serde_json::from_str(json).expect("a mutant");
        assert_eq!(mutant.applied_to("// µ\n/*µ*/ == b").as_deref(), Some("// µ\n/*µ*/ != b"));
        assert_eq!(mutant.applied_to("one line"), None);
    }
}
