//! Compares the features that builds of parts of the workspace choose for the same packages.
//!
//! Cargo chooses them anew for each set of crates that it builds. Where one package differs, it and
//! all that depend on it are compiled twice: once for the tests, once for the command or for the
//! Python package. `tests/Cargo.toml` and `python/Cargo.toml` name what the other builds want.

use crate::programs::{Tier, cargo_test};
use crate::{artefacts, shell};
use anyhow::{Context, Result, bail};
use std::collections::BTreeSet;
use std::process::Command;

pub fn run() -> Result<()> {
    let test_job = |tier| {
        let mut cargo = cargo_test(tier);
        cargo.arg("--no-run");
        cargo
    };
    let mut wheel = shell::cargo();
    wheel.args(["build", "--release", "-p", "anemo-python"]);
    let all = units(test_job(Tier::Ci))?;
    let mut faults = Vec::new();
    for (what, part) in [
        ("tests without the emulated core", test_job(Tier::Test)),
        ("the command", artefacts::build_of_anemo()),
        ("the Python package", wheel),
    ] {
        faults.extend(others(&all, &units(part)?).into_iter().map(|unit| format!("{what}: {unit}")));
    }
    if !faults.is_empty() {
        bail!("features differ from those of the tests; tests/Cargo.toml says how:\n{}", faults.join("\n"));
    }
    Ok(())
}

/// Units that a job of cargo would compile, as `package target|features`.
fn units(mut cargo: Command) -> Result<BTreeSet<String>> {
    // The graph is not stable yet.
    cargo.args(["--unit-graph", "-Zunstable-options"]).env("RUSTC_BOOTSTRAP", "1");
    let graph: serde_json::Value = serde_json::from_str(&shell::captured(&mut cargo)?).context("no graph")?;
    let unit = |unit: &serde_json::Value| {
        format!("{} {} {}|{}", unit["pkg_id"], unit["target"]["name"], unit["mode"], unit["features"])
    };
    Ok(graph["units"].as_array().into_iter().flatten().map(unit).collect())
}

/// Units of a part that are among all, but with other features only.
fn others<'a>(all: &BTreeSet<String>, part: &'a BTreeSet<String>) -> Vec<&'a String> {
    let name = |unit: &str| unit.split('|').next().unwrap_or_default().to_owned();
    let known: BTreeSet<String> = all.iter().map(|unit| name(unit)).collect();
    part.iter().filter(|unit| !all.contains(*unit) && known.contains(&name(unit))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_builds_choose_the_same_features() {
        run().expect("they do");
    }

    #[test]
    fn a_package_with_other_features_is_found() {
        let set = |units: &[&str]| units.iter().map(|&unit| unit.to_owned()).collect::<BTreeSet<_>>();
        let all = set(&["syn@2 syn|full", "syn@3 syn|"]);
        let part = set(&["syn@2 syn|", "syn@3 syn|", "pyo3@1 pyo3|abi3"]);
        assert_eq!(others(&all, &part), [&"syn@2 syn|".to_owned()]);
    }
}
