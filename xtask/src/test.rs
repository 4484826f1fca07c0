//! Everything that is checked by running it.
//!
//! Budgets come first and whole experiments last. The time of every stage and of all stands right
//! before the test runner's last summary, with which the output ends.

use crate::artefacts::{self, FirmwareBoard};
use crate::{cost, install, safety, shell, size};
use anyhow::Result;
use std::cell::RefCell;
use std::io::{BufRead, IsTerminal};
use std::time::{Duration, Instant};

pub fn run() -> Result<()> {
    let start = Instant::now();
    let times = RefCell::new(Vec::new());
    let timed = |what: &'static str, work: &dyn Fn() -> Result<()>| -> Result<()> {
        times.borrow_mut().push((what, shell::timed(what, work)?));
        Ok(())
    };
    install::thumb_target()?;
    install::qemu()?;
    timed("size of the firmware", &size::run)?;
    timed("panics, stack, overflow", &safety::run)?;
    timed("cost of the hot paths", &|| cost::run(&cost::CostOptions::check()))?;

    // Always the whole workspace and its tests: for some of its crates alone cargo chooses other
    // features, and compiles everything once more.
    let cargo = |arguments: &[&str]| {
        let mut cargo = shell::cargo();
        cargo.args(["test", "--release", "--workspace"]).args(arguments);
        cargo
    };
    // Tests that cross crates start these two programs; they are handed over built.
    let programs = RefCell::new(Vec::new());
    timed("building the tests", &|| {
        let firmware = artefacts::firmware(FirmwareBoard::Virtual)?;
        let anemo = artefacts::executable(&mut cargo(&["--lib", "--bins", "--tests", "--no-run"]), "anemo")?;
        programs.borrow_mut().extend([("ANEMO_FIRMWARE", firmware), ("ANEMO_BIN", anemo)]);
        // Examples are started by the tests of their crates, which compare what they print. `cargo
        // test` would build them as tests.
        shell::run(shell::cargo().args(["build", "--release", "--workspace", "--examples"]))
    })?;
    let test = |arguments: &[&str]| {
        let mut cargo = cargo(arguments);
        cargo.envs(programs.borrow().iter().cloned());
        cargo
    };
    timed("examples in the documentation", &|| shell::run(&mut test(&["--doc"])))?;
    timed("unit tests", &|| shell::run(&mut test(&["--lib", "--bins"])))?;
    let last = "whole experiments";
    shell::announce(last);
    let last_start = Instant::now();
    let mut whole = test(&["--test", "*"]);
    if std::io::stdout().is_terminal() {
        // Through a pipe they would have none.
        whole.args(["--", "--color=always"]);
    }
    shell::run_through(&mut whole, |output| {
        let summary = all_but_last_summary(output, |line| println!("{line}"))?;
        times.borrow_mut().push((last, last_start.elapsed()));
        shell::announce(&line_of_times(&times.borrow(), start.elapsed()));
        summary.iter().for_each(|line| println!("{line}"));
        Ok(())
    })
}

fn line_of_times(times: &[(&str, Duration)], all: Duration) -> String {
    let stages: Vec<_> = times.iter().map(|(what, time)| format!("{what} {:.0} s", time.as_secs_f64())).collect();
    format!("{}; in all {:.0} s", stages.join(", "), all.as_secs_f64())
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

    #[test]
    fn times_are_of_every_stage_and_of_all() {
        let times = [("size", Duration::from_secs(3)), ("unit tests", Duration::from_millis(1600))];
        assert_eq!(line_of_times(&times, Duration::from_secs(5)), "size 3 s, unit tests 2 s; in all 5 s");
    }
}
