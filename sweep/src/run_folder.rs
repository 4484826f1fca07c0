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
}

impl RunFolder {
    pub fn new(folder: &Path, hash: &str) -> Self {
        Self { path: folder.join(format!("run={hash}")) }
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

    /// The results, if the run is complete.
    pub fn result(&self) -> Option<RunResult> {
        serde_json::from_slice(&fs::read(self.path.join(RESULT)).ok()?).ok()
    }

    /// Why there are none, if that is known.
    pub fn failed(&self) -> Option<String> {
        let failed: FailedFile = serde_json::from_slice(&fs::read(self.path.join(FAILED)).ok()?).ok()?;
        Some(failed.sentence)
    }

    /// Takes over the files of an attempt.
    pub fn take(&self, attempt: TempDir) -> io::Result<()> {
        for file in fs::read_dir(attempt.path())? {
            let file = file?;
            fs::rename(file.path(), self.path.join(file.file_name()))?;
        }
        attempt.close()
    }

    /// Completes the run, and clears what killed attempts have left.
    pub fn finish(&self, result: &RunResult) -> io::Result<()> {
        for left in fs::read_dir(&self.path)?.flatten() {
            if left.file_name().to_string_lossy().starts_with(ATTEMPT) {
                // It only takes room; an attempt that goes on elsewhere finds the results below.
                let _ = fs::remove_dir_all(left.path());
            }
        }
        Temporary::write(&self.path.join(RESULT), &serde_json::to_vec(result)?)?;
        match fs::remove_file(self.path.join(FAILED)) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
            _ => Ok(()),
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
