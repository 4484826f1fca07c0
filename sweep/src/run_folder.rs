//! The folder of a run: `run=HASH`, which tools for partitioned tables take for the column `run`.
//!
//! | file | what |
//! |---|---|
//! | `NAME.toml`, `NAME.head.toml`, `NAME.models.toml` | the experiment as it is run |
//! | `NAME.parquet` | its recording, if it is kept |
//! | `attempts.log` | a line when a process begins the run |
//! | `steps.log`, `*.summary.json` | what the steps said and found |
//! | `result.json` | the results; it comes last, and a folder that has it is complete |
//! | `failed.json` | why there are none |
//!
//! A run is done in a folder `.attempt-…` in there, whose files are moved when it has ended. So two
//! processes that do the same run at once do not meet; they come to the same.

use std::fs::{self, OpenOptions};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use tempfile::{Builder, TempDir};
use twox_hash::XxHash3_128;

use crate::documents::{ExpandedExperiment, ExpandedRun};
use crate::error::RunFailure;
use crate::step::StepCommand;
use recording::Temporary;

const RESULT: &str = "result.json";
const FAILED: &str = "failed.json";
const ATTEMPT: &str = ".attempt-";

/// What a run came to.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct RunResult {
    /// Hash of the run.
    pub run: String,
    /// Hash of the results: equal on two machines whose results are.
    pub result_hash: String,
    /// The results by their columns: numbers, truth values and texts.
    pub results: Map<String, Value>,
}

impl RunResult {
    pub(crate) fn new(run: &str, results: Map<String, Value>) -> Self {
        let text = Value::Object(results.clone()).to_string();
        Self { run: run.to_owned(), result_hash: format!("{:032x}", XxHash3_128::oneshot(text.as_bytes())), results }
    }
}

#[derive(Serialize, Deserialize)]
struct FailedFile {
    sentence: String,
}

/// The folder of a run.
#[derive(Debug, Clone)]
pub(crate) struct RunFolder {
    path: PathBuf,
    hash: String,
}

impl RunFolder {
    pub fn new(folder: &Path, hash: &str) -> Self {
        Self { path: folder.join(format!("run={hash}")), hash: hash.to_owned() }
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Makes the folder, notes that this process begins the run, and makes a folder to do it in.
    pub fn begin(&self) -> io::Result<TempDir> {
        fs::create_dir_all(&self.path)?;
        let mut log = OpenOptions::new().create(true).append(true).open(self.path.join("attempts.log"))?;
        // In one piece, so that lines of two processes do not mix.
        log.write_all(format!("{} process {}\n", recording::utc::now(), std::process::id()).as_bytes())?;
        Builder::new().prefix(ATTEMPT).tempdir_in(&self.path)
    }

    /// The recording of an experiment.
    pub fn recording(&self, stem: &str) -> PathBuf {
        self.path.join(format!("{stem}.parquet"))
    }

    /// The results, if the run is complete: those of another run, or changed ones, are none.
    pub fn result(&self) -> Option<RunResult> {
        let read: RunResult = serde_json::from_slice(&fs::read(self.path.join(RESULT)).ok()?).ok()?;
        Some(RunResult::new(&self.hash, read.results.clone())).filter(|whole| *whole == read)
    }

    /// Why there are none, if that is known.
    pub fn failed(&self) -> Option<String> {
        let failed: FailedFile = serde_json::from_slice(&fs::read(self.path.join(FAILED)).ok()?).ok()?;
        Some(failed.sentence)
    }

    /// Writes the results into the folder of an attempt.
    pub fn write_result(attempt: &Path, result: &RunResult) -> io::Result<()> {
        fs::write(attempt.join(RESULT), serde_json::to_vec(result)?)
    }

    /// Refuses and removes a file of a step in the place of the results.
    pub fn refuse_result(attempt: &Path, step: &StepCommand) -> Result<(), RunFailure> {
        let own = attempt.join(RESULT);
        if !own.exists() {
            return Ok(());
        }
        fs::remove_file(&own).map_err(RunFailure::unwritten(&own))?;
        let shown = step.words.join(" ");
        Err(RunFailure::Failed(format!("`{shown}`: writes {RESULT}, which is the sweep's: name another file")))
    }

    /// Takes over the files of an attempt, the results last. None waits for the disk: what a power
    /// cut leaves of them cannot be read, and the run is done again.
    pub fn take(&self, attempt: TempDir) -> io::Result<()> {
        let mut names: Vec<_> =
            fs::read_dir(attempt.path())?.map(|file| Ok(file?.file_name())).collect::<io::Result<_>>()?;
        names.sort_by_key(|name| name == RESULT);
        names.iter().try_for_each(|name| fs::rename(attempt.path().join(name), self.path.join(name)))?;
        if names.last().is_some_and(|name| name == RESULT) {
            self.clear();
        }
        Ok(())
    }

    /// Removes what earlier attempts have left, which only takes room: an attempt that goes on
    /// elsewhere finds the results.
    fn clear(&self) {
        let _ = fs::remove_file(self.path.join(FAILED));
        for left in fs::read_dir(&self.path).into_iter().flatten().flatten() {
            if left.file_name().to_string_lossy().starts_with(ATTEMPT) {
                let _ = fs::remove_dir_all(left.path());
            }
        }
    }

    /// Notes why the run is not complete.
    pub fn fail(&self, sentence: &str) -> io::Result<()> {
        let file = FailedFile { sentence: sentence.to_owned() };
        Temporary::write(&self.path.join(FAILED), &serde_json::to_vec(&file)?)
    }
}

/// Writes the files of a run's experiments; gives the paths of the experiments.
pub(crate) fn write_experiments(run: &ExpandedRun, folder: &Path) -> io::Result<Vec<PathBuf>> {
    let write = |of: &ExpandedExperiment| {
        let path = |kind: &str| folder.join(format!("{}{kind}.toml", of.stem));
        fs::write(path(".head"), &of.head)?;
        of.models.as_ref().map_or(Ok(()), |models| fs::write(path(".models"), models))?;
        fs::write(path(""), &of.experiment)?;
        Ok(path(""))
    };
    run.experiments.iter().map(write).collect()
}
