//! Programs of tests, and to which tier each belongs.
//!
//! The tier `test` runs the unit tests and every program in a crate's folder `tests` but those of
//! [`CI`]. Tests that take long in either are marked `#[ignore = "nightly: …"]`.

use crate::artefacts::{self, FirmwareBoard};
use crate::pages::PagePrograms;
use crate::{install, shell};
use anyhow::{Context, Result};
use std::path::PathBuf;
use std::process::Command;

/// Programs that only `ci` runs: what crosses crates, the image on models of its chips, other
/// people's programs, examples.
const CI: [&str; 6] = ["all", "chains", "counterparts", "examples", "rules", "scenarios"];
/// The crate whose emulated core wants cmake and libclang.
const EMULATED: &str = "silicon";
/// Folder of measured records, which the tests' `shared_data` looks for by itself, too.
const SHARED_DATA: [&str; 2] = ["ANEMO_SHARED_DATA", "../shared/data"];

/// Tier of tests.
#[derive(Clone, Copy, PartialEq)]
pub enum Tier {
    /// All but the emulated core, which need not be built, and but the programs of `ci`.
    Test,
    /// Everything.
    Ci,
}

/// Programs of tests, built, with what they start.
pub struct TestPrograms {
    tier: Tier,
    anemo: PathBuf,
    firmware: PathBuf,
    sensor_firmware: PathBuf,
    /// Programs that the tier `test` runs.
    quick: Vec<String>,
}

impl TestPrograms {
    /// Builds the firmware and all programs of a tier at once.
    pub fn build(tier: Tier) -> Result<Self> {
        install::thumb_target()?;
        let quick = quick_programs()?;
        let mut cargo = cargo_test(tier);
        select(cargo.args(["--no-run", "--lib"]), &quick);
        if tier == Tier::Ci {
            select(&mut cargo, &CI);
        }
        let build = || artefacts::executable(&mut cargo, "anemo");
        let ([firmware, sensor_firmware], anemo) = shell::both(images, build)?;
        Ok(Self { tier, anemo, firmware, sensor_firmware, quick })
    }

    /// Examples in the documentation.
    pub fn documentation(&self) -> Command {
        self.command(&["--doc"])
    }

    /// Unit tests, and the programs of the tier `test`.
    pub fn quick(&self) -> Command {
        let mut cargo = self.command(&["--lib", "--no-fail-fast"]);
        select(&mut cargo, &self.quick);
        cargo
    }

    /// The programs that only `ci` runs.
    pub fn slow(&self) -> Command {
        let mut cargo = self.command(&["--no-fail-fast"]);
        select(&mut cargo, &CI);
        cargo
    }

    /// All of them at once.
    pub fn all(&self) -> Command {
        let mut cargo = self.quick();
        select(&mut cargo, &CI);
        cargo
    }

    /// Runs tests with what they start; options of cargo choose them.
    pub fn command(&self, options: &[&str]) -> Command {
        let mut cargo = cargo_test(self.tier);
        cargo.args(options);
        cargo.env("ANEMO_BIN", &self.anemo).env("ANEMO_FIRMWARE", &self.firmware);
        cargo.env("ANEMO_SENSOR_FIRMWARE", &self.sensor_firmware);
        // Its name in the environment turns a record that a test does not find into a failure.
        let [variable, folder] = SHARED_DATA;
        if let Ok(folder) = shell::root().join(folder).canonicalize() {
            cargo.env(variable, folder);
        }
        cargo
    }

    /// Programs that the commands in pages run.
    pub fn of_pages(&self) -> Result<PagePrograms> {
        let (anemo, firmware) = (self.anemo.clone(), self.firmware.clone());
        Ok(PagePrograms { anemo, interface: artefacts::interface()?, firmware })
    }
}

/// The emulator, which comes out of the network, and images for it and for the models of the chips.
pub fn images() -> Result<[PathBuf; 2]> {
    install::qemu()?;
    // For `safety`, which comes next, and for the two cores.
    for bin in ["overflow", "verdicts"] {
        artefacts::image(bin, FirmwareBoard::Virtual)?;
    }
    Ok([artefacts::firmware(FirmwareBoard::Virtual)?, artefacts::firmware(FirmwareBoard::Sensor)?])
}

/// A job of `cargo test` for the crates of a tier.
pub fn cargo_test(tier: Tier) -> Command {
    let mut cargo = shell::cargo_of_all("test");
    // Its own tests run in the profile in which it is built already.
    cargo.args(["--exclude", "xtask"]);
    if tier == Tier::Test {
        cargo.args(["--exclude", EMULATED]);
    }
    cargo
}

fn select<'a>(cargo: &'a mut Command, programs: &[impl AsRef<str>]) -> &'a mut Command {
    cargo.args(programs.iter().flat_map(|program| ["--test", program.as_ref()]))
}

/// Names of the programs of tests that are not among those of `ci`.
fn quick_programs() -> Result<Vec<String>> {
    let told = shell::captured(shell::cargo().args(["metadata", "--no-deps", "--format-version=1"]))?;
    let told: serde_json::Value = serde_json::from_str(&told).context("`cargo metadata` prints no JSON")?;
    let packages = told["packages"].as_array().into_iter().flatten();
    let targets = packages.flat_map(|package| package["targets"].as_array().into_iter().flatten());
    let programs = targets.filter(|target| target["kind"][0] == "test").filter_map(|target| target["name"].as_str());
    let mut quick: Vec<String> = programs.filter(|name| !CI.contains(name)).map(str::to_owned).collect();
    quick.sort();
    quick.dedup();
    Ok(quick)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn programs_of_crates_are_of_one_tier_or_the_other() {
        let quick = quick_programs().expect("cargo runs");
        assert!(quick.contains(&"command".to_owned()) && quick.contains(&"host_and_board".to_owned()), "{quick:?}");
        assert!(CI.iter().all(|name| !quick.iter().any(|quick| quick == name)));
    }
}
