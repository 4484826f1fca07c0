//! One run of a sweep: its experiments on simulated sensors in this process, then its steps.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use serde_json::{Map, Value};
use tempfile::TempDir;

use crate::columns::{flatten, identifier};
use crate::error::RunFailure;
use crate::plan::Plan;
use crate::run_folder::{RunFolder, RunResult, write_experiments};
use crate::steady::SteadyMeans;
use crate::step::StepPlaces;
use host_sim::experiment::Experiment;
use host_sim::instrument::in_process;
use host_sim::run::{RunError, RunSummary, layout, metadata, outcome, run};
use recording::{RecordingReader, RecordingWriter};

impl Plan {
    /// Does a run, unless its folder is complete already, and gives its results.
    ///
    /// `folder` is that of the sweep; the run has its own in it. Any number of threads and
    /// processes may do runs of one folder at a time, the same run included.
    ///
    /// # Errors
    /// If the run fails, of which its folder has the sentence, or `interrupted` is set meanwhile.
    pub fn run(&self, place: usize, folder: &Path, interrupted: &AtomicBool) -> Result<RunResult, RunFailure> {
        let planned = self.runs().get(place).ok_or_else(|| RunFailure::Unknown(place.to_string()))?;
        let own = RunFolder::new(folder, &planned.hash);
        if let Some(result) = self.complete(&own, place) {
            return Ok(result);
        }
        let attempt = own.begin().map_err(RunFailure::unwritten(own.path()))?;
        let done = self.attempt(place, &own, attempt, interrupted);
        if let Err(RunFailure::Failed(_) | RunFailure::Unwritten(_)) = &done
            && let Some(result) = self.complete(&own, place)
        {
            // Another process has completed it meanwhile, and cleared this one's folder.
            return Ok(result);
        }
        if let Err(RunFailure::Failed(sentence)) = &done {
            own.fail(sentence).map_err(RunFailure::unwritten(own.path()))?;
        }
        done
    }

    /// Does a run in a folder of its own, and hands its files over.
    fn attempt(
        &self,
        place: usize,
        own: &RunFolder,
        attempt: TempDir,
        interrupted: &AtomicBool,
    ) -> Result<RunResult, RunFailure> {
        let outcome = self.conduct(place, attempt.path(), interrupted);
        if matches!(outcome, Err(RunFailure::Interrupted)) {
            return Err(RunFailure::Interrupted);
        }
        let (before, after) = (attempt.path().to_owned(), own.path());
        let result = outcome.map(|results| RunResult::new(&self.runs()[place].hash, results));
        if let Ok(result) = &result {
            RunFolder::write_result(&before, result).map_err(RunFailure::unwritten(&before))?;
        }
        own.take(attempt).map_err(RunFailure::unwritten(after))?;
        // Whoever reads the sentence finds the file where it comes to lie.
        let moved = |sentence: String| sentence.replace(&*before.to_string_lossy(), &after.to_string_lossy());
        result.map_err(|failure| RunFailure::Failed(moved(failure.to_string())))
    }

    /// The same by the run's hash.
    ///
    /// # Errors
    /// As [`Plan::run`], or if the sweep has no such run.
    pub fn run_of(&self, hash: &str, folder: &Path, interrupted: &AtomicBool) -> Result<RunResult, RunFailure> {
        let place = self.place(hash).ok_or_else(|| RunFailure::Unknown(hash.to_owned()))?;
        self.run(place, folder, interrupted)
    }

    /// Whether a run needs not be done any more.
    pub fn is_complete(&self, place: usize, folder: &Path) -> bool {
        self.complete(&RunFolder::new(folder, &self.runs()[place].hash), place).is_some()
    }

    /// The results of a run that is done, its recordings included where they are wanted.
    fn complete(&self, folder: &RunFolder, place: usize) -> Option<RunResult> {
        let has_recordings = || {
            let whole = |path: &Path| RecordingReader::open(path).is_ok();
            self.expanded(place).experiments.iter().all(|of| whole(&folder.recording(&of.stem)))
        };
        folder.result().filter(|_| !self.file.keeps_recordings || has_recordings())
    }

