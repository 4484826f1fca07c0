//! A sweep on a cluster with Slurm: an array job, each task of which does a shard, and a job that
//! gathers when all have ended.
//!
//! Slurm decides where and when. A task that is killed or preempted is submitted again, by Slurm or
//! by the same command, and does what is missing.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde::Serialize;

use crate::error::SweepError;
use crate::plan::Plan;
use crate::shard_note;
use recording::Temporary;

/// How a sweep is handed to Slurm.
#[derive(Debug, Clone)]
pub struct SlurmOptions {
    /// The program that the tasks run: `anemo`.
    pub program: PathBuf,
    /// The sweep file.
    pub file: PathBuf,
    /// The folder of the sweep, which all nodes see under this path.
    pub folder: PathBuf,
    /// Number of shards, each a task of the array.
    pub tasks: usize,
    /// Cores of a task.
    pub jobs: usize,
    /// The partition, if it is not Slurm's default.
    pub partition: Option<String>,
    /// More options of `sbatch`, each as `--time=1:00:00`.
    pub options: Vec<String>,
}

/// The jobs that were submitted.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct SlurmJobs {
    /// Number of the array job; none if no run is missing.
    pub array: Option<String>,
    /// The shards that it does.
    pub shards: Vec<usize>,
    /// Number of the job that gathers.
    pub gather: String,
    /// The folder with the scripts and the tasks' messages.
    pub scripts: PathBuf,
}

/// Writes the scripts and submits them: of the array, the shards of which runs are missing.
///
/// # Errors
/// If they cannot be written, or `sbatch` is not there or refuses.
pub fn submit(plan: &Plan, options: &SlurmOptions) -> Result<SlurmJobs, SweepError> {
    let folder = absolute(&options.folder)?;
    let scripts = folder.join("slurm");
    fs::create_dir_all(&scripts).map_err(|error| SweepError::folder(&scripts, &error))?;
    shard_note::write(&folder, options.tasks)?;
    let whole = SlurmOptions { folder, file: absolute(&options.file)?, ..options.clone() };
    let shards: Vec<usize> = plan.missing(&whole.folder, options.tasks).iter().map(|missing| missing.shard).collect();
    let put = |name: &str, text: String| {
        let path = scripts.join(name);
        Temporary::write(&path, text.as_bytes()).map_err(|error| SweepError::folder(&path, &error))?;
        Ok::<_, SweepError>(path)
    };
    let task = format!("--shard \"$SLURM_ARRAY_TASK_ID/{}\" --jobs {}", options.tasks, options.jobs);
    let lines = [format!("--cpus-per-task={}", options.jobs), "--requeue".to_owned()];
    let array = put("array.sh", script(&whole, "%A_%a", &lines, &task))?;
    let gather = put("gather.sh", script(&whole, "gather-%j", &[], "--gather"))?;
    let list: Vec<String> = shards.iter().map(usize::to_string).collect();
    let array = match list.is_empty() {
        true => None,
        false => Some(sbatch(&[&format!("--array={}", list.join(","))], &array)?),
    };
    // Also after tasks that failed: what is missing is to be said.
    let after = array.as_ref().map(|job| format!("--dependency=afterany:{job}"));
    let gather = sbatch(&after.iter().map(String::as_str).collect::<Vec<_>>(), &gather)?;
    Ok(SlurmJobs { array, shards, gather, scripts })
}

/// A job that runs `anemo sweep` with these arguments more.
fn script(options: &SlurmOptions, log: &str, lines: &[String], arguments: &str) -> String {
    let SlurmOptions { program, file, folder, partition, options, .. } = options;
    let partition = partition.as_ref().map(|partition| format!("--partition={partition}"));
    let output = format!("--output={}", folder.join("slurm").join(format!("{log}.log")).display());
    let common = ["--job-name=anemo-sweep".to_owned(), output, "--open-mode=append".to_owned()];
    let lines = common.iter().chain(lines).chain(&partition).chain(options);
    let lines: String = lines.map(|line| format!("#SBATCH {line}\n")).collect();
    let word = |path: &Path| shlex::try_quote(&path.to_string_lossy()).map_or_else(|_| String::new(), String::from);
    let (program, file, folder) = (word(program), word(file), word(folder));
    format!("#!/bin/sh\n{lines}exec {program} sweep {file} -o {folder} {arguments}\n")
}

/// Submits a script; gives the number of the job.
fn sbatch(options: &[&str], script: &Path) -> Result<String, SweepError> {
    let output = Command::new("sbatch").arg("--parsable").args(options).arg(script).output();
    let kept = format!("the script is kept as {}", script.display());
    let output = output.map_err(|error| SweepError::Folder(format!("sbatch cannot be started: {error}; {kept}")))?;
    if !output.status.success() {
        let said = recording::text::one_line(String::from_utf8_lossy(&output.stderr).trim().to_owned());
        return Err(SweepError::Folder(format!("sbatch refuses: {said}; {kept}")));
    }
    // On a cluster of several `JOB;CLUSTER`.
    let said = String::from_utf8_lossy(&output.stdout);
    Ok(said.trim().split(';').next().unwrap_or_default().to_owned())
}

fn absolute(path: &Path) -> Result<PathBuf, SweepError> {
    std::path::absolute(path).map_err(|error| SweepError::folder(path, &error))
}
