//! What a sweep amounts to, for people and as JSON.

use std::fmt;
use std::path::PathBuf;

use recording::text::{brief, count};
use serde::Serialize;

/// So many lines of one kind are shown to people; all are in the table and in the JSON.
const MOST_LINES: usize = 20;

/// What a sweep amounts to.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SweepReport {
    /// Of the sweep.
    pub title: String,
    /// How many runs it has.
    pub runs: usize,
    /// How many are complete.
    pub complete: usize,
    /// Those that failed.
    pub failed: Vec<RunNote>,
    /// Those that are not done yet, by shard.
    pub missing: Vec<MissingShard>,
    /// Numbers that stand apart.
    pub outliers: Vec<FoundOutlier>,
    /// The table of results; empty if there is none yet.
    pub results: PathBuf,
}

/// A run, and what to say of it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct RunNote {
    /// Its hash.
    pub run: String,
    /// Its keys with their values.
    pub keys: String,
    /// A sentence.
    pub sentence: String,
}

/// Runs that a shard has not done.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct MissingShard {
    /// Its number, from 1.
    pub shard: usize,
    /// The number of shards.
    pub of: usize,
    /// How many of its runs are missing.
    pub missing: usize,
    /// How many it has.
    pub runs: usize,
}

/// A number that is far from those of the other runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FoundOutlier {
    /// Hash of the run.
    pub run: String,
    /// Its keys with their values.
    pub keys: String,
    /// The column.
    pub column: String,
    /// What stands there.
    pub value: f64,
    /// What stands there in the middle of all.
    pub median: f64,
    /// Distance in units of 1.4826 times the median deviation.
    pub z: f64,
}

impl SweepReport {
    /// What is missing, in a sentence.
    pub fn incomplete(&self) -> Option<String> {
        let part = |shard: &MissingShard| match shard.of {
            1 => format!("{} of {}", shard.missing, shard.runs),
            _ => format!("{} of {} in shard {}/{}", shard.missing, shard.runs, shard.shard, shard.of),
        };
        let parts: Vec<String> = self.missing.iter().map(part).collect();
        (!parts.is_empty()).then(|| {
            format!(
                "runs are missing: {}; the others are kept, and the same command does those that are missing",
                recording::text::listed(&parts, MOST_LINES)
            )
        })
    }
}

impl fmt::Display for SweepReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let missing: usize = self.missing.iter().map(|shard| shard.missing).sum();
        writeln!(
            f,
            "{} · {}: {} complete, {} failed, {missing} missing",
            self.title,
            count(self.runs, "run"),
            self.complete,
            self.failed.len()
        )?;
        for RunNote { run, keys, sentence } in self.failed.iter().take(MOST_LINES) {
            writeln!(f, "failed: {} ({keys}): {sentence}", short(run))?;
        }
        more(f, self.failed.len())?;
        for FoundOutlier { run, keys, column, value, median, z } in self.outliers.iter().take(MOST_LINES) {
            let (value, median) = (brief(*value), brief(*median));
            writeln!(f, "outlier: {} ({keys}): {column} is {value}, the median {median}: z = {z:.0}", short(run))?;
        }
        more(f, self.outliers.len())?;
        if !self.results.as_os_str().is_empty() {
            writeln!(f, "results: {}", self.results.display())?;
        }
        Ok(())
    }
}

/// As much of a hash as tells runs apart.
fn short(hash: &str) -> &str {
    hash.get(..8).unwrap_or(hash)
}

fn more(f: &mut fmt::Formatter<'_>, lines: usize) -> fmt::Result {
    if lines > MOST_LINES { writeln!(f, "… and {} more", lines - MOST_LINES) } else { Ok(()) }
}