    /// Does a run in a folder; gives its results.
    fn conduct(&self, place: usize, folder: &Path, interrupted: &AtomicBool) -> Result<Map<String, Value>, RunFailure> {
        let expanded = self.expanded(place);
        let experiments = write_experiments(&expanded, folder).map_err(RunFailure::unwritten(folder))?;
        let has_recordings = self.file.keeps_recordings || !self.file.then.is_empty();
        let mut results = Map::new();
        let mut recordings: Vec<PathBuf> = Vec::new();
        for (path, of) in experiments.iter().zip(&expanded.experiments) {
            let recording = has_recordings.then(|| path.with_extension("parquet"));
            let prefix = if experiments.len() > 1 { identifier(&of.stem) } else { String::new() };
            simulate(path, recording.as_deref(), interrupted, &prefix, &mut results)?;
            recordings.extend(recording);
        }
        let own = recordings.first().and_then(|path| path.file_name()).map(PathBuf::from);
        let given = expanded.recording.map(|path| path.canonicalize().unwrap_or(path));
        let recording = given.or(own).unwrap_or_default();
        let (recording, sweep) = (recording.to_string_lossy(), self.folder());
        let places = StepPlaces { recording: &recording, sweep: &sweep.to_string_lossy() };
        for step in &self.file.then {
            if interrupted.load(Ordering::Relaxed) {
                return Err(RunFailure::Interrupted);
            }
            let done = step.run(&self.program, folder, &places, &mut results);
            // A terminal interrupts the step as well, which is then no failure of its own.
            done.map_err(
                |failure| if interrupted.load(Ordering::Relaxed) { RunFailure::Interrupted } else { failure },
            )?;
            RunFolder::refuse_result(folder, step)?;
        }
        if !self.file.keeps_recordings {
            recordings.iter().try_for_each(fs::remove_file).map_err(RunFailure::unwritten(folder))?;
        }
        Ok(results)
    }
}

/// Runs an experiment and adds what it came to, each column with the prefix.
fn simulate(
    path: &Path,
    recording: Option<&Path>,
    interrupted: &AtomicBool,
    prefix: &str,
    results: &mut Map<String, Value>,
) -> Result<(), RunFailure> {
    let experiment = Experiment::read(path)?;
    let instrument = in_process::of_head(experiment.head.elements.len(), experiment.sensor()?);
    let layout = layout(&experiment, true);
    let known = metadata(&experiment, &layout, "sim");
    let mut writer = recording.map(|path| RecordingWriter::create(path, layout, &known)).transpose()?;
    let mut steady = SteadyMeans::new(&experiment);
    let summary = run(&experiment, instrument, &mut |row| {
        steady.add(row);
        writer.as_mut().map_or(Ok(()), |writer| writer.push(row))?;
        if interrupted.load(Ordering::Relaxed) { Err(RunError::Interrupted) } else { Ok(()) }
    })?;
    if interrupted.load(Ordering::Relaxed) {
        return Err(RunFailure::Interrupted);
    }
    if let Some(ended) = &summary.ended {
        return Err(RunFailure::Failed(format!("ended early: {ended}")));
    }
    writer.map_or(Ok(()), |writer| writer.finish(&outcome(&summary)).map(|_| ()))?;
    flatten(prefix, &summarised(&summary, &steady), results);
    Ok(())
}

/// A summary as an object whose keys make the columns.
fn summarised(summary: &RunSummary, steady: &SteadyMeans) -> Value {
    let mut object = match serde_json::to_value(summary) {
        Ok(Value::Object(object)) => object,
        _ => Map::new(),
    };
    // The same in all runs, or in other words below.
    for key in ["title", "head", "firmware", "elements", "unreached", "trips", "hash"] {
        object.remove(key);
    }
    let trip = summary.trips.first();
    let tripped = trip.map(|trip| format!("{}:{}", trip.cause, trip.element)).unwrap_or_default();
    object.insert("head_name".to_owned(), summary.head.clone().into());
    object.insert("state_hash".to_owned(), summary.hash.clone().into());
    object.insert("tripped".to_owned(), tripped.into());
    object.insert("trip_time_s".to_owned(), trip.map(|trip| trip.time_s).into());
    object.insert("unreached".to_owned(), summary.unreached.join(" ").into());
    for (place, element) in summary.elements.iter().enumerate() {
        let mut add = |quantity: &str, value: Option<f64>| {
            object.insert(format!("{quantity}_{}", element.name), value.into());
        };
        add("mean_power_w", Some(element.mean_power_w));
        add("mean_temperature_c", element.mean_temperature_c);
        add("steady_power_w", steady.power_w(place));
        add("steady_temperature_c", steady.temperature_c(place));
    }
    Value::Object(object)
}
