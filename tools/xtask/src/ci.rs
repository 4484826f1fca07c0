//! Stages of continuous integration.
//!
//! The tier `test` comes last, so that the output ends with the test runner's own summary.

use crate::book::{self, BookOptions};
use crate::cost::{self, CostOptions};
use crate::hardware::{self, HardwareOptions};
use crate::pages::{self, PagesOptions};
use crate::programs::{TestPrograms, Tier};
use crate::python::{self, PythonOptions};
use crate::stages::Stages;
use crate::{counterparts, install, lint, miri, reference, registers, test};
use anyhow::{Result, bail};
use std::thread::JoinHandle;

/// `jobs` are those of `cargo xtask`.
pub fn run(jobs: clap::Command) -> Result<()> {
    let mut stages = Stages::new();
    let outcome = all(&mut stages, jobs);
    stages.finish();
    outcome
}

fn all(stages: &mut Stages, jobs: clap::Command) -> Result<()> {
    // The tools of lint come first; the rest comes out of the network while it computes.
    let prepare = || {
        install::thumb_target()?;
        install::lint_tools()?;
        install::emulated_core()
    };
    let install_the_rest = || {
        install::ngspice()?;
        install::qemu()?;
        counterparts::run()?;
        python::prepare()?;
        registers::description()?;
        miri::prepare()
    };
    stages.run("prepare", prepare)?;
    let installed = std::thread::spawn(install_the_rest);
    stages.run("lint", lint::run)?;
    stages.run("book", || book::run(&BookOptions::default()))?;
    let programs = stages.run("building all tests", || TestPrograms::build(Tier::Ci))?;
    stages.run("waiting for what is installed", || joined(installed))?;
    // An emulated board and its host take turns, and the interpreter takes what they leave of two
    // processors.
    let interpreted = std::thread::spawn(miri::run_aside);
    let tested = tests(stages, &programs, jobs);
    tested.and(joined(interpreted))
}

fn tests(stages: &mut Stages, programs: &TestPrograms, jobs: clap::Command) -> Result<()> {
    let check = CostOptions { check: true, ..CostOptions::default() };
    stages.run("cost of the hot paths", || cost::run(&check))?;
    stages.run("netlists of the board", || hardware::run(&HardwareOptions::default()))?;
    let shown = stages.run("building the examples", || programs.of_pages())?;
    stages.run("pages of the command line", || reference::check(&shown.interface))?;
    stages.run("Python package", || python::run(&PythonOptions::default()))?;
    stages.run("commands in pages", || pages::run(&PagesOptions::default(), jobs, Some(shown)))?;
    // One failing program of tests does not keep the others from being heard.
    let mut slow = programs.slow();
    registers::record(&mut slow)?;
    let scenarios = stages.test("faults and scenarios", &mut slow, &[]);
    let registers = stages.run("registers", registers::check);
    test::tier(stages, Tier::Ci).and(scenarios).and(registers)
}

fn joined(thread: JoinHandle<Result<()>>) -> Result<()> {
    thread.join().unwrap_or_else(|_| bail!("a thread of this program has ended early"))
}
