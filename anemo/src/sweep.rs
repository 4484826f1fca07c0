//! `anemo sweep`: many runs of an experiment, here, in parts, or on a cluster.

use std::path::{Path, PathBuf};
use std::thread::available_parallelism;

use crate::choice::at_least_one;
use crate::output::Failure;
use crate::program::own_program;
use crate::progress::{on_interrupt, progress};
use sweep::slurm::{SlurmOptions, submit};
use sweep::{Plan, Shard, SweepError};

/// Run an experiment over many values of any keys of experiment, head and models, and gather the
/// results in one table.
///
/// Every run has a folder named by the hash of all that it consists of: interrupted or run again, a
/// sweep does only what is missing, and two machines' results can be compared. Runs that fail are
/// listed and do not stop the others; a run that trips is a result.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo sweep experiments/sweeps/winds.toml --dry-run
  anemo sweep experiments/sweeps/winds.toml
  anemo sweep experiments/sweeps/fleet.toml -o fleet --jobs 1
  anemo sweep experiments/sweeps/winds.toml -o parts --shard 1/2
  anemo sweep experiments/sweeps/winds.toml -o parts --shard 2/2
  anemo sweep experiments/sweeps/winds.toml -o parts --gather
  anemo sweep experiments/sweeps/winds.toml --slurm --tasks 8 --partition day

Exit codes: 0 done, 1 runs failed, 2 wrong usage, 4 runs are missing.")]
pub struct Arguments {
    /// The sweep: a TOML file.
    file: PathBuf,
    /// The folder for runs and results; by default one named as the file, here.
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Runs at a time; by default one for every core, and one in a task of Slurm.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = at_least_one)]
    jobs: Option<usize>,
    /// Do every n-th run only, as the k-th of n parts, and gather nothing.
    #[arg(long, value_name = "K/N", conflicts_with_all = ["gather", "slurm"])]
    shard: Option<Shard>,
    /// Run nothing: write the table of what is there.
    #[arg(long, conflicts_with = "slurm")]
    gather: bool,
    /// List the runs, and do nothing.
    #[arg(long)]
    dry_run: bool,
    /// Submit the sweep to Slurm: a job array of shards, then a job that gathers.
    #[arg(long)]
    slurm: bool,
    /// Number of tasks of the job array.
    #[arg(long, value_name = "N", default_value = "16", requires = "slurm", allow_negative_numbers = true, value_parser = at_least_one)]
    tasks: usize,
    /// Slurm's partition.
    #[arg(long, value_name = "NAME", requires = "slurm")]
    partition: Option<String>,
    /// Another option of sbatch, as `--sbatch=--time=1:00:00`; may be given again.
    #[arg(long, value_name = "OPTION", requires = "slurm", allow_hyphen_values = true)]
    sbatch: Vec<String>,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

/// `refusal` says what is wrong with a command line, the words behind `anemo`.
pub fn execute(arguments: &Arguments, refusal: impl Fn(&[String]) -> Option<String>) -> Result<(), Failure> {
    let program = own_program()?;
    let plan = Plan::read(&arguments.file).and_then(|plan| plan.with_program(program.clone(), refusal));
    let plan = plan.map_err(failure)?;
    if arguments.dry_run {
        return print_runs(&plan, arguments);
    }
    let name = arguments.file.file_stem().unwrap_or_default();
    let folder = arguments.output.clone().unwrap_or_else(|| PathBuf::from(name));
    if arguments.slurm {
        return submit_to_slurm(&plan, arguments, program, folder);
    }
    if arguments.gather && !folder.is_dir() {
        return Err(Failure::in_file(&folder, "there is no such folder, and nothing to gather"));
    }
    if !arguments.gather {
        let interrupted = work(&plan, arguments, &folder)?;
        if arguments.shard.is_some() {
            return settle_shard(&plan, arguments, &folder, interrupted);
        }
    }
    let report = plan.gather(&folder).map_err(failure)?;
    crate::output::print_report(&report, arguments.json)?;
    match (report.incomplete(), report.failed.len()) {
        (Some(sentence), _) => Err(Failure { code: 4, sentence }),
        (None, 0) => Ok(()),
        (None, failed) => Err(Failure::work(format!("{failed} of {} runs failed", report.runs))),
    }
}

/// Does what is missing; says whether it was interrupted.
fn work(plan: &Plan, arguments: &Arguments, folder: &Path) -> Result<bool, Failure> {
    let jobs = arguments.jobs.unwrap_or_else(|| available_parallelism().map_or(1, usize::from));
    let interrupted = on_interrupt();
    let runs = plan.places(arguments.shard).len();
    let bar = progress(plan.title(), Some(runs as u64));
    let done = plan.work(folder, arguments.shard, jobs, &interrupted, &|settled| bar.set_position(settled as u64));
    bar.finish_and_clear();
    done.map(|done| done.interrupted).map_err(failure)
}

/// A shard reports its own runs only.
fn settle_shard(plan: &Plan, arguments: &Arguments, folder: &Path, interrupted: bool) -> Result<(), Failure> {
    let places = plan.places(arguments.shard);
    let complete = places.iter().filter(|place| plan.is_complete(**place, folder)).count();
    if interrupted {
        let sentence = format!("interrupted: {complete} of {} runs are done and kept", places.len());
        return Err(Failure { code: 4, sentence });
    }
    let (runs, failed) = (places.len(), places.len() - complete);
    if failed > 0 {
        return Err(Failure::work(format!("{failed} of {runs} runs failed; --gather lists them")));
    }
    match arguments.json {
        true => crate::output::print_json(&serde_json::json!({ "runs": runs, "complete": complete })),
        false => crate::output::print(&format!("{complete} of {runs} runs are complete\n")),
    }
}

fn submit_to_slurm(plan: &Plan, arguments: &Arguments, program: PathBuf, folder: PathBuf) -> Result<(), Failure> {
    let options = SlurmOptions {
        program,
        file: arguments.file.clone(),
        folder,
        tasks: arguments.tasks.min(plan.places(None).len()),
        jobs: arguments.jobs.unwrap_or(1),
        partition: arguments.partition.clone(),
        options: arguments.sbatch.clone(),
    };
    let jobs = submit(plan, &options).map_err(failure)?;
    if arguments.json {
        return crate::output::print_json(&jobs);
    }
    let array = jobs.array.map_or("no run is missing".to_owned(), |array| {
        format!("job {array}: {} of {} shards", jobs.shards.len(), options.tasks)
    });
    let scripts = jobs.scripts.display();
    crate::output::print(&format!("{array}; job {} gathers; scripts and messages in {scripts}\n", jobs.gather))
}

/// A run as `--dry-run` lists it.
#[derive(serde::Serialize)]
struct ListedRun<'a> {
    run: &'a str,
    keys: String,
}

fn print_runs(plan: &Plan, arguments: &Arguments) -> Result<(), Failure> {
    let places = plan.places(arguments.shard);
    let runs: Vec<ListedRun<'_>> =
        places.iter().map(|place| ListedRun { run: &plan.runs()[*place].hash, keys: plan.described(*place) }).collect();
    if arguments.json {
        return crate::output::print_json(&serde_json::json!({ "title": plan.title(), "runs": runs }));
    }
    let lines: String = runs.iter().map(|run| format!("{}  {}\n", run.run, run.keys)).collect();
    crate::output::print(&format!("{lines}{}\n", recording::text::count(runs.len(), "run")))
}

fn failure(error: SweepError) -> Failure {
    match error {
        SweepError::File(error) => error.into(),
        other => Failure::work(other),
    }
}
