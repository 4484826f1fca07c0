//! Where the experiments of a study are run.

use std::path::PathBuf;

use super::error::StudyError;
use super::record::StudyRecord;
use host_sim::experiment::Experiment;

/// A folder of experiments, and a report of progress.
pub struct StudyLab<'a> {
    folder: PathBuf,
    progress: &'a dyn Fn(&str),
}

impl<'a> StudyLab<'a> {
    /// A folder, and what is called with a line for each experiment.
    pub fn new(folder: impl Into<PathBuf>, progress: &'a dyn Fn(&str)) -> Self {
        Self { folder: folder.into(), progress }
    }

    /// Reads an experiment by the name of its file, without the extension.
    pub fn experiment(&self, name: &str) -> Result<Experiment, StudyError> {
        Ok(Experiment::read(&self.folder.join(format!("{name}.toml")))?)
    }

    /// Reports that an experiment is going to be run.
    pub fn announce(&self, experiment: &Experiment) {
        (self.progress)(&format!("{}, {:.1} h", experiment.title, experiment.duration_s() / 3600.0));
    }

    /// Runs an experiment in process.
    pub fn record(&self, experiment: &Experiment) -> Result<StudyRecord, StudyError> {
        self.announce(experiment);
        StudyRecord::of(experiment)
    }

    /// Reads and runs.
    pub fn run(&self, name: &str) -> Result<(Experiment, StudyRecord), StudyError> {
        let experiment = self.experiment(name)?;
        let record = self.record(&experiment)?;
        Ok((experiment, record))
    }
}
