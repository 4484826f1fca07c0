//! `anemo._anemo.Sweep`: the plan of a sweep, for engines that hand out its runs.

use std::path::PathBuf;
use std::sync::Arc;

use ::sweep::{Plan, RunFailure};
use pyo3::prelude::*;

use crate::commands::waited_for;
use crate::error::error;

/// The runs of a sweep file.
#[pyclass(module = "anemo._anemo", frozen)]
pub struct Sweep {
    plan: Arc<Plan>,
}

#[pymethods]
impl Sweep {
    /// Reads a sweep file; steps are run by `program`.
    #[new]
    fn new(py: Python<'_>, file: PathBuf, program: PathBuf) -> PyResult<Self> {
        let plan = py.detach(|| Plan::read(&file)?.with_program(program, anemo::refusal));
        Ok(Self { plan: Arc::new(plan.map_err(|reason| error(py, 2, &reason))?) })
    }

    /// The hash of every run; equal runs once.
    #[getter]
    fn runs(&self) -> Vec<String> {
        self.plan.places(None).into_iter().map(|place| self.plan.runs()[place].hash.clone()).collect()
    }

    /// Does a run in a folder, unless it is complete; gives the sentence of its failure.
    fn run(&self, py: Python<'_>, hash: String, folder: PathBuf) -> PyResult<Option<String>> {
        let plan = Arc::clone(&self.plan);
        let (done, signal) = waited_for(py, move |interrupted| plan.run_of(&hash, &folder, interrupted))?;
        match (done, signal) {
            (_, Some(signal)) => Err(signal),
            (Err(reason @ RunFailure::Unknown(_)), None) => Err(error(py, 1, &reason)),
            (done, None) => Ok(done.err().map(|reason| reason.to_string())),
        }
    }

    /// Does all that is missing, so many at a time.
    fn work(&self, py: Python<'_>, folder: PathBuf, jobs: usize) -> PyResult<()> {
        let plan = Arc::clone(&self.plan);
        let (done, signal) = waited_for(py, move |interrupted| plan.work(&folder, None, jobs, interrupted, &|_| ()))?;
        signal.map_or_else(|| done.map(drop).map_err(|reason| error(py, 1, &reason)), Err)
    }

    /// Writes the table of results; gives the report as JSON and as text.
    fn gather(&self, py: Python<'_>, folder: PathBuf) -> PyResult<(String, String)> {
        let report = py.detach(|| self.plan.gather(&folder)).map_err(|reason| error(py, 1, &reason))?;
        Ok((serde_json::to_string(&report).unwrap_or_default(), report.to_string()))
    }
}
