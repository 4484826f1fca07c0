//! Finds out what is missing on this computer and installs it where that is allowed.
//!
//! Targets, toolchains and LLVM's tools come by rustup, QEMU, ngspice, Python, cmake and libclang
//! by the system's packages, Python's packages by pip, the rest by cargo. Whatever cannot be
//! installed is named together with the line to type.

use crate::shell;
use anyhow::{Context, Result, bail};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Target triple of the boards.
pub const TARGET: &str = "thumbv7em-none-eabihf";
const FLIP_LINK: Tool = Tool::new("flip-link", "0.1.12");
/// The program that builds fuzz targets and runs them.
pub const CARGO_FUZZ: Tool = Tool::new("cargo-fuzz", "0.13.2");
/// What changes code to see whether a test finds it. Always this version: what it changes differs
/// from one to the next.
pub const CARGO_MUTANTS: Tool = Tool::new("cargo-mutants", "27.1.0");
/// What finds the licences of all that is linked.
pub const CARGO_ABOUT: Tool = Tool { options: &["--features", "cli"], ..Tool::new("cargo-about", "0.9.3") };
/// What looks at licences and sources of dependencies. It is run once, and compiled in a quarter of
/// the time without optimisation.
pub const CARGO_DENY: Tool = Tool { options: &["--debug"], ..Tool::new("cargo-deny", "0.20.2") };
/// What makes the book, without its server; in a few seconds, and compiled in a quarter of the time
/// without optimisation.
pub const MDBOOK: Tool =
    Tool { options: &["--debug", "--no-default-features", "--features", "search"], ..Tool::new("mdbook", "0.5.4") };
/// What makes MathML of the book's equations.
pub const MATHCORE: Tool = Tool { program: "mathcore", options: &["--debug"], ..Tool::new("math-core-cli", "0.7.0") };
/// The compiler for what the pinned one cannot do: fuzzing and miri. Of a day, so that it is the
/// same tomorrow.
const NIGHTLY: &str = "nightly-2026-10-30";
/// What simulates the board's netlists.
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

/// A system's package manager and what it is told before the name of a package. The lists of
/// packages come first, where an install would otherwise not find any.
struct PackageManager {
    name: &'static str,
    refresh: Option<&'static str>,
    install: &'static str,
}

const MANAGERS: [PackageManager; 4] = [
    PackageManager { name: "apt-get", refresh: Some("update -qq"), install: "install -y -qq --no-install-recommends" },
    PackageManager { name: "dnf", refresh: None, install: "install -y" },
    PackageManager { name: "pacman", refresh: None, install: "-Sy --noconfirm --needed" },
    PackageManager { name: BREW, refresh: None, install: "install" },
];
/// The one that does not want to be run by root.
const BREW: &str = "brew";
/// QEMU for Arm and Python with its environments, as these managers call them.
const QEMU_PACKAGES: [&str; 4] = ["qemu-system-arm", "qemu-system-arm-core", "qemu-system-arm", "qemu"];
const NGSPICE_PACKAGES: [&str; 4] = [NGSPICE; 4];
/// What builds the emulated core of `silicon`: cmake, and libclang with its headers.
const CMAKE_PACKAGES: [&str; 4] = ["cmake", "cmake", "cmake", "cmake"];
const LIBCLANG_PACKAGES: [&str; 4] = ["libclang-dev", "clang-devel", "clang", "llvm"];
/// Where systems keep their libraries, beside a folder for each version of LLVM.
const LIBRARY_FOLDERS: [&str; 6] = [
    "/usr/lib",
    "/usr/lib64",
    "/usr/lib/x86_64-linux-gnu",
    "/usr/lib/aarch64-linux-gnu",
    "/usr/local/opt/llvm/lib",
    "/opt/homebrew/opt/llvm/lib",
];
const PYTHON_PACKAGES: [&str; 4] = ["python3-venv", "python3", "python", "python"];
/// What Python has beside itself for the pages that use it.
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
    system_package(QEMU, "https://www.qemu.org/download", &QEMU_PACKAGES, || shell::answers(QEMU, &["--version"]))
}

/// The simulator of circuits.
pub fn ngspice() -> Result<()> {
    let is_there = || shell::answers(NGSPICE, &["--version"]);
    system_package(NGSPICE, "https://ngspice.sourceforge.io", &NGSPICE_PACKAGES, is_there)
}

