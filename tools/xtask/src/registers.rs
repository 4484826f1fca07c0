//! Registers that the sensor board's image uses in all scenarios, held against ST's description of
//! the chip and against the crate of its registers: `tools/xtask/registers.py`.

use crate::programs::{self, Tier};
use crate::{install, shell};
use anyhow::{Context, Result};
use std::path::{Path, PathBuf};
use std::process::Command;

const CHECK: &str = "tools/xtask/registers.py";
/// The last version that carries descriptions, and ST's of the STM32F405 in it.
const DESCRIPTIONS: &str = "cmsis-svd==0.4";
const ARCHIVE: &str = "cmsis-svd-0.4.tar.gz";
const SVD: &str = "cmsis-svd-0.4/cmsis_svd/data/STMicro/STM32F40x.svd";
/// The crate, and in it the chip's folder.
const CRATE: &str = "stm32f4";
const CHIP: &str = "src/stm32f405";
/// Names the folder into which models of the chips write what was used.
const LOG: &str = "ANEMO_REGISTER_LOG";

/// Runs all scenarios, and holds what they have used against the descriptions.
pub fn run() -> Result<()> {
    install::emulated_core()?;
    programs::images()?;
    let mut scenarios = programs::cargo_test(Tier::Ci);
    record(scenarios.args(["--test", "scenarios"]))?;
    shell::run(&mut scenarios)?;
    check()
}

/// Has tests write down the registers that they use; those of before are forgotten.
pub fn record(tests: &mut Command) -> Result<()> {
    let folder = log()?;
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    tests.env(LOG, folder);
    Ok(())
}

/// Holds what was written down against the descriptions.
pub fn check() -> Result<()> {
    let python = install::python()?.join("python");
    shell::run(shell::program(python).arg(CHECK).arg(description()?).arg(registers_of_crate()?).arg(log()?))
}

/// Brings ST's description, if it is not there yet.
pub fn description() -> Result<PathBuf> {
    let folder = shell::target_directory()?.join("tools").join("descriptions");
    let svd = folder.join(SVD);
    if !svd.is_file() {
        shell::announce(&format!("fetching {DESCRIPTIONS} into {}", folder.display()));
        let mut pip = shell::program(install::python()?.join("pip"));
        pip.args(["download", "--quiet", "--disable-pip-version-check", "--no-deps", "--dest"]).arg(&folder);
        shell::run(pip.arg(DESCRIPTIONS))?;
        let archive = folder.join(ARCHIVE);
        shell::run(shell::program("tar").arg("-xzf").arg(&archive).arg("-C").arg(&folder).arg(SVD))?;
        std::fs::remove_file(&archive).with_context(|| archive.display().to_string())?;
    }
    Ok(svd)
}

fn log() -> Result<PathBuf> {
    Ok(shell::target_directory()?.join("registers"))
}

fn registers_of_crate() -> Result<PathBuf> {
    let told = shell::captured(shell::cargo().args(["metadata", "--format-version=1", "--all-features"]))?;
    let told: serde_json::Value = serde_json::from_str(&told).context("`cargo metadata` prints no JSON")?;
    let mut packages = told["packages"].as_array().into_iter().flatten();
    let manifest = packages.find(|package| package["name"] == CRATE).and_then(|of| of["manifest_path"].as_str());
    let manifest = manifest.with_context(|| format!("there is no crate {CRATE}"))?;
    Ok(Path::new(manifest).with_file_name(CHIP))
}
