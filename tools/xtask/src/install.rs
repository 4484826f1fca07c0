//! Finds out what is missing on this computer and installs it where that is allowed.
//!
//! Targets, toolchains and LLVM's tools come by rustup, QEMU, ngspice, Python, cmake and libclang
//! by Debian's and Ubuntu's packages, Python's packages by pip, the rest by cargo. Whatever cannot be
//! installed is named together with the line to type.

use crate::shell;
use anyhow::{Context, Result, bail};
use std::path::PathBuf;
use std::process::Command;

/// Target triple of the boards.
pub const TARGET: &str = "thumbv7em-none-eabihf";
const FLIP_LINK: Tool = Tool::new("flip-link", "0.1.12");
/// The program that builds fuzz targets and runs them.
pub const CARGO_FUZZ: Tool = Tool::new("cargo-fuzz", "0.13.2");
/// Program that changes code to see whether a test finds it. Always this version: what it changes
/// differs from one to the next.
pub const CARGO_MUTANTS: Tool = Tool::new("cargo-mutants", "27.1.0");
/// Program that finds the licences of all that is linked.
pub const CARGO_ABOUT: Tool = Tool { options: &["--features", "cli"], ..Tool::new("cargo-about", "0.9.3") };
/// Program that looks at licences and sources of dependencies. It is run once, and compiled in a
/// quarter of the time without optimisation.
pub const CARGO_DENY: Tool = Tool { options: &["--debug"], ..Tool::new("cargo-deny", "0.20.2") };
/// Program that makes the book, without its server; in a few seconds, and compiled in a quarter of
/// the time without optimisation.
pub const MDBOOK: Tool =
    Tool { options: &["--debug", "--no-default-features", "--features", "search"], ..Tool::new("mdbook", "0.5.4") };
/// Program that makes MathML of the book's equations.
pub const MATHCORE: Tool = Tool { program: "mathcore", options: &["--debug"], ..Tool::new("math-core-cli", "0.7.0") };
/// The compiler for what the pinned one cannot do: fuzzing and miri. Of a day, so that it is the
/// same tomorrow.
const NIGHTLY: &str = "nightly-2026-10-30";
/// Program that simulates the board's netlists.
pub const NGSPICE: &str = "ngspice";
pub const QEMU: &str = "qemu-system-arm";

/// A program that cargo installs.
pub struct Tool {
    name: &'static str,
    version: &'static str,
    /// Its file's name.
    program: &'static str,
    /// Options of its installation.
    options: &'static [&'static str],
}

impl Tool {
    const fn new(name: &'static str, version: &'static str) -> Self {
        Self { name, version, program: name, options: &[] }
    }
}

/// Packages of Python for the pages that use it.
const PYTHON_REQUIREMENTS: &str = "tools/xtask/python-requirements.txt";

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

/// Command that installs toolchains and their parts; `missing` is what for.
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
pub fn tool(&Tool { name, version, program, options }: &Tool) -> Result<PathBuf> {
    let tools = shell::target_directory()?.join("tools");
    let installed = tools.join("bin").join(format!("{program}{}", std::env::consts::EXE_SUFFIX));
    if !installed.is_file() {
        shell::announce(&format!("installing {name} {version} into {}", tools.display()));
        let mut cargo = shell::cargo();
        cargo.args(["install", "--quiet", name, "--locked", "--version", version]);
        cargo.args(options).arg("--root").arg(&tools);
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
    package(QEMU, || shell::answers(QEMU, &["--version"]))
}

/// The simulator of circuits.
pub fn ngspice() -> Result<()> {
    package(NGSPICE, || shell::answers(NGSPICE, &["--version"]))
}

/// Installs what the crate `silicon` needs beside the compiler: its emulated core is C, and the
/// binding to it is made as it is built.
pub fn emulated_core() -> Result<()> {
    package("cmake", || shell::answers("cmake", &["--version"]))?;
    // Where Debian and others keep it, with or without its version.
    let find = "find /usr/lib /usr/lib64 -name 'libclang.*so*' -o -name 'libclang-[12]*.so*' | grep -q .";
    let is_named = std::env::var_os("LIBCLANG_PATH").is_some();
    package("libclang-dev", || is_named || shell::answers("sh", &["-c", find]))
}

/// Python with the packages that pages use. Gives the folder of its programs.
pub fn python() -> Result<PathBuf> {
    python_environment("python", PYTHON_REQUIREMENTS)
}

/// Python with the packages that a file lists, in an environment of its own among the build's
/// products. Gives the folder of its programs.
pub fn python_environment(name: &str, requirements: &str) -> Result<PathBuf> {
    let environment = shell::target_directory()?.join("tools").join(name);
    let programs = environment.join("bin");
    let wanted = shell::root().join(requirements);
    let wanted_text = std::fs::read_to_string(&wanted).with_context(|| format!("{requirements} cannot be read"))?;
    // Written last, so that an install that was broken off is done again.
    let installed = environment.join("requirements.txt");
    if std::fs::read_to_string(&installed).is_ok_and(|text| text == wanted_text) {
        return Ok(programs);
    }
    package("python3-venv", || shell::answers("python3", &["-c", "import ensurepip, venv"]))?;
    shell::announce(&format!("installing Python's packages of {requirements} into {}", environment.display()));
    shell::run(shell::program("python3").args(["-m", "venv", "--clear"]).arg(&environment))?;
    let mut pip = shell::program(programs.join("pip"));
    shell::run(pip.args(["install", "--quiet", "--disable-pip-version-check", "-r"]).arg(wanted))?;
    std::fs::write(&installed, wanted_text).with_context(|| format!("{} cannot be written", installed.display()))?;
    Ok(programs)
}

/// Tells whether a program is there. Servers may be where only root's path leads.
pub fn is_on_path(program: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).chain([PathBuf::from("/usr/sbin")]).any(|folder| folder.join(program).is_file())
}

/// A package of the system, if `is_there` misses it.
pub fn package(name: &str, is_there: impl Fn() -> bool) -> Result<()> {
    if is_there() {
        return Ok(());
    }
    if !shell::answers("apt-get", &["--version"]) {
        bail!("{name} is missing; install it (the package of Debian is called so) and start again");
    }
    let is_root = shell::output_of("id", &["-u"]).is_some_and(|id| id == "0");
    // Lists of packages come first: an install would otherwise not find any.
    let commands = ["apt-get update -qq".to_owned(), format!("apt-get install -y -qq --no-install-recommends {name}")];
    if is_root || shell::answers("sudo", &["-n", "true"]) {
        shell::announce(&format!("installing {name} with apt-get"));
        for command in &commands {
            let words =
                format!("{}env DEBIAN_FRONTEND=noninteractive {command}", if is_root { "" } else { "sudo -n " });
            let mut words = words.split(' ');
            // A refresh that fails for one of many sources is no reason to give up: what counts is
            // whether the package is there afterwards.
            let _ = shell::run(shell::program(words.next().unwrap_or_default()).args(words));
        }
    }
    if !is_there() {
        bail!("{name} is missing and cannot be installed from here; type: sudo {}", commands.join(" && sudo "));
    }
    Ok(())
}
