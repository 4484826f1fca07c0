//! Stages that take longer than continuous integration has time for, in stages of at most an hour.
//!
//! Each stage runs as a process of its own, writes into a log of its own, and ends as a line in a
//! table. A stage that has passed on the present commit is not repeated, so that an interrupted
//! night goes on where it ended.

use crate::campaign::{self, CampaignKind, CampaignOptions};
use crate::deny::{self, DenyOptions};
use crate::fuzz::{self, FuzzOptions};
use crate::mutants::{self, MutantsOptions};
use crate::programs::{TestPrograms, Tier};
use crate::python::{self, PythonOptions};
use crate::seeded::{self, SeededOptions};
use crate::stages::Stages;
use crate::{artefacts, coverage, dist, miri, shell};
use anyhow::{Context, Result, bail};
use std::fs::{self, File, OpenOptions};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::Instant;

const LONGEST_STAGE_S: u32 = 3_600;
const COLUMNS: &str = "date,commit,stage,outcome,seconds";
const PASSED: &str = "ok";
/// Parts of some 500 changes of the board's files. A night tries one, which the commit chooses.
const MUTANT_PARTS: u64 = 12;
/// For each target.
const FUZZ_MINUTES: f64 = 6.0;

#[derive(clap::Args)]
pub struct NightlyOptions {
    /// Only these stages
    #[arg(value_name = "STAGE")]
    stages: Vec<String>,
    /// Only show the stages and how each has ended last
    #[arg(long)]
    list: bool,
    /// Repeat stages that have passed on this commit
    #[arg(long)]
    again: bool,
    /// Run the stages in this process, without a log and a line in the table
    #[arg(long, requires = "stages")]
    here: bool,
}

struct NightlyStage {
    name: &'static str,
    what: &'static str,
    run: fn() -> Result<()>,
}

const fn stage(name: &'static str, what: &'static str, run: fn() -> Result<()>) -> NightlyStage {
    NightlyStage { name, what, run }
}

/// Stages that fail for most reasons come first.
const STAGES: [NightlyStage; 23] = [
    stage("long-tests", "tests that are marked `nightly`, of all crates", long_tests),
    stage("gallery", "notebooks of the Python package beside other libraries", gallery),
    stage("slurm", "sweeps of the Python package on a cluster of this computer", slurm),
    stage("deny", "licences and sources of dependencies", || deny::run(&DenyOptions::default())),
    stage("coverage", "lines of dr-core that its unit tests run", coverage::run),
    stage("miri", "undefined behaviour: all unit tests short enough for an interpreter", miri::run),
    stage("lives", "random lives of the sensor board's image", || campaign(CampaignKind::Lives)),
    stage("flips", "bits that flip in the RAM of the sensor board's image", || campaign(CampaignKind::Flips)),
    stage("soak", "hours of a run of the sensor board's image", || campaign(CampaignKind::Soak)),
    stage("starts", "starts and changed settings of the sensor board's image", || campaign(CampaignKind::Starts)),
    stage("endings", "ways in which runs and logs end", || campaign(CampaignKind::Endings)),
    stage("power-cuts", "cuts of a recording host's supply", || campaign(CampaignKind::PowerCuts)),
    stage("log", "a day of a log at 1 kHz", || campaign(CampaignKind::Log)),
    stage("seeded", "defects put into the sensor board's firmware", || seeded::run(&SeededOptions::default())),
    stage("seeded-mutants", "changes of the sensor board's files and drivers, a part", seeded_mutants),
    stage("mutants-0", "changes of dr-core, the first half", || mutants("0/2")),
    stage("mutants-1", "changes of dr-core, the other half", || mutants("1/2")),
    stage("fuzz", "inputs that break a reader or the controller", || fuzz::run(&FuzzOptions::of(FUZZ_MINUTES))),
    stage("thesis", "findings of the thesis on simulated sensors", || study(&["thesis"])),
    stage("benchmark", "winds, operating modes, field, capacitors and heads in numbers", benchmark),
    stage("drift", "gains of a heater in a room that moves", || study(&["benchmark", "drift", "--records", "100"])),
    stage("benches", "speeds of the hot paths", benches),
    stage("dist", "the archive of a release", dist::run),
];

