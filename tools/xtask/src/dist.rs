//! A release: one archive of what a user needs on x86-64 Linux, made alike to the byte from one
//! commit, and tried in a fresh folder before it counts.
//!
//! `anemo` is linked statically where its target can be had, so that it runs on any distribution.
//! Nothing of it is C code, so that the target takes no C compiler but the system's linker.

use crate::artefacts::{self, FirmwareBoard};
use crate::stages::Stages;
use crate::{install, shell};
use anyhow::{Context, Result, bail};
use std::ffi::OsStr;
use std::fs;
use std::path::Path;
use std::process::Command;

const STATIC: &str = "x86_64-unknown-linux-musl";
const SHARED: &str = "x86_64-unknown-linux-gnu";
/// A larger `anemo` is refused, bytes.
const MOST_BYTES: u64 = 15_000_000;
/// Files that are packed as they stand in the repository.
const AS_THEY_ARE: [&str; 7] =
    ["CHANGELOG.md", "LICENSE-APACHE", "LICENSE-MIT", "README.md", "docs", "experiments", "heads"];
/// Experiment that the tried archive runs; every operating mode is in it.
const EXPERIMENT: &str = "experiments/all-drives.toml";
/// Licences that may be linked, and how they and the bill of materials are written: the second
/// begins behind its name.
const ABOUT: [&str; 2] = ["tools/xtask/dist/about.toml", "tools/xtask/dist/about.hbs"];
const SBOM: &str = "anemo.cdx.json";

pub fn run() -> Result<()> {
    if !cfg!(all(target_arch = "x86_64", target_os = "linux")) {
        bail!("a release is made on x86-64 Linux");
    }
    install::thumb_target()?;
    install::qemu()?;
    let triple = install::target(STATIC).map_or_else(
        |error| {
            println!("anemo is linked with this system's C library, and runs with no older one: {error:#}");
            SHARED
        },
        |()| STATIC,
    );
    let mut stages = Stages::new();
    let name = format!("anemo-{}-{}", env!("CARGO_PKG_VERSION"), triple.replace("-unknown", ""));
    let dist = shell::target_directory()?.join("dist");
    let folder = dist.join(&name);
    if folder.exists() {
        fs::remove_dir_all(&folder)?;
    }
    fs::create_dir_all(&folder)?;

    let anemo = stages.run("building anemo", || {
        let mut cargo = shell::cargo();
        cargo.args(["build", "--profile", "dist", "--target", triple, "-p", "anemo", "--bin", "anemo"]);
        artefacts::executable(&mut cargo, "anemo")
    })?;
    let bytes = fs::metadata(&anemo)?.len();
    if bytes > MOST_BYTES {
        bail!("anemo has {bytes} bytes, {MOST_BYTES} are allowed");
    }
    fs::copy(&anemo, folder.join("anemo"))?;
    stages.run("building the firmware", || firmware(&folder))?;
    let interface = stages.run("building the interface", artefacts::interface)?;
    shell::run(shell::program(interface).arg(&folder))?;
    fs::remove_dir_all(folder.join("reference"))?;
    stages.run("licences", || licences(triple, &folder))?;
    shell::run(shell::program("cp").arg("-r").args(AS_THEY_ARE).arg(&folder))?;

    let archive = dist.join(format!("{name}.tar.gz"));
    stages.run("packing", || shell::pack(&dist, &[&name], &archive))?;
    stages.run("trying the archive", || try_out(&archive, &name))?;
    let sums = shell::captured(Command::new("sha256sum").arg(format!("{name}.tar.gz")).current_dir(&dist))?;
    fs::write(dist.join("SHA256SUMS"), &sums)?;
    shell::announce(&stages.times());
    println!("{}: {} bytes, anemo in it {bytes}\n{}", archive.display(), fs::metadata(&archive)?.len(), sums.trim());
    Ok(())
}

/// The firmware for `--on qemu`, without what a debugger reads; names and formats of its log stay.
fn firmware(folder: &Path) -> Result<()> {
    let strip = install::llvm_tools()?.join("llvm-strip");
    let image = artefacts::firmware(FirmwareBoard::Virtual)?;
    let name = image.file_name().context("an image has a name")?;
    shell::run(shell::program(strip).arg("--strip-debug").arg(&image).arg("-o").arg(folder.join(name)))
}

/// Licences of what is linked, each with its text, and the bill of materials. A licence that
/// `about.toml` does not list is refused.
fn licences(triple: &str, folder: &Path) -> Result<()> {
    // It looks at every file of every crate; both are written at once, therefore.
    shell::run(shell::cargo().args(["fetch", "--quiet", "--locked"]))?;
    let mut about = shell::program(install::tool(&install::CARGO_ABOUT)?);
    about.args(["generate", "--fail", "--frozen", "--manifest-path", "crates/anemo/Cargo.toml", "--target", triple]);
    let text = shell::captured(about.args(["--config", ABOUT[0], ABOUT[1]]))?;
    let (licences, sbom) = text.split_once(SBOM).context("the bill of materials is missing")?;
    serde_json::from_str::<serde_json::Value>(sbom).context("the bill of materials is no JSON")?;
    fs::write(folder.join("LICENSES-THIRD-PARTY.txt"), licences)?;
    fs::write(folder.join(SBOM), sbom)?;
    // The standard library is linked, too; some installations of Rust leave out its licences.
    let library = install::printed_by_rustc("sysroot")?.join("share/doc/rust/COPYRIGHT-library.html");
    if library.exists() {
        fs::copy(&library, folder.join("LICENSES-RUST-LIBRARY.html"))?;
    }
    Ok(())
}

/// Unpacks the archive into a fresh folder, where `anemo` gives the same bits as the one that is
/// tested, in its process and by its firmware.
fn try_out(archive: &Path, name: &str) -> Result<()> {
    let fresh = archive.with_file_name("fresh");
    if fresh.exists() {
        fs::remove_dir_all(&fresh)?;
    }
    shell::unpack(archive, &fresh)?;
    let folder = fresh.join(name);
    let anemo = folder.join("anemo");
    let version = shell::captured(Command::new(&anemo).arg("--version"))?;
    let own = concat!("anemo ", env!("CARGO_PKG_VERSION"));
    if version.trim() != own {
        bail!("the packed anemo is {}, not {own}", version.trim());
    }
    let expected = hash(artefacts::anemo()?.as_os_str(), &shell::root(), "sim")?;
    for on in ["sim", "qemu"] {
        let got = hash(anemo.as_os_str(), &folder, on)?;
        if got != expected {
            bail!("{EXPERIMENT} on {on}: hash {got} of the packed anemo, {expected} of the tested one");
        }
    }
    Ok(fs::remove_dir_all(fresh)?)
}

/// Hash of the heater bits of a run.
fn hash(anemo: &OsStr, folder: &Path, on: &str) -> Result<String> {
    let mut run = Command::new(anemo);
    // The firmware of the archive is tried, not what a variable names.
    run.args(["run", EXPERIMENT, "--json", "--on", on]).current_dir(folder).env_remove("ANEMO_FIRMWARE");
    let summary: serde_json::Value = serde_json::from_str(&shell::captured(&mut run)?)?;
    Ok(summary["hash"].as_str().context("the run has no hash")?.to_owned())
}
