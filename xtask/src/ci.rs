//! What continuous integration does, with the time of every stage.

use crate::book::{self, BookOptions};
use crate::{counterparts, coverage, install, lint, miri, python, shell, test};
use anyhow::{Result, bail};
use std::thread::JoinHandle;

/// `jobs` are those of `cargo xtask`.
pub fn run(jobs: clap::Command) -> Result<()> {
    // What lint needs comes first; the rest comes out of the network while it computes.
    let prepare = || {
        install::thumb_target()?;
        install::lint_tools()?;
        install::llvm_tools()?;
        install::emulated_core()
    };
    let install_the_rest = || {
        install::ngspice()?;
        install::qemu()?;
        counterparts::run()?;
        python::prepare()?;
        miri::prepare()
    };
    // The tests come last and the times before them, so that the output ends with the test runner's
    // own summary.
    let mut stages = shell::Stages::default();
    stages.run("prepare", prepare)?;
    let installed = std::thread::spawn(install_the_rest);
    stages.run("lint", lint::run)?;
    stages.run("coverage", coverage::run)?;
    stages.run("book", || book::run(&BookOptions::default()))?;
    stages.run("waiting for what is installed", || joined(installed))?;
    shell::announce(&stages.times());
    // An emulated board and its host take turns, and the interpreter takes what they leave of two
    // processors.
    let interpreted = std::thread::spawn(miri::run_aside);
    let tested = test::run(jobs);
    tested.and(joined(interpreted))
}

fn joined(thread: JoinHandle<Result<()>>) -> Result<()> {
    thread.join().unwrap_or_else(|_| bail!("a thread of this program has ended early"))
}
