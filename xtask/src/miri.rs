//! The unit tests of what the board runs, in an interpreter that knows what Rust does not define.
//!
//! There is no `unsafe` in these crates; their libraries have some.

use crate::{install, shell};
use anyhow::{Context, Result, bail};
use std::process::{Command, Stdio};
use std::time::Instant;

/// Parts of the names of tests that go through so many ticks, points or bytes that the interpreter,
/// tens of thousands of times slower than a processor, would take from some ten seconds to days for
/// each. They look for wrong numbers, and what they call is called by others, too; but the
/// anemometer and the solver of the wind are not interpreted beyond their beginnings.
const LONG: [&str; 30] = [
    "anemometer::tests::",
    "controller::tests::arming::it_starts_within",
    "controller::tests::elements::room_for_more",
    "controller::tests::holds_a_temperature",
    "controller::tests::its_model_follows",
    "controller::tests::observing::",
    "controller::tests::two_runs",
    "controller::tests::bit_flips::an_untouched",
    "controller::tests::bit_flips::whatever_bit",
    "decimator::tests::a_constant",
    "decimator::tests::reads_the_mean",
    "decimator::tests::sums_may_wrap",
    "observer::tests::",
    "prbs::tests::every_feedback",
    "prbs::tests::short_registers",
    "receiver::tests::garbage_of_any_length",
    "relaxation::tests::ten_million",
    "self_test::tests::a",
    "self_test::tests::bounds",
    "self_test::tests::each",
    "self_test::tests::readings",
    "self_test::tests::stopped",
    "self_test::tests::without",
    "sigma_delta::tests::follows",
    "sigma_delta::tests::the_sum",
    "instrument::tests::a_start_begins",
    "cobs::tests::a_buffer_that_is_too_short",
    "symbol::tests::a_held_power",
    "arithmetic::tests::root_and_logarithm",
    "wind::tests::",
];

pub fn run() -> Result<()> {
    prepare()?;
    shell::run(&mut interpreter()?)
}

/// Brings the compiler that has the interpreter.
pub fn prepare() -> Result<()> {
    install::nightly(&["miri", "rust-src"])
}

/// The same beside other work: in a line if all is well, with all its words if not.
pub fn run_aside() -> Result<()> {
    let start = Instant::now();
    let output = interpreter()?.stdin(Stdio::null()).output().context("the interpreter cannot be started")?;
    if !output.status.success() {
        let words = [output.stdout, output.stderr].concat();
        bail!("{}\nmiri has found something, or could not run: its words stand above", String::from_utf8_lossy(&words));
    }
    shell::announce(&format!("miri, beside the tests: nothing found, {:.0} s", start.elapsed().as_secs_f64()));
    Ok(())
}

fn interpreter() -> Result<Command> {
    let mut miri = install::on_nightly();
    miri.args(["cargo", "miri", "test", "-p", "dr-core", "-p", "wire", "--lib"]);
    miri.arg("--target-dir").arg(shell::target_directory()?.join("miri"));
    miri.arg("--").args(LONG.map(|name| format!("--skip={name}")));
    Ok(miri)
}
