//! The Python package: its wheel is built by maturin, installed into the environment of the pages,
//! and tested by pytest; and its numbers.

use crate::{install, shell};
use anyhow::{Context, Result, bail};
use std::path::{Path, PathBuf};

/// For the examples that compare with other libraries, one of which wants an older numpy than the
/// pages.
const GALLERY_REQUIREMENTS: &str = "python/gallery/requirements.txt";

/// Its tests.
const GALLERY: &str = "python/tests/test_gallery.py";

#[derive(clap::Args, Default)]
pub struct PythonOptions {
    /// Only build the wheel and install it into target/tools/python
    #[arg(long)]
    pub no_test: bool,
    /// Also run the gallery, with the libraries that it compares with in their own environment
    #[arg(long)]
    pub gallery: bool,
    /// Only run the tests that are marked `nightly`
    #[arg(long)]
    pub nightly: bool,
    /// Install the wheel into an empty environment and print its size, what it needs of the system,
    /// and how long import and a first model take
    #[arg(long)]
    pub numbers: bool,
}

pub fn run(options: &PythonOptions) -> Result<()> {
    let (programs, wheel) = package()?;
    if options.numbers {
        return numbers(&wheel);
    }
    if options.no_test {
        return Ok(());
    }
    if options.nightly {
        return pytest(&programs, &["python", "-m", "nightly"]);
    }
    pytest(&programs, &["python", "--ignore", GALLERY])?;
    if options.gallery {
        let programs = gallery()?;
        install_wheel(&programs, &wheel)?;
        pytest(&programs, &[GALLERY])?;
    }
    Ok(())
}

/// Brings what the pages and the tests use.
pub fn prepare() -> Result<()> {
    install::python().map(drop)
}

fn gallery() -> Result<PathBuf> {
    install::python_environment("gallery", GALLERY_REQUIREMENTS)
}

fn pytest(programs: &Path, tests: &[&str]) -> Result<()> {
    let mut pytest = shell::program(programs.join("python"));
    pytest.args(["-m", "pytest", "-q", "-p", "no:cacheprovider"]).args(tests);
    shell::run(pytest.env("PYTHONDONTWRITEBYTECODE", "1").current_dir(shell::root()))
}

/// Builds the wheel and installs it. Gives the environment's programs and the wheel.
pub fn package() -> Result<(PathBuf, PathBuf)> {
    let programs = install::python()?;
    let wheels = shell::target_directory()?.join("wheels");
    let _ = std::fs::remove_dir_all(&wheels);
    let mut maturin = shell::program(programs.join("maturin"));
    maturin.args(["build", "--release", "--locked", "--quiet", "--manifest-path"]);
    maturin.arg(shell::root().join("python/Cargo.toml")).arg("--out").arg(&wheels);
    // maturin looks for the interpreter of an environment.
    maturin.env("VIRTUAL_ENV", programs.parent().unwrap_or(&programs));
    shell::run(&mut maturin)?;
    let mut built = std::fs::read_dir(&wheels).context("maturin has written nothing")?.flatten();
    let Some(wheel) = built.next() else { bail!("maturin has written no wheel into {}", wheels.display()) };
    install_wheel(&programs, &wheel.path())?;
    Ok((programs, wheel.path()))
}

fn install_wheel(programs: &Path, wheel: &Path) -> Result<()> {
    let mut pip = shell::program(programs.join("pip"));
    pip.args(["install", "--quiet", "--disable-pip-version-check", "--no-deps", "--force-reinstall"]);
    shell::run(pip.arg(wheel))
}

/// In an empty environment: installation, import, a first model.
fn numbers(wheel: &Path) -> Result<()> {
    let folder = shell::target_directory()?.join("tools").join("empty");
    shell::run(shell::program("python3").args(["-m", "venv", "--clear"]).arg(&folder))?;
    let bytes = std::fs::metadata(wheel)?.len();
    println!("{}: {:.1} MB", wheel.file_name().unwrap_or_default().to_string_lossy(), bytes as f64 / 1e6);
    let begin = std::time::Instant::now();
    let mut pip = shell::program(folder.join("bin/pip"));
    shell::run(pip.args(["install", "--quiet", "--disable-pip-version-check"]).arg(wheel))?;
    println!("installed with numpy in {:.1} s, download included", begin.elapsed().as_secs_f64());
    let python = folder.join("bin/python");
    for (what, script) in [("import", IMPORT), ("first model", FIRST_MODEL)] {
        let begin = std::time::Instant::now();
        let printed = shell::captured(shell::program(&python).args(["-c", script]).current_dir(shell::root()))?;
        println!("{what}: {} ({:.2} s with the start of Python)", printed.trim(), begin.elapsed().as_secs_f64());
    }
    Ok(())
}

const IMPORT: &str = "\
import time
begin = time.perf_counter()
import anemo
print(f'{time.perf_counter() - begin:.3f} s')";

const FIRST_MODEL: &str = "\
import anemo
print(repr(anemo.identify(anemo.simulate('experiments/prbs.toml'), output='sector1', free_poles=4)))";
