//! What continuous integration does, with the time of every stage.

use crate::book::{self, BookOptions};
use crate::{counterparts, coverage, install, lint, miri, shell, test};
use anyhow::{Result, bail};

/// `jobs` are those of `cargo xtask`.
pub fn run(jobs: clap::Command) -> Result<()> {
    let prepare = || {
        install::thumb_target()?;
        install::lint_tools()?;
        install::llvm_tools()?;
        install::emulated_core()?;
        install::ngspice()?;
        counterparts::run()?;
        miri::prepare()?;
        install::qemu()
    };
    // The tests come last and the times before them, so that the output ends with the test runner's
    // own summary.
    let mut stages = shell::Stages::default();
    stages.run("prepare", prepare)?;
    stages.run("lint", lint::run)?;
    stages.run("coverage", coverage::run)?;
    stages.run("book", || book::run(&BookOptions::default()))?;
    shell::announce(&stages.times());
    // An emulated board and its host take turns, and the interpreter takes what they leave of two
    // processors.
    let interpreted = std::thread::spawn(miri::run_aside);
    let tested = test::run(jobs);
    let Ok(interpreted) = interpreted.join() else { bail!("the thread of the interpreter has ended early") };
    tested.and(interpreted)
}
