//! Finds out what is missing on this computer and installs it where that is allowed.
//!
//! Targets, toolchains and LLVM's tools come by rustup, QEMU by the system's packages, the rest by
//! cargo. Whatever cannot be installed is named together with the line to type.

use crate::shell;
use anyhow::{Context, Result, bail};
use std::path::PathBuf;
use std::process::Command;

/// Target triple of the boards.
pub const TARGET: &str = "thumbv7em-none-eabihf";
const FLIP_LINK: Tool = Tool { name: "flip-link", version: "0.1.12", features: "" };
/// The program that builds fuzz targets and runs them.
pub const CARGO_FUZZ: Tool = Tool { name: "cargo-fuzz", version: "0.13.2", features: "" };
/// What changes code to see whether a test finds it. Always this version: what it changes differs
/// from one to the next.
pub const CARGO_MUTANTS: Tool = Tool { name: "cargo-mutants", version: "27.1.0", features: "" };
/// What finds the licences of all that is linked.
pub const CARGO_ABOUT: Tool = Tool { name: "cargo-about", version: "0.9.3", features: "cli" };
/// The compiler for what the pinned one cannot do: fuzzing and miri. Of a day, so that it is the
/// same tomorrow.
const NIGHTLY: &str = "nightly-2026-10-30";
pub const QEMU: &str = "qemu-system-arm";

/// A program that cargo installs.
pub struct Tool {
    name: &'static str,
    version: &'static str,
    features: &'static str,
}

/// A system's package manager and the commands by which it brings QEMU for Arm. The lists of
/// packages come first, where an install would otherwise not find any.
struct Packages {
    manager: &'static str,
    commands: &'static [&'static str],
}

const PACKAGES: [Packages; 4] = [
    Packages {
        manager: "apt-get",
        commands: &["update -qq", "install -y -qq --no-install-recommends qemu-system-arm"],
    },
    Packages { manager: "dnf", commands: &["install -y qemu-system-arm-core"] },
    Packages { manager: "pacman", commands: &["-Sy --noconfirm --needed qemu-system-arm"] },
    Packages { manager: BREW, commands: &["install qemu"] },
];
/// The one that does not want to be run by root.
const BREW: &str = "brew";

/// The thumb target's core library, for building firmware.
pub fn thumb_target() -> Result<()> {
    target(TARGET)
}

/// The library of a target.
pub fn target(triple: &str) -> Result<()> {
    if printed_by_rustc("sysroot")?.join("lib/rustlib").join(triple).join("lib").is_dir() {
        return Ok(());
    }
    shell::announce(&format!("installing the Rust target {triple}"));
    shell::run(rustup(&format!("the Rust target {triple}"))?.args(["target", "add", triple]))
}

/// A folder that the compiler names.
pub fn printed_by_rustc(what: &str) -> Result<PathBuf> {
    let folder = shell::output_of("rustc", &["--print", what]);
    folder.map(PathBuf::from).context("rustc does not run; install Rust by https://rustup.rs and start again")
}

/// What installs toolchains and their parts; `missing` is what for.
fn rustup(missing: &str) -> Result<Command> {
    if !shell::answers("rustup", &["--version"]) {
        bail!("{missing} is missing and there is no rustup to install it; install Rust by https://rustup.rs");
    }
    Ok(shell::program("rustup"))
}

/// A component of the compiler, if it is not there yet.
fn component(name: &str, is_there: impl Fn() -> bool) -> Result<()> {
    if is_there() {
        return Ok(());
    }
    shell::announce(&format!("installing {name}"));
    shell::run(rustup(name)?.args(["component", "add", name]))?;
    if is_there() { Ok(()) } else { bail!("{name} is still missing; type: rustup component add {name}") }
}

/// The linker that puts the stack below all statics. Gives where it is: found on the path, or
/// installed among the build's products.
pub fn flip_link() -> Result<PathBuf> {
    if shell::answers("flip-link", &["--help"]) {
        return Ok(PathBuf::from("flip-link"));
    }
    tool(&FLIP_LINK)
}