pub fn run(options: &NightlyOptions) -> Result<()> {
    if let Some(name) = options.stages.iter().find(|name| !STAGES.iter().any(|stage| stage.name == **name)) {
        bail!("there is no stage {name}; `cargo xtask nightly --list` shows all");
    }
    let is_wanted = |stage: &&NightlyStage| options.stages.is_empty() || options.stages.iter().any(|s| s == stage.name);
    let wanted = || STAGES.iter().filter(is_wanted);
    if options.here {
        return wanted().try_for_each(|stage| (stage.run)());
    }
    let night = Night::new()?;
    let results = night.results()?;
    if options.list {
        for NightlyStage { name, what, .. } in wanted() {
            println!("{name:16}{what:68}{}", last(&results, name).unwrap_or("never run"));
        }
        return Ok(());
    }
    let mut failed = Vec::new();
    for stage in wanted() {
        if !options.again && has_passed(&results, stage.name, &night.commit) {
            shell::announce(&format!("{}: has passed on this commit", stage.name));
            continue;
        }
        let outcome = night.stage(stage.name)?;
        if outcome != PASSED {
            failed.push(format!("{} ({outcome})", stage.name));
        }
    }
    if failed.is_empty() { Ok(()) } else { bail!("these stages have not passed: {}", failed.join(", ")) }
}

/// Where results are kept, and the code that they are of.
struct Night {
    folder: PathBuf,
    /// With a `+` where files differ from it.
    commit: String,
}

impl Night {
    fn new() -> Result<Self> {
        let folder = shell::target_directory()?.join("nightly");
        fs::create_dir_all(&folder).with_context(|| format!("{} cannot be made", folder.display()))?;
        let git = |arguments: &[&str]| shell::output_of("git", arguments);
        let head = git(&["rev-parse", "--short=12", "HEAD"]).unwrap_or_default();
        let is_clean = git(&["status", "--porcelain"]).is_some_and(|changed| changed.is_empty());
        Ok(Self { folder, commit: if is_clean { head } else { head + "+" } })
    }

    fn table(&self) -> PathBuf {
        self.folder.join("results.csv")
    }

    fn results(&self) -> Result<String> {
        let table = self.table();
        if !table.exists() {
            fs::write(&table, format!("{COLUMNS}\n"))
                .with_context(|| format!("{} cannot be written", table.display()))?;
        }
        fs::read_to_string(&table).with_context(|| format!("{} cannot be read", table.display()))
    }

    /// Runs a stage and adds its line. Returns how it has ended.
    fn stage(&self, name: &str) -> Result<&'static str> {
        let log = self.folder.join(format!("{name}.log"));
        shell::announce(&format!("{name}; its output goes into {}", log.display()));
        let start = Instant::now();
        let outcome = run_apart(name, &log)?;
        let seconds = start.elapsed().as_secs();
        let date = shell::output_of("date", &["-u", "+%FT%TZ"]).unwrap_or_default();
        let line = format!("{date},{},{name},{outcome},{seconds}\n", self.commit);
        OpenOptions::new().append(true).open(self.table())?.write_all(line.as_bytes())?;
        print!("{line}");
        if outcome != PASSED {
            let told = String::from_utf8_lossy(&fs::read(&log)?).into_owned();
            let lines: Vec<_> = told.lines().collect();
            lines[lines.len().saturating_sub(20)..].iter().for_each(|line| println!("    {line}"));
        }
        Ok(outcome)
    }
}

/// Runs a stage in a process of its own, which is ended with all that it has started after an hour.
fn run_apart(name: &str, log: &Path) -> Result<&'static str> {
    let output = File::create(log).with_context(|| format!("{} cannot be written", log.display()))?;
    let mut apart = shell::limited(LONGEST_STAGE_S, std::env::current_exe()?);
    apart.args(["nightly", "--here", name]);
    apart.stdin(Stdio::null()).stdout(output.try_clone()?).stderr(output);
    let status = apart.status().context("`timeout` cannot be started")?;
    Ok(match status.code() {
        Some(0) => PASSED,
        Some(shell::TIMED_OUT) => "too long",
        _ => "failed",
    })
}

