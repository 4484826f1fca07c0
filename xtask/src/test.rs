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

    // Always the whole workspace and its tests: for some of its crates alone cargo chooses other features, and compiles everything once more.
    let cargo = |arguments: &[&str]| {
        let mut cargo = shell::cargo();
        cargo.args(["test", "--release", "--workspace"]).args(arguments);
        cargo
    };
    shell::announce("building the tests");
    // Tests that cross crates start these two programs; they are handed over built.
    let firmware = artefacts::firmware(Board::Virtual)?;
    let anemo = artefacts::executable(&mut cargo(&["--lib", "--bins", "--tests", "--no-run"]), "anemo")?;
    for (what, arguments) in [
        ("examples in the documentation", ["--doc"].as_slice()),
        ("unit tests", &["--lib", "--bins"]),
        ("whole experiments", &["--test", "*"]),
    ] {
        shell::announce(what);
        shell::run(cargo(arguments).env("ANEMO_FIRMWARE", &firmware).env("ANEMO_BIN", &anemo))?;
    }
    Ok(())
}