/// A program that cargo installs among the build's products, if it is not there yet. Gives where it
/// is.
pub fn tool(&Tool { name, version, features }: &Tool) -> Result<PathBuf> {
    let tools = shell::target_directory()?.join("tools");
    let installed = tools.join("bin").join(format!("{name}{}", std::env::consts::EXE_SUFFIX));
    if !installed.is_file() {
        shell::announce(&format!("installing {name} {version} into {}", tools.display()));
        let mut cargo = shell::cargo();
        cargo.args(["install", "--quiet", name, "--locked", "--version", version, "--features", features, "--root"]);
        cargo.arg(&tools);
        shell::run(&mut cargo)
            .with_context(|| format!("{name} is missing; type: cargo install {name} --locked --version {version}"))?;
    }
    Ok(installed)
}

/// The nightly compiler, with components beside the usual ones.
pub fn nightly(components: &[&str]) -> Result<()> {
    let installed = shell::output_of("rustup", &["component", "list", "--installed", "--toolchain", NIGHTLY]);
    let has =
        |component: &&str| installed.as_ref().is_some_and(|list| list.lines().any(|line| line.starts_with(*component)));
    if has(&"rustc") && components.iter().all(has) {
        return Ok(());
    }
    shell::announce(&format!("installing {NIGHTLY} {}", components.join(" ")));
    let mut rustup = rustup(NIGHTLY)?;
    rustup.args(["toolchain", "install", NIGHTLY, "--no-self-update", "--profile", "minimal"]);
    for component in components {
        rustup.args(["--component", component]);
    }
    shell::run(&mut rustup)
}

/// Begins a command line that is run with that compiler: the program and its arguments follow.
pub fn on_nightly() -> Command {
    let mut rustup = shell::program("rustup");
    // The cargo that runs this crate has said of these what it is itself.
    for of_this_cargo in ["CARGO", "RUSTC", "RUSTDOC", "RUSTFLAGS", "CARGO_ENCODED_RUSTFLAGS", "RUSTUP_TOOLCHAIN"] {
        rustup.env_remove(of_this_cargo);
    }
    rustup.args(["run", NIGHTLY]);
    rustup
}

/// LLVM's tools for what the compiler has counted. Gives the folder where they are.
pub fn llvm_tools() -> Result<PathBuf> {
    let folder = printed_by_rustc("target-libdir")?.with_file_name("bin");
    component("llvm-tools", || {
        let mut programs = ["llvm-cov", "llvm-profdata"].iter().map(|name| folder.join(name));
        programs.all(|program| shell::answers(&program.to_string_lossy(), &["--version"]))
    })?;
    Ok(folder)
}

/// The tools that `lint` needs beside the compiler.
pub fn lint_tools() -> Result<()> {
    component("rustfmt", || shell::answers("cargo-fmt", &["--version"]))?;
    component("clippy", || shell::answers("cargo-clippy", &["--version"]))
}

/// The emulator.
pub fn qemu() -> Result<()> {
    let is_there = || shell::answers(QEMU, &["--version"]);
    if is_there() {
        return Ok(());
    }
    let Some(packages) = PACKAGES.iter().find(|packages| shell::answers(packages.manager, &["--version"])) else {
        bail!("{QEMU} is missing; install QEMU for Arm (https://www.qemu.org/download) and start again");
    };
    let manager = packages.manager;
    let is_root = shell::output_of("id", &["-u"]).is_some_and(|id| id == "0");
    let sudo = manager != BREW && !is_root;
    if !sudo || shell::answers("sudo", &["-n", "true"]) {
        shell::announce(&format!("installing {QEMU} with {manager}"));
        for arguments in packages.commands {
            let mut command = shell::program(if sudo { "sudo" } else { manager });
            if sudo {
                command.args(["-n", "env", "DEBIAN_FRONTEND=noninteractive", manager]);
            }
            // A refresh that fails for one of many sources is no reason to give up: what counts is
            // whether the emulator is there afterwards.
            let _ = shell::run(command.env("DEBIAN_FRONTEND", "noninteractive").args(arguments.split(' ')));
        }
    }
    if !is_there() {
        let start = if manager == BREW { manager.to_owned() } else { format!("sudo {manager}") };
        let lines: Vec<_> = packages.commands.iter().map(|arguments| format!("{start} {arguments}")).collect();
        bail!("{QEMU} is missing and cannot be installed from here; type: {}", lines.join(" && "));
    }
    Ok(())
}
