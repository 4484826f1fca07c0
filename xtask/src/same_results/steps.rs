//! The chain of analyses, which stands in `steps.toml`.

use anyhow::{Context, Result};
use serde::Deserialize;

/// One analysis; `steps.toml` says what its arguments may name.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AnalysisStep {
    pub name: String,
    /// The subcommand.
    pub command: String,
    /// What it was called before, taken where the newer name is not known.
    pub older_command: Option<String>,
    pub arguments: Vec<String>,
    /// Whether it takes minutes, or stands on one that does: left out unless it is asked for.
    #[serde(default)]
    pub is_long: bool,
}

impl AnalysisStep {
    /// The table of comma-separated values that it writes.
    pub fn table(&self) -> Option<&String> {
        self.arguments.last().filter(|path| path.ends_with(".csv"))
    }
}

/// All steps in their order.
pub fn read() -> Result<Vec<AnalysisStep>> {
    #[derive(Deserialize)]
    struct Chain {
        steps: Vec<AnalysisStep>,
    }
    let chain: Chain = toml::from_str(include_str!("steps.toml")).context("steps.toml cannot be read")?;
    Ok(chain.steps)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shell;
    use std::collections::BTreeSet;

    #[test]
    fn every_recording_is_of_an_experiment_that_there_is() {
        let experiments = shell::root().join("experiments");
        let files = crate::sources::files_with_extension(&experiments, "toml").expect("the experiments");
        let name = |path: &std::path::PathBuf| {
            path.strip_prefix(&experiments).expect("below").with_extension("").to_string_lossy().replace('/', "-")
        };
        let known: BTreeSet<String> = files.iter().map(name).collect();
        let steps = read().expect("the steps");
        assert!(!steps.is_empty());
        for argument in steps.iter().flat_map(|step| &step.arguments) {
            if let Some(recording) = argument.strip_prefix("{recordings}/") {
                assert!(known.contains(recording.trim_end_matches(".parquet")), "{recording}");
            }
            if let Some(fixture) = argument.strip_prefix("{fixtures}/") {
                assert!(shell::root().join("tests/fixtures").join(fixture).is_file(), "{fixture}");
            }
            if let Some(experiment) = argument.strip_prefix("{experiments}/") {
                assert!(experiments.join(experiment).is_file(), "{experiment}");
            }
        }
    }
}
