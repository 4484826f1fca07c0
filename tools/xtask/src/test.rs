//! The tier of tests for whoever has cloned the project: budgets of the firmware, unit tests,
//! examples in the documentation, the command, and closed loops on the emulated board.

use crate::programs::{TestPrograms, Tier};
use crate::stages::Stages;
use crate::{safety, shell, size};
use anyhow::Result;

pub fn run() -> Result<()> {
    let mut stages = Stages::new();
    let outcome = tier(&mut stages, Tier::Test);
    stages.finish();
    outcome
}

/// Runs the stages, as a job of its own or as the last of a larger one.
pub fn tier(stages: &mut Stages, tier: Tier) -> Result<()> {
    let programs = stages.run("building the tests and the firmware", || TestPrograms::build(tier))?;
    stages.run("size of the firmware", size::run)?;
    stages.run("panics, stack, overflow", safety::run)?;
    let mut jobs = shell::cargo();
    stages.test("tests of the jobs", jobs.args(["test", "--profile", "xtask", "-p", "xtask"]), &[])?;
    stages.run("examples in the documentation", || shell::run(&mut programs.documentation()))?;
    stages.test("unit tests, command, closed loops", &mut programs.quick(), &[])
}
