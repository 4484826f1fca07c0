//! Which crates of the workspace there are, and which of a few heavy dependencies each brings
//! along, itself or by another one.
//!
//! The dependencies are those of a crate that is built for itself with its default features (`cargo
//! tree`): what somebody gets who wants that crate only.

use crate::shell;
use anyhow::Result;
use std::collections::BTreeSet;

const WATCHED: [&str; 6] = ["clap", "nix", "parquet", "plotters", "serialport", "unicorn-engine"];

/// All crates, and what each has of [`WATCHED`].
const CRATES: [(&str, &[&str]); 17] = [
    ("dr-core", &[]),
    ("wire", &[]),
    ("firmware", &[]),
    ("recording", &["parquet"]),
    ("diffusive", &["parquet"]),
    ("anemometry", &["parquet"]),
    ("plot", &["parquet"]),
    ("host-sim", &["nix", "parquet", "serialport"]),
    ("publish", &["nix", "serialport"]),
    ("dielectric", &["nix", "parquet", "serialport"]),
    ("anemo", &["clap", "nix", "parquet", "serialport"]),
    ("anemo-python", &["clap", "nix", "parquet", "serialport"]),
    ("studies", &["clap", "nix", "parquet", "serialport"]),
    ("anemo-tests", &["clap", "nix", "parquet", "serialport"]),
    ("xtask", &["clap"]),
    ("image-analysis", &[]),
    // The one crate that may depend on code under the GPL: nothing that is shipped depends on it.
    ("silicon", &["nix", "parquet", "serialport", "unicorn-engine"]),
];

pub fn find() -> Result<Vec<String>> {
    let (mut faults, present) = (Vec::new(), tree(&["--workspace", "--depth", "0"])?);
    let present = first_words(&present);
    for package in &present {
        match CRATES.iter().find(|(known, _)| known == package) {
            Some((_, listed)) => faults.extend(compare(package, listed, &tree(&["-p", package])?)),
            None => faults.push(format!("{package} is a crate that is not on the list; {LIST}")),
        }
    }
    let missing = CRATES.iter().filter(|(known, _)| !present.contains(known));
    faults.extend(missing.map(|(known, _)| format!("there is no crate {known}; {LIST}")));
    Ok(faults)
}

const LIST: &str = "make it, or change `CRATES` in tools/xtask/src/structure/dependencies.rs and say why";

/// What differs between a crate's list and its dependencies, as `cargo tree --prefix none` prints
/// them.
fn compare(package: &str, listed: &[&str], tree: &str) -> Vec<String> {
    let names = first_words(tree);
    let fault = |dependency: &&str| match (names.contains(dependency), listed.contains(dependency)) {
        (true, false) => Some(format!(
            "{package} depends on {dependency}, which is not on its list; `cargo tree -p {package} -e normal -i {dependency}` shows how"
        )),
        (false, true) => Some(format!(
            "{package} does not depend on {dependency} any more: take it off its list in tools/xtask/src/structure/dependencies.rs"
        )),
        _ => None,
    };
    WATCHED.iter().filter_map(fault).collect()
}

/// The packages that `cargo tree` prints, each on a line with its version.
fn first_words(tree: &str) -> BTreeSet<&str> {
    tree.lines().filter_map(|line| line.split(' ').next().filter(|name| !name.is_empty())).collect()
}

fn tree(packages: &[&str]) -> Result<String> {
    let mut cargo = shell::cargo();
    shell::captured(cargo.args(["tree", "--quiet", "-e", "normal", "--prefix", "none"]).args(packages))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dependency_too_many_and_one_too_few_are_named() {
        let tree = "diffusive v0.1.0 (/p/diffusive)\nserde v1.0.0\nnix v0.31.0\nserialport-not v1.0.0 (*)\n";
        let faults = compare("diffusive", &["parquet"], tree);
        assert_eq!(faults.len(), 2, "{faults:?}");
        assert!(faults[0].starts_with("diffusive depends on nix, which is not on its list"), "{faults:?}");
        assert!(faults[1].starts_with("diffusive does not depend on parquet any more"), "{faults:?}");
        assert!(compare("diffusive", &["nix"], tree).is_empty());
    }

    #[test]
    fn models_and_records_come_without_commands_ports_and_pictures() {
        for name in ["recording", "diffusive", "anemometry"] {
            let (_, listed) = CRATES.iter().find(|(folder, _)| *folder == name).expect("it is on the list");
            assert!(listed.iter().all(|dependency| *dependency == "parquet"), "{name}");
        }
    }
}
