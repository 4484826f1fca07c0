//! Where the experiments of a study are run.

use std::path::PathBuf;

use super::record::Record;
use crate::experiment::Experiment;
use crate::identify::IdentifyError;
use crate::identify::record::RecordError;
use crate::identify::validate::ValidateError;
use crate::plot::PlotError;
use crate::run::RunError;
use crate::toml_file::FileError;

/// Why a study came to no end.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    #[error(transparent)]
    File(#[from] FileError),
    #[error(transparent)]
    Run(#[from] RunError),
    #[error(transparent)]
    Record(#[from] RecordError),
    #[error(transparent)]
    Identify(#[from] IdentifyError),
    #[error(transparent)]
    Validate(#[from] ValidateError),
    #[error(transparent)]
    Plot(#[from] PlotError),
    #[error("{0}")]
    Other(String),
}

/// A folder of experiments, and somebody who is told what goes on.
pub struct Lab<'a> {
    folder: PathBuf,
    told: &'a dyn Fn(&str),
}

impl<'a> Lab<'a> {
    pub fn new(folder: impl Into<PathBuf>, told: &'a dyn Fn(&str)) -> Self {
        Self { folder: folder.into(), told }
    }

    /// Reads an experiment by the name of its file, without the extension.
    pub fn experiment(&self, name: &str) -> Result<Experiment, StudyError> {
        Ok(Experiment::read(&self.folder.join(format!("{name}.toml")))?)
    }

    /// Tells that an experiment is going to be run.
    pub fn tell(&self, experiment: &Experiment) {
        (self.told)(&format!("{}, {:.1} h", experiment.title, experiment.duration_s() / 3600.0));
    }

    /// Runs an experiment in process.
    pub fn record(&self, experiment: &Experiment) -> Result<Record, StudyError> {
        self.tell(experiment);
        Record::of(experiment)
    }

    /// Reads and runs.
    pub fn run(&self, name: &str) -> Result<(Experiment, Record), StudyError> {
        let experiment = self.experiment(name)?;
        let record = self.record(&experiment)?;
        Ok((experiment, record))
    }
}
