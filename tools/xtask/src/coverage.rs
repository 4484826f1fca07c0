//! Lines of `dr-core` that its own unit tests run, file by file, and those that they do not.
//!
//! The compiler counts (`-C instrument-coverage`), LLVM's own two tools make a report of it.
//! Lines of tests are not counted: they would run whatever they test. Tests of other crates and
//! examples in the documentation are not asked: what decides must be tested where it stands.

use crate::{artefacts, install, shell, sources};
use anyhow::{Result, bail};
use std::collections::BTreeMap;

const CRATE: &str = "dr-core";
/// Share of all lines, so many per cent at the least.
const LEAST_PERCENT: f64 = 95.0;

/// Lines of one file that hold code, and whether a test has run them.
type LineHits = BTreeMap<usize, bool>;

pub fn run() -> Result<()> {
    let tools = install::llvm_tools()?;
    let folder = shell::target_directory()?.join("coverage");
    // Built apart: counting changes all code.
    let mut cargo = shell::cargo();
    cargo.args(["test", "--release", "--no-run", "-p", CRATE, "--lib"]);
    cargo.args(["--config", "build.rustflags=['-Cinstrument-coverage']"]);
    let tests = artefacts::executable(cargo.arg("--target-dir").arg(&folder), &CRATE.replace('-', "_"))?;

    let (counts, merged) = (folder.join("counts.profraw"), folder.join("counts.profdata"));
    shell::run(shell::program(&tests).arg("--quiet").env("LLVM_PROFILE_FILE", &counts))?;
    shell::run(shell::program(tools.join("llvm-profdata")).args(["merge", "-sparse", "-o"]).arg(&merged).arg(&counts))?;
    let mut export = shell::program(tools.join("llvm-cov"));
    export.args(["export", "--format=lcov", "--instr-profile"]).arg(&merged).arg(&tests);
    let mut counted = read(&shell::captured(&mut export)?);
    let mut files = BTreeMap::new();
    for file in sources::rust_files(&shell::root())? {
        let Some(name) = file.path.strip_prefix(CRATE).and_then(|path| path.strip_prefix("/src/")) else { continue };
        let path = shell::root().join(&file.path);
        if let Some(mut lines) = counted.remove(&*path.to_string_lossy())
            && file.in_tests.contains(&false)
        {
            lines.retain(|&line, _| !file.in_tests[line - 1]);
            files.insert(name.to_owned(), lines);
        }
    }
    judge(&files)
}

/// Prints the table and refuses too small a share.
fn judge(files: &BTreeMap<String, LineHits>) -> Result<()> {
    let count = |lines: &LineHits| (lines.len(), lines.values().filter(|&&is_run| is_run).count());
    let share = |(all, run): (usize, usize)| if all == 0 { 100.0 } else { 100.0 * run as f64 / all as f64 };
    println!("{:<36} {:>6} {:>7} {:>7}  lines that no test runs", CRATE, "lines", "run", "%");
    let mut total = (0, 0);
    for (name, lines) in files {
        let (all, run) = count(lines);
        println!("{name:<36} {all:>6} {run:>7} {:>7.1}  {}", share((all, run)), missed(lines));
        total = (total.0 + all, total.1 + run);
    }
    println!("{:<36} {:>6} {:>7} {:>7.1}", "all", total.0, total.1, share(total));
    if total.0 == 0 {
        bail!("no line of {CRATE} is in the report: has its folder moved?");
    }
    if share(total) < LEAST_PERCENT {
        bail!(
            "unit tests run {:.1} % of the lines of {CRATE}, {LEAST_PERCENT} % are wanted; what they miss stands above",
            share(total)
        );
    }
    Ok(())
}

/// Numbers of lines that are not run.
fn missed(lines: &LineHits) -> String {
    let missed = lines.iter().filter(|(_, is_run)| !**is_run);
    missed.map(|(line, _)| line.to_string()).collect::<Vec<_>>().join(", ")
}

/// A report in lcov's format: of each file `SF:path`, for each line `DA:number,times`,
/// `end_of_record`.
fn read(report: &str) -> BTreeMap<String, LineHits> {
    let mut files: BTreeMap<String, LineHits> = BTreeMap::new();
    let mut path = "";
    for line in report.lines() {
        if let Some(rest) = line.strip_prefix("SF:") {
            path = rest;
        } else if let Some((number, times)) = line.strip_prefix("DA:").and_then(|rest| rest.split_once(','))
            && let Ok(number) = number.parse()
        {
            *files.entry(path.to_owned()).or_default().entry(number).or_default() |= times != "0";
        }
    }
    files
}

#[cfg(test)]
mod tests {
    use super::*;

    const REPORT: &str = "SF:/a.rs\nFN:1,f\nDA:1,3\nDA:2,0\nDA:5,0\nDA:6,12\nDA:8,0\nLF:5\nLH:2\nend_of_record\nSF:/b.rs\nDA:4,1\nend_of_record\n";

    #[test]
    fn a_line_is_run_if_it_was_counted_once() {
        let files = read(REPORT);
        assert_eq!(files["/a.rs"], [(1, true), (2, false), (5, false), (6, true), (8, false)].into());
        assert_eq!(files["/b.rs"], [(4, true)].into());
        assert_eq!(missed(&files["/a.rs"]), "2, 5, 8");
        assert_eq!(missed(&files["/b.rs"]), "");
    }

    #[test]
    fn too_small_a_share_is_refused() {
        let of = |run: usize| BTreeMap::from([("a.rs".to_owned(), (0..200).map(|line| (line, line < run)).collect())]);
        assert!(judge(&of(190)).is_ok());
        assert!(judge(&of(189)).is_err());
        assert!(judge(&BTreeMap::new()).is_err(), "nothing is not everything");
    }
}
