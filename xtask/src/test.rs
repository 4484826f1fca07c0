//! Everything that is checked by running it.
//!
//! Budgets come first and whole experiments last, so that the output ends with the test runner's own summary.

use crate::artefacts::{self, Board};
use crate::{cost, install, safety, shell, size};
use anyhow::Result;

pub fn run() -> Result<()> {
    install::thumb_target()?;
    install::qemu()?;
    shell::announce("size of the firmware");
    size::run()?;
    shell::announce("panics, stack, overflow");
    safety::run()?;
    shell::announce("cost of the hot paths");
    cost::run(&cost::Options::check())?;

    // Tests that cross crates start these two programs; they are handed over built.
    let firmware = artefacts::firmware(Board::Virtual)?;
    let anemo = artefacts::anemo()?;
    for (what, arguments) in [
        ("examples in the documentation", ["--workspace", "--doc"].as_slice()),
        ("unit tests", &["--workspace", "--exclude", "anemo-tests", "--lib", "--bins", "--tests"]),
        ("whole experiments", &["-p", "anemo-tests", "--lib", "--tests"]),
    ] {
        shell::announce(what);
        let mut cargo = shell::cargo();
        cargo.args(["test", "--release"]).args(arguments);
        shell::run(cargo.env("ANEMO_FIRMWARE", &firmware).env("ANEMO_BIN", &anemo))?;
    }
    Ok(())
}
