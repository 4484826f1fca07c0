//! Endings of runs and logs at random moments: kill, SIGTERM, a cable that is pulled, a board that
//! starts anew, a full disk.

use crate::artefacts;
use crate::shell;
use anyhow::Result;

/// How many.
#[derive(clap::Args)]
pub struct EndingsOptions {
    /// Endings, of every kind as many.
    #[arg(default_value_t = 100)]
    endings: u32,
}

/// Ends so many, and prints what was received and lost.
pub fn run(options: &EndingsOptions) -> Result<()> {
    let cargo = |arguments: &[&str]| {
        let mut cargo = shell::cargo();
        cargo.args(["test", "--release", "--workspace"]).args(arguments);
        cargo
    };
    let anemo = artefacts::executable(&mut cargo(&["--lib", "--bins", "--tests", "--no-run"]), "anemo")?;
    let mut test = cargo(&["--test", "all", "--", "endings::", "--nocapture"]);
    shell::run(test.env("ANEMO_BIN", anemo).env("ANEMO_ENDINGS", options.endings.to_string()))
}
