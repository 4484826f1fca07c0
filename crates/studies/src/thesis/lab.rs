//! Where the experiments of a study are run.

use std::path::PathBuf;

use super::error::StudyError;
use super::record::StudyRecord;
use host_sim::experiment::Experiment;
use host_sim::sensor::WindEntry;

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

/// An experiment's first two winds in turn, sampled every so often: the first of them until
/// `before_s`, then so many stretches of `hold_s`, the second wind first.
pub fn alternating(
    base: &Experiment,
    before_s: f64,
    hold_s: f64,
    stretches: usize,
    sample_period_s: f64,
) -> Result<Experiment, StudyError> {
    let [calm, gust, ..] = &base.wind[..] else {
        return Err(StudyError::Other(format!("{}: its wind does not step", base.title)));
    };
    let stretch = |n: usize| {
        let of = if n.is_multiple_of(2) { gust } else { calm };
        WindEntry { start_s: before_s + n as f64 * hold_s, ..of.clone() }
    };
    let first = WindEntry { start_s: 0.0, ..calm.clone() };
    let duration_s = before_s + stretches as f64 * hold_s;
    Ok(Experiment {
        sample_period_s,
        ticks: (duration_s / sample_period_s).round() as u32,
        wind: std::iter::once(first).chain((0..stretches).map(stretch)).collect(),
        ..base.clone()
    })
}
