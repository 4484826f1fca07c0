//! Everything that is checked by running it.
//!
//! Budgets come first and whole experiments last. The time of every stage and of all stands right
//! before the test runner's last summary, with which the output ends.

use crate::artefacts::{self, FirmwareBoard};
use crate::cost::{self, CostOptions};
use crate::hardware::{self, HardwareOptions};
use crate::pages::{self, PagePrograms, PagesOptions};
use crate::python::{self, PythonOptions};
use crate::{install, reference, safety, shell, size};
use anyhow::Result;
use std::io::{BufRead, IsTerminal};
use std::time::Instant;

/// `jobs` are those of `cargo xtask`.
pub fn run(jobs: clap::Command) -> Result<()> {
    let start = Instant::now();
    let mut stages = shell::Stages::default();
    install::thumb_target()?;
    install::qemu()?;
    install::emulated_core()?;
    stages.run("size of the firmware", size::run)?;
    stages.run("panics, stack, overflow", safety::run)?;
    let check = CostOptions { check: true, ..CostOptions::default() };
    stages.run("cost of the hot paths", || cost::run(&check))?;

    stages.run("netlists of the board", || hardware::run(&HardwareOptions::default()))?;

    // Always the whole workspace and its tests: for some of its crates alone cargo chooses other
    // features, and compiles everything once more.
    let cargo = |arguments: &[&str]| {
        let mut cargo = shell::cargo_of_all("test");
        cargo.args(arguments);
        cargo
    };
    // Tests that cross crates start these programs; they are handed over built.
    let (programs, interface) = stages.run("building the tests", || {
        let firmware = artefacts::firmware(FirmwareBoard::Virtual)?;
        let sensor_firmware = artefacts::firmware(FirmwareBoard::Sensor)?;
        let anemo = artefacts::executable(&mut cargo(&["--lib", "--bins", "--tests", "--no-run"]), "anemo")?;
        // Examples are started by the tests of their crates, which compare what they print. `cargo
        // test` would build them as tests.
        let interface = artefacts::interface()?;
        let programs = [("ANEMO_FIRMWARE", firmware), ("ANEMO_BIN", anemo), ("ANEMO_SENSOR_FIRMWARE", sensor_firmware)];
        Ok((programs, interface))
    })?;
    stages.run("pages of the command line", || reference::check(&interface))?;
    let [(_, firmware), (_, anemo), _] = programs.clone();
    let shown = PagePrograms { anemo, interface, firmware };
    let all = PythonOptions { gallery: true, ..PythonOptions::default() };
    stages.run("Python package", || python::run(&all))?;
    stages.run("commands in pages", || pages::run(&PagesOptions::default(), jobs, Some(shown)))?;
    let test = |arguments: &[&str]| {
        let mut cargo = cargo(arguments);
        cargo.envs(programs.iter().cloned());
        cargo
    };
    stages.run("examples in the documentation", || shell::run(&mut test(&["--doc"])))?;
    stages.run("unit tests", || shell::run(&mut test(&["--lib", "--bins"])))?;
    // One failing program of tests does not keep the others from being heard.
    let mut whole = test(&["--test", "*", "--no-fail-fast"]);
    if std::io::stdout().is_terminal() {
        // Through a pipe they would have none.
        whole.args(["--", "--color=always"]);
    }
    let mut summary = Vec::new();
    let outcome = stages.run("whole experiments", || {
        shell::run_through(&mut whole, |output| {
            summary = all_but_last_summary(output, |line| println!("{line}"))?;
            Ok(())
        })
    });
    shell::announce(&format!("{}; in all {:.0} s", stages.times(), start.elapsed().as_secs_f64()));
    summary.iter().for_each(|line| println!("{line}"));
    outcome
}

/// Hands on every line of a test runner's output but its last summary, which is returned.
fn all_but_last_summary(output: impl BufRead, mut print: impl FnMut(&str)) -> Result<Vec<String>> {
    let mut held: Vec<String> = Vec::new();
    for line in output.lines() {
        let line = line?;
        let is_summary = line.starts_with("test result:");
        if is_summary || !line.trim().is_empty() {
            held.drain(..).for_each(|line| print(&line));
        }
        if is_summary || !held.is_empty() {
            held.push(line);
        } else {
            print(&line);
        }
    }
    Ok(held)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_summary_is_held_back_and_all_else_is_printed_in_its_order() {
        let output =
            "\nrunning 1 test\ntest a ... ok\n\ntest result: ok. 1\n\n\nrunning 1 test\ntest result: ok. 2\n\n";
        let mut printed = Vec::new();
        let held = all_but_last_summary(output.as_bytes(), |line| printed.push(line.to_owned())).expect("text");
        assert_eq!(held, ["test result: ok. 2", ""]);
        assert_eq!(printed.join("\n") + "\n" + &held.join("\n") + "\n", output);
    }

    #[test]
    fn output_without_a_summary_is_printed() {
        let mut printed = 0;
        assert!(all_but_last_summary("error\n".as_bytes(), |_| printed += 1).expect("text").is_empty());
        assert_eq!(printed, 1);
    }
}