/// The last line of a stage.
fn last<'a>(table: &'a str, stage: &str) -> Option<&'a str> {
    table.lines().rfind(|line| line.contains(&format!(",{stage},")))
}

/// Says if the last run of a stage on a commit has passed. Files that differ from their commit may
/// have changed since.
fn has_passed(table: &str, stage: &str, commit: &str) -> bool {
    let run = format!(",{commit},{stage},");
    let last = table.lines().rfind(|line| line.contains(&run));
    !commit.is_empty() && !commit.ends_with('+') && last.is_some_and(|line| line.contains(&format!("{run}{PASSED},")))
}

fn long_tests() -> Result<()> {
    let mut stages = Stages::new();
    let programs = stages.run("building the tests", || TestPrograms::build(Tier::Ci))?;
    let outcome = stages.test("long tests", &mut programs.all(), &["--ignored"]);
    stages.finish();
    outcome
}

fn campaign(kind: CampaignKind) -> Result<()> {
    campaign::run(&CampaignOptions::nightly(kind))
}

fn mutants(shard: &str) -> Result<()> {
    mutants::run(&MutantsOptions::of(shard))
}

fn seeded_mutants() -> Result<()> {
    let commit = shell::output_of("git", &["rev-parse", "--short=15", "HEAD"]);
    let seed = commit.and_then(|commit| u64::from_str_radix(&commit, 16).ok()).unwrap_or_default();
    seeded::run(&SeededOptions::mutants(&format!("{}/{MUTANT_PARTS}", seed % MUTANT_PARTS)))
}

fn gallery() -> Result<()> {
    python::run(&PythonOptions { gallery: true, ..PythonOptions::default() })?;
    python::run(&PythonOptions { numbers: true, ..PythonOptions::default() })
}

fn slurm() -> Result<()> {
    crate::counterparts::run()?;
    python::run(&PythonOptions { nightly: true, ..PythonOptions::default() })
}

fn benchmark() -> Result<()> {
    ["wind", "modes", "field", "heads"].iter().try_for_each(|name| study(&["benchmark", name]))?;
    study(&["benchmark", "mems", "--experiments", "experiments/mems"])
}

/// Writes pages of results into a folder of the night.
fn study(arguments: &[&str]) -> Result<()> {
    let folder = shell::target_directory()?.join("nightly/results");
    let studies = artefacts::anemo_and_studies()?.with_file_name("studies");
    shell::run(shell::program(studies).args(arguments).arg("-o").arg(folder))
}

fn benches() -> Result<()> {
    let firmware = artefacts::firmware(artefacts::FirmwareBoard::Virtual)?;
    shell::run(shell::cargo_of_all("bench").env("ANEMO_FIRMWARE", firmware).args(["--benches"]))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str = "date,commit,stage,outcome,seconds\n\
        2026-01-01T00:00:00Z,aa,fuzz,ok,9\n\
        2026-01-02T00:00:00Z,aa,lives,ok,8\n\
        2026-01-03T00:00:00Z,aa,lives,failed,7\n\
        2026-01-04T00:00:00Z,bb+,fuzz,ok,6\n";

    #[test]
    fn a_stage_is_repeated_unless_it_has_passed_last_on_the_very_commit() {
        assert!(has_passed(TABLE, "fuzz", "aa"));
        assert!(!has_passed(TABLE, "lives", "aa"), "it has failed since");
        assert!(!has_passed(TABLE, "fuzz", "bb+"), "its files may be others now");
        assert!(!has_passed(TABLE, "fuzz", "cc") && !has_passed(TABLE, "fuzz", ""));
        assert_eq!(last(TABLE, "fuzz"), Some("2026-01-04T00:00:00Z,bb+,fuzz,ok,6"));
    }

    #[test]
    fn names_of_stages_differ() {
        let mut names: Vec<_> = STAGES.iter().map(|stage| stage.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), STAGES.len());
    }
}
