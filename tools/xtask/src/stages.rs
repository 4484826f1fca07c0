//! Stages of a job: their times, and the slowest of the tests that they run.
//!
//! A job that ends with tests ends its output with the test runner's own summary. All times stand
//! right before it.

use crate::shell;
use anyhow::Result;
use std::io::{BufRead, IsTerminal};
use std::process::Command;
use std::time::{Duration, Instant};

const SLOWEST_COUNT: usize = 10;
/// Test programs print the time of each test only where this variable opens unstable options. Cargo
/// itself must not see it: build scripts would be run again.
const TIMED_RUNNER: &str = "target.'cfg(all())'.runner=['env','RUSTC_BOOTSTRAP=1']";
const TIMED: [&str; 3] = ["--", "-Zunstable-options", "--report-time"];

/// Stages of a job, one after the other.
pub struct Stages {
    start: Instant,
    times: Vec<(&'static str, Duration)>,
    tests: Vec<(f64, String)>,
    /// The last tests' summary, which is not printed yet.
    summary: Vec<String>,
}

impl Stages {
    pub fn new() -> Self {
        Self { start: Instant::now(), times: Vec::new(), tests: Vec::new(), summary: Vec::new() }
    }

    /// Announces a stage and does it.
    pub fn run<T>(&mut self, what: &'static str, work: impl FnOnce() -> Result<T>) -> Result<T> {
        shell::announce(what);
        let start = Instant::now();
        let done = work();
        self.times.push((what, start.elapsed()));
        done
    }

    /// A stage of tests, run by `cargo test`, with options of their programs. Notes the time of each
    /// test and keeps the last summary for [`finish`](Self::finish).
    pub fn test(&mut self, what: &'static str, cargo: &mut Command, options: &[&str]) -> Result<()> {
        self.summary.drain(..).for_each(|line| println!("{line}"));
        cargo.args(["--config", TIMED_RUNNER]).args(TIMED).args(options);
        if std::io::stdout().is_terminal() {
            // Through a pipe they would have none.
            cargo.arg("--color=always");
        }
        let (mut tests, mut summary) = (Vec::new(), Vec::new());
        let outcome = self.run(what, || {
            shell::run_through(cargo, |output| {
                summary = all_but_last_summary(output, |line| {
                    tests.extend(timed(line).map(|(seconds, name)| (seconds, name.to_owned())));
                    println!("{line}");
                })?;
                Ok(())
            })
        });
        self.tests.append(&mut tests);
        self.summary = summary;
        outcome
    }

    /// Prints the times of all stages, the slowest tests, and last of all the tests' summary.
    pub fn finish(mut self) {
        self.tests.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (seconds, name) in self.tests.iter().take(SLOWEST_COUNT) {
            eprintln!("{seconds:>8.1} s  {name}");
        }
        shell::announce(&format!("{}; in all {:.0} s", self.times(), self.start.elapsed().as_secs_f64()));
        self.summary.iter().for_each(|line| println!("{line}"));
    }

    /// All times in a line.
    pub fn times(&self) -> String {
        let stages: Vec<_> =
            self.times.iter().map(|(what, time)| format!("{what} {:.0} s", time.as_secs_f64())).collect();
        stages.join(", ")
    }
}

/// Time in seconds and name of a test, from the line that a test program prints after it.
fn timed(line: &str) -> Option<(f64, &str)> {
    let (name, outcome) = line.strip_prefix("test ")?.split_once(" ... ")?;
    let (_, time) = outcome.rsplit_once('<')?;
    Some((time.split_once("s>")?.0.parse().ok()?, name))
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
    fn times_are_of_every_stage() {
        let times = vec![("size", Duration::from_secs(3)), ("unit tests", Duration::from_millis(1600))];
        assert_eq!(Stages { times, ..Stages::new() }.times(), "size 3 s, unit tests 2 s");
    }

    #[test]
    fn a_test_is_read_with_its_time() {
        assert_eq!(timed("test a::b - should panic ... ok <1.250s>"), Some((1.25, "a::b - should panic")));
        assert_eq!(timed("test a ... \u{1b}[32mok\u{1b}[m \u{1b}[31m<61.000s>\u{1b}[m"), Some((61.0, "a")));
        assert_eq!(timed("test a ... ignored, nightly: 60 s"), None);
        assert_eq!(timed("test result: ok. 1 passed; 0 failed; finished in 0.00s"), None);
    }

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
