//! Mutants of the sensor board's own files and of its drivers.
//!
//! cargo-mutants finds them, but cannot try them: no host compiles the former, and its tests of the
//! drivers know no registers. `mutants.toml` says which files, and leaves out with a reason what
//! nobody could notice.

use super::change::{SeededChange, read};
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

/// As `cargo mutants --list --json` prints them.
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

/// Keeps so many. A mutant's rank hangs on its name and the seed only, so that others that come or
/// go change little of a sample.
pub fn sample(changes: &mut Vec<SeededChange>, count: usize, seed: u64) {
    changes.sort_by_key(|change| rank(&change.name, seed));
    changes.truncate(count);
}

/// Hash FNV-1a of 64 bits.
fn rank(name: &str, seed: u64) -> u64 {
    let bytes = seed.to_le_bytes().into_iter().chain(name.bytes());
    bytes.fold(0xCBF2_9CE4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3))
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

    #[test]
    fn a_sample_hangs_on_the_seed_only() {
        assert_eq!(rank("", 0), rank("", 0));
        assert_ne!(rank("a", 1), rank("a", 2));
        assert_ne!(rank("a", 1), rank("b", 1));
    }
}
