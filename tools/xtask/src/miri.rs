//! The unit tests of what the board runs, in an interpreter that knows what Rust does not define.
//!
//! There is no `unsafe` in these crates; their libraries have some.

use crate::{install, shell};
use anyhow::{Context, Result, bail};
use std::process::{Command, Stdio};
use std::time::Instant;

/// Parts of the names of tests that take too long, and why they may be left out.
const SKIPS: &str = include_str!("miri_skips.txt");
/// Parts of the names of tests that `ci` leaves to `nightly`: they call no library that others do
/// not.
const LONGER: [&str; 2] = ["controller::tests::", "self_test::tests::"];

pub fn run() -> Result<()> {
    prepare()?;
    shell::run(&mut interpreter(&[])?)
}

/// Brings the compiler that has the interpreter.
pub fn prepare() -> Result<()> {
    install::nightly(&["miri", "rust-src"])
}

/// The shorter ones beside other work: in a line if all is well, with all its words if not.
pub fn run_aside() -> Result<()> {
    let start = Instant::now();
    let output = interpreter(&LONGER)?.stdin(Stdio::null()).output().context("the interpreter cannot be started")?;
    if !output.status.success() {
        let words = [output.stdout, output.stderr].concat();
        bail!("{}\nmiri has found something, or could not run: its words stand above", String::from_utf8_lossy(&words));
    }
    shell::announce(&format!("miri, beside the tests: nothing found, {:.0} s", start.elapsed().as_secs_f64()));
    Ok(())
}

/// `longer`: parts of the names of tests that are left out besides.
fn interpreter(longer: &[&str]) -> Result<Command> {
    let mut miri = install::on_nightly();
    miri.args(["cargo", "miri", "test", "-p", "dr-core", "-p", "wire", "--lib"]);
    miri.arg("--target-dir").arg(shell::target_directory()?.join("miri"));
    let skips = SKIPS.lines().filter(|line| !line.starts_with('#')).chain(longer.iter().copied());
    miri.arg("--").args(skips.map(|name| format!("--skip={name}")));
    Ok(miri)
}
