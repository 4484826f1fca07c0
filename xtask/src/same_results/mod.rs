//! Whether two builds of the command `anemo`, an older one and this tree's, give the same results,
//! to the bit.
//!
//! Both run every experiment in process (all of them: the longest takes 10 s), and then the chain
//! of analyses of [`steps`]: the older one from its own recordings, this tree's once from those of
//! the older one and once from its own. What they print with `--json`, their exit codes and the
//! tables that they write are compared, number by number as text. Names that have changed meanwhile
//! are translated by [`renamed`]; a key that only one of them has is named, and no fault. Sentences
//! for people are not compared.

mod compare;
mod renamed;
mod steps;

use crate::{artefacts, shell, sources};
use anyhow::{Context, Result, bail};
use compare::{CommandResult, ResultComparison};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use steps::AnalysisStep;

#[derive(clap::Args)]
pub struct SameResultsOptions {
    /// The older command `anemo`
    old: PathBuf,
    /// The newer one; by default that of this tree, which is built
    new: Option<PathBuf>,
    /// The experiments that both run; by default those of this tree
    #[arg(long, value_name = "FOLDER")]
    experiments: Option<PathBuf>,
    /// Also what takes minutes: identify the network of a sphere, calibrate it, and read the wind
    /// from it
    #[arg(long)]
    long: bool,
}

/// What was done, by name, and what it has come to.
type CommandResults = Vec<(String, CommandResult)>;

/// One of the two commands, and where it finds and leaves its files.
struct Build {
    program: PathBuf,
    experiments: PathBuf,
    recordings: PathBuf,
    work: PathBuf,
    steps: Vec<AnalysisStep>,
}

pub fn run(options: &SameResultsOptions) -> Result<()> {
    let absolute = |path: &Path| path.canonicalize().with_context(|| format!("there is no {}", path.display()));
    let old = absolute(&options.old)?;
    let new = options.new.as_deref().map_or_else(artefacts::anemo, absolute)?;
    let experiments = options.experiments.as_deref().map_or_else(|| Ok(shell::root().join("experiments")), absolute)?;
    let folder = shell::target_directory()?.join("same-results");
    let build = |program: &Path, recordings: &str, work: &str| -> Result<Build> {
        let (recordings, work) = (folder.join(recordings), folder.join(work));
        std::fs::create_dir_all(&recordings)?;
        if work.exists() {
            std::fs::remove_dir_all(&work)?;
        }
        std::fs::create_dir_all(&work)?;
        let steps = steps::read()?.into_iter().filter(|step| options.long || !step.is_long).collect();
        Ok(Build { program: program.to_path_buf(), experiments: experiments.clone(), recordings, work, steps })
    };
    let before = build(&old, "old", "old-analyses")?;
    let handed_over = build(&new, "old", "new-analyses-of-old")?;
    let after = build(&new, "new", "new-analyses")?;

    shell::announce("experiments, by both");
    let [old_runs, new_runs] = together([&|| before.experiments(), &|| after.experiments()]);
    let mut rows = Vec::new();
    // Both do the same, in the same order.
    let mut add = |old: &CommandResults, new: &CommandResults, kind: &str, source: &str| {
        for ((name, old), (_, new)) in old.iter().zip(new) {
            rows.push((format!("{kind}: {name}{source}"), ResultComparison::of(old, new)));
        }
    };
    add(&old_runs?, &new_runs?, "experiment", "");
    shell::announce("analyses, by both");
    let [old, of_old, own] = together([&|| before.analyses(), &|| handed_over.analyses(), &|| after.analyses()]);
    let old = old?;
    add(&old, &of_old?, "analysis", ", older recordings");
    add(&old, &own?, "analysis", ", own recordings");
    compare::print(&rows);
    match rows.iter().filter(|(_, comparison)| !comparison.different.is_empty()).count() {
        0 => Ok(()),
        faults => bail!("{faults} results differ; files are kept in {}", folder.display()),
    }
}

/// Does all of these at once, each in a thread of its own.
fn together<const N: usize>(jobs: [&(dyn Fn() -> Result<CommandResults> + Sync); N]) -> [Result<CommandResults>; N] {
    std::thread::scope(|scope| {
        let threads = jobs.map(|job| scope.spawn(job));
        threads.map(|thread| thread.join().unwrap_or_else(|_| bail!("a thread has ended early")))
    })
}

impl Build {
    /// Runs every experiment. Those that a step asks for are recorded.
    fn experiments(&self) -> Result<CommandResults> {
        let mut outcomes = Vec::new();
        for path in sources::files_with_extension(&self.experiments, "toml")? {
            let name = path.strip_prefix(&self.experiments).unwrap_or(&path).with_extension("");
            let name = name.to_string_lossy().replace('\\', "/");
            let recording = format!("{}.parquet", name.replace('/', "-"));
            let mut command = Command::new(&self.program);
            command.arg("run").arg(&path).args(["--on", "sim", "--json"]);
            if self.steps.iter().any(|step| step.arguments.contains(&format!("{{recordings}}/{recording}"))) {
                command.arg("-o").arg(self.recordings.join(&recording));
            }
            outcomes.push((name, self.outcome(&mut command, None)?));
        }
        if outcomes.is_empty() {
            bail!("{} has no experiments", self.experiments.display());
        }
        Ok(outcomes)
    }

    /// Goes through the chain.
    fn analyses(&self) -> Result<CommandResults> {
        let mut outcomes = Vec::new();
        for step in &self.steps {
            let mut command = Command::new(&self.program);
            command.args(self.spelled(step)?.split(' ')).args(step.arguments.iter().map(|text| self.filled(text)));
            outcomes.push((step.name.clone(), self.outcome(command.arg("--json"), step.table())?));
        }
        Ok(outcomes)
    }

    /// A subcommand as this build calls it.
    fn spelled<'a>(&self, step: &'a AnalysisStep) -> Result<&'a str> {
        let Some(older) = &step.older_command else { return Ok(&step.command) };
        let mut help = Command::new(&self.program);
        help.args(step.command.split(' ')).arg("--help").stdout(Stdio::null()).stderr(Stdio::null());
        let is_known = help.status().context("anemo cannot be started")?.success();
        Ok(if is_known { &step.command } else { older })
    }

    fn filled(&self, argument: &str) -> String {
        let text = |folder: &Path| folder.to_string_lossy().into_owned();
        argument
            .replace("{experiments}", &text(&self.experiments))
            .replace("{recordings}", &text(&self.recordings))
            .replace("{fixtures}", &text(&shell::root().join("tests/fixtures")))
            .replace("{work}", &text(&self.work))
    }

    /// Runs a command to its end. `table` is a file that it writes.
    fn outcome(&self, command: &mut Command, table: Option<&String>) -> Result<CommandResult> {
        let output = command.stdin(Stdio::null()).output().context("anemo cannot be started")?;
        let mut values = compare::values(&String::from_utf8_lossy(&output.stdout));
        if let Some(table) = table {
            // Where none is written, the other one's cells are missing.
            values.extend(compare::cells(&std::fs::read_to_string(self.filled(table)).unwrap_or_default()));
        }
        let errors = String::from_utf8_lossy(&output.stderr).into();
        Ok(CommandResult { exit_code: output.status.code(), values, errors })
    }
}