/// What the crate `silicon` needs beside the compiler: its emulated core is C, and the binding to
/// it is made as it is built.
pub fn emulated_core() -> Result<()> {
    system_package("cmake", "https://cmake.org/download", &CMAKE_PACKAGES, || shell::answers("cmake", &["--version"]))?;
    system_package("libclang", "https://releases.llvm.org", &LIBCLANG_PACKAGES, has_libclang)
}

/// Whether the library is where its binding looks for it.
fn has_libclang() -> bool {
    let of_llvm = files_of(Path::new("/usr/lib")).filter(|folder| name_of(folder).starts_with("llvm"));
    let folders = of_llvm.map(|folder| folder.join("lib")).chain(LIBRARY_FOLDERS.map(PathBuf::from));
    let is_libclang = |file: PathBuf| {
        let name = name_of(&file);
        (name.starts_with("libclang.") || name.starts_with("libclang-1") || name.starts_with("libclang-2"))
            && (name.contains(".so") || name.ends_with(".dylib"))
    };
    std::env::var_os("LIBCLANG_PATH").is_some() || folders.flat_map(|folder| files_of(&folder)).any(is_libclang)
}

/// What a folder contains; nothing if it cannot be read.
fn files_of(folder: &Path) -> impl Iterator<Item = PathBuf> + use<> {
    std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path())
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
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
    system_package("Python with venv", "https://www.python.org/downloads", &PYTHON_PACKAGES, || {
        shell::answers("python3", &["-c", "import ensurepip, venv"])
    })?;
    shell::announce(&format!("installing Python's packages of {requirements} into {}", environment.display()));
    shell::run(shell::program("python3").args(["-m", "venv", "--clear"]).arg(&environment))?;
    let mut pip = shell::program(programs.join("pip"));
    shell::run(pip.args(["install", "--quiet", "--disable-pip-version-check", "-r"]).arg(wanted))?;
    std::fs::write(&installed, wanted_text).with_context(|| format!("{} cannot be written", installed.display()))?;
    Ok(programs)
}

/// A package that has the same name wherever there is one.
pub fn package_of_program(program: &str, package: &str) -> Result<()> {
    system_package(program, "from its authors", &[package; 4], || is_on_path(program))
}

/// Whether a program is there. Servers may be where only root's path leads.
pub fn is_on_path(program: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).chain([PathBuf::from("/usr/sbin")]).any(|folder| folder.join(program).is_file())
}

/// A package of the system, by the name that each of [`MANAGERS`] has for it, if `is_there` misses
/// it.
fn system_package(what: &str, source: &str, packages: &[&str; 4], is_there: impl Fn() -> bool) -> Result<()> {
    if is_there() {
        return Ok(());
    }
    let found = MANAGERS.iter().zip(packages).find(|(manager, _)| shell::answers(manager.name, &["--version"]));
    let Some((manager, package)) = found else {
        bail!("{what} is missing; install it ({source}) and start again");
    };
    let install = format!("{} {package}", manager.install);
    let commands: Vec<&str> = manager.refresh.into_iter().chain([install.as_str()]).collect();
    let is_root = shell::output_of("id", &["-u"]).is_some_and(|id| id == "0");
    let sudo = manager.name != BREW && !is_root;
    if !sudo || shell::answers("sudo", &["-n", "true"]) {
        shell::announce(&format!("installing {what} with {}", manager.name));
        for arguments in &commands {
            let mut command = shell::program(if sudo { "sudo" } else { manager.name });
            if sudo {
                command.args(["-n", "env", "DEBIAN_FRONTEND=noninteractive", manager.name]);
            }
            // A refresh that fails for one of many sources is no reason to give up: what counts is
            // whether the package is there afterwards.
            let _ = shell::run(command.env("DEBIAN_FRONTEND", "noninteractive").args(arguments.split(' ')));
        }
    }
    if !is_there() {
        let start = if manager.name == BREW { BREW.to_owned() } else { format!("sudo {}", manager.name) };
        let lines: Vec<_> = commands.iter().map(|arguments| format!("{start} {arguments}")).collect();
        bail!("{what} is missing and cannot be installed from here; type: {}", lines.join(" && "));
    }
    Ok(())
}
