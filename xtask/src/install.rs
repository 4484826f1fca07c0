//! Finds out what is missing on this computer and installs it where that is allowed.
//!
//! Targets, toolchains and LLVM's tools come by rustup, QEMU by the system's packages, the rest by
//! cargo. Whatever cannot be installed is named together with the line to type.

use crate::shell;
use anyhow::{Context, Result, anyhow, bail};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Target triple of the boards.
pub const TARGET: &str = "thumbv7em-none-eabihf";
const FLIP_LINK_VERSION: &str = "0.1.12";
const CARGO_FUZZ_VERSION: &str = "0.13.2";
/// The compiler for what the pinned one cannot do: fuzzing and miri. Of a day, so that it is the
/// same tomorrow.
const NIGHTLY: &str = "nightly-2026-10-30";
const CARGO_MUTANTS_VERSION: &str = "27.1.0";
pub const QEMU: &str = "qemu-system-arm";

/// A system's package manager and how it brings QEMU for Arm.
struct Packages {
    manager: &'static str,
    /// Brings the lists of packages up to date, where an install would otherwise not find any.
    refresh: Option<&'static [&'static str]>,
    install: &'static [&'static str],
    /// Whether the manager wants to be run by root.
    as_root: bool,
    /// The same for people to type.
    by_hand: &'static str,
}

const PACKAGES: [Packages; 4] = [
    Packages {
        manager: "apt-get",
        refresh: Some(&["update", "-qq"]),
        install: &["install", "-y", "-qq", "--no-install-recommends", "qemu-system-arm"],
        as_root: true,
        by_hand: "sudo apt-get update && sudo apt-get install qemu-system-arm",
    },
    Packages {
        manager: "dnf",
        refresh: None,
        install: &["install", "-y", "qemu-system-arm-core"],
        as_root: true,
        by_hand: "sudo dnf install qemu-system-arm-core",
    },
    Packages {
        manager: "pacman",
        refresh: None,
        install: &["-Sy", "--noconfirm", "--needed", "qemu-system-arm"],
        as_root: true,
        by_hand: "sudo pacman -Sy qemu-system-arm",
    },
    Packages {
        manager: "brew",
        refresh: None,
        install: &["install", "qemu"],
        as_root: false,
        by_hand: "brew install qemu",
    },
];

/// The thumb target's core library, for building firmware.
pub fn thumb_target() -> Result<()> {
    let sysroot = shell::output_of("rustc", &["--print", "sysroot"])
        .context("rustc does not run; install Rust by https://rustup.rs and start again")?;
    if Path::new(&sysroot).join("lib/rustlib").join(TARGET).join("lib").is_dir() {
        return Ok(());
    }
    shell::announce(&format!("installing the Rust target {TARGET}"));
    if !shell::answers("rustup", &["--version"]) {
        bail!(
            "the Rust target {TARGET} is missing and there is no rustup to install it; install Rust by https://rustup.rs"
        );
    }
    shell::run(shell::program("rustup").args(["target", "add", TARGET]))
}

/// The linker that puts the stack below all statics. Gives where it is: found on the path, or
/// installed among the build's products.
pub fn flip_link() -> Result<PathBuf> {
    if shell::answers("flip-link", &["--help"]) {
        return Ok(PathBuf::from("flip-link"));
    }
    tool("flip-link", FLIP_LINK_VERSION)
}

/// The program that builds fuzz targets and runs them.
pub fn cargo_fuzz() -> Result<PathBuf> {
    tool("cargo-fuzz", CARGO_FUZZ_VERSION)
}

/// What changes code to see whether a test finds it. Always this version: what it changes differs
/// from one to the next.
pub fn cargo_mutants() -> Result<PathBuf> {
    tool("cargo-mutants", CARGO_MUTANTS_VERSION)
}

/// A program that cargo installs among the build's products, if it is not there yet. Gives where it
/// is.
fn tool(name: &str, version: &str) -> Result<PathBuf> {
    let tools = shell::target_directory()?.join("tools");
    let installed = tools.join("bin").join(format!("{name}{}", std::env::consts::EXE_SUFFIX));
    if !installed.is_file() {
        shell::announce(&format!("installing {name} {version} into {}", tools.display()));
        let mut cargo = shell::cargo();
        cargo.args(["install", "--quiet", name, "--locked", "--version", version, "--root"]).arg(&tools);
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
    if !shell::answers("rustup", &["--version"]) {
        bail!("{NIGHTLY} is missing and there is no rustup to install it; install Rust by https://rustup.rs");
    }
    shell::announce(&format!("installing {NIGHTLY} {}", components.join(" ")));
    let mut rustup = shell::program("rustup");
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
    let libraries = shell::output_of("rustc", &["--print", "target-libdir"])
        .context("rustc does not run; install Rust by https://rustup.rs and start again")?;
    let found = Path::new(&libraries).with_file_name("bin");
    let is_there = || {
        let mut programs = ["llvm-cov", "llvm-profdata"].iter().map(|name| found.join(name));
        programs.all(|program| shell::answers(&program.to_string_lossy(), &["--version"]))
    };
    if !is_there() {
        shell::announce("installing llvm-tools");
        shell::run(shell::program("rustup").args(["component", "add", "llvm-tools"]))
            .context("LLVM's tools are missing; type: rustup component add llvm-tools")?;
        if !is_there() {
            bail!("LLVM's tools are still not in {}", found.display());
        }
    }
    Ok(found)
}

/// The tools that `lint` needs beside the compiler.
pub fn lint_tools() -> Result<()> {
    for (component, program) in [("rustfmt", "cargo-fmt"), ("clippy", "cargo-clippy")] {
        if !shell::answers(program, &["--version"]) {
            shell::announce(&format!("installing {component}"));
            shell::run(shell::program("rustup").args(["component", "add", component]))
                .with_context(|| format!("{component} is missing; type: rustup component add {component}"))?;
        }
    }
    Ok(())
}

/// The emulator.
pub fn qemu() -> Result<()> {
    if shell::answers(QEMU, &["--version"]) {
        return Ok(());
    }
    let Some(packages) = PACKAGES.iter().find(|packages| shell::answers(packages.manager, &["--version"])) else {
        bail!("{QEMU} is missing; install QEMU for Arm (https://www.qemu.org/download) and start again");
    };
    let refusal = || anyhow!("{QEMU} is missing and cannot be installed from here; type: {}", packages.by_hand);
    let sudo = packages.as_root && !is_root();
    if sudo && !shell::answers("sudo", &["-n", "true"]) {
        return Err(refusal());
    }
    shell::announce(&format!("installing {QEMU} with {}", packages.manager));
    if let Some(refresh) = packages.refresh {
        // A refresh that fails for one of many sources is no reason to give up: the install
        // decides.
        let _ = shell::run(manager(packages, sudo).args(refresh));
    }
    shell::run(manager(packages, sudo).args(packages.install)).map_err(|_| refusal())?;
    if shell::answers(QEMU, &["--version"]) { Ok(()) } else { Err(refusal()) }
}

fn manager(packages: &Packages, sudo: bool) -> Command {
    let mut command = if sudo {
        let mut command = shell::program("sudo");
        command.args(["-n", "env", "DEBIAN_FRONTEND=noninteractive", packages.manager]);
        command
    } else {
        shell::program(packages.manager)
    };
    command.env("DEBIAN_FRONTEND", "noninteractive");
    command
}

fn is_root() -> bool {
    shell::output_of("id", &["-u"]).is_some_and(|id| id == "0")
}
