//! Compares the features that builds of parts of the workspace choose for the same packages.
//!
//! Cargo chooses them anew for each set of crates that it builds. Where one package differs, it and
//! all that depend on it are compiled twice: once for the tests, once for the command alone or for
//! the Python package. A feature that one part wants is therefore named in `crates/anemo/Cargo.toml`.

use crate::shell;
use anyhow::{Result, bail};
use std::collections::BTreeSet;

/// Builds whose packages must be those of all tests.
const PARTS: [&[&str]; 3] = [
    &["--edges", "normal,build", "-p", "anemo"],
    &["--edges", "normal,build", "-p", "anemo-python"],
    &["--edges", "normal,build,dev", "--workspace", "--exclude", "anemo-python", "--exclude", "silicon"],
];
const ALL: [&str; 5] = ["--edges", "normal,build,dev", "--workspace", "--exclude", "anemo-python"];

pub fn run() -> Result<()> {
    let all = packages(&ALL)?;
    let mut faults = Vec::new();
    for part in PARTS {
        let part_packages = packages(part)?;
        let others = others(&all, &part_packages);
        faults.extend(others.iter().map(|package| format!("cargo tree {}: {package}", part.join(" "))));
    }
    if !faults.is_empty() {
        bail!("features differ from those of the tests; name them in crates/anemo/Cargo.toml:\n{}", faults.join("\n"));
    }
    Ok(())
}

/// Lines `name version|features` of `cargo tree`.
fn packages(selection: &[&str]) -> Result<BTreeSet<String>> {
    let mut tree = shell::cargo();
    tree.args(["tree", "--prefix", "none", "--format", "{p}|{f}"]).args(selection);
    Ok(shell::captured(&mut tree)?.lines().filter_map(package).collect())
}

/// A line without the folder and the kind of a crate.
fn package(line: &str) -> Option<String> {
    let (package, features) = line.trim_end_matches(" (*)").split_once('|')?;
    let mut words = package.split(' ');
    Some(format!("{} {}|{features}", words.next()?, words.next()?))
}

/// Packages of a part that are among all, but with other features only.
fn others<'a>(all: &BTreeSet<String>, part: &'a BTreeSet<String>) -> Vec<&'a String> {
    let name = |line: &str| line.split('|').next().unwrap_or_default().to_owned();
    let known: BTreeSet<String> = all.iter().map(|line| name(line)).collect();
    part.iter().filter(|line| !all.contains(*line) && known.contains(&name(line))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_package_with_other_features_is_found() {
        let set = |lines: &[&str]| lines.iter().filter_map(|line| package(line)).collect::<BTreeSet<_>>();
        let all = set(&["syn v2.0.1|full", "syn v3.0.1|", "a v0.1.0 (/x/a)|", "m v1.0.0 (proc-macro)|"]);
        let part = set(&["syn v2.0.1|", "syn v3.0.1|", "a v0.1.0 (/y/a)|", "m v1.0.0| (*)", "pyo3 v1.0.0|abi3"]);
        assert_eq!(others(&all, &part), [&"syn v2.0.1|".to_owned()]);
    }
}
