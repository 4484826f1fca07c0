//! Residuals of every output's choice: outputs that chose the same design share a reading.

use std::rc::Rc;

use super::choose::Choice;
use super::design::RegressionDesign;
use super::gas_source::GasSource;
use super::normal_equations::in_columns;
use super::options::{FitObserver, Progress};
use super::record::{RecordError, RecordSource};
use super::residuals::{FitRow, FittedOutput, ResidualPass, read_residuals};

/// A reading, and which of those that share it an output was.
#[derive(Clone)]
pub struct OutputResiduals {
    pub place: usize,
    pub pass: Rc<ResidualPass>,
}

/// By output. `seen` hears of every row of every reading.
pub fn residuals_of_all(
    source: &mut dyn RecordSource,
    designs: &[RegressionDesign],
    output_shift: &[f64],
    choices: &[Choice],
    seen: &mut dyn FnMut(&FitRow<'_>),
) -> Result<Vec<OutputResiduals>, RecordError> {
    let mut residuals: Vec<Option<OutputResiduals>> = vec![None; choices.len()];
    for first in 0..choices.len() {
        if residuals[first].is_some() {
            continue;
        }
        let mesh = choices[first].trial.mesh;
        let alike: Vec<usize> = (first..choices.len()).filter(|&other| choices[other].trial.mesh == mesh).collect();
        let fitted: Vec<FittedOutput> = alike
            .iter()
            .map(|&output| FittedOutput {
                output,
                theta: in_columns(&choices[output].terms, &choices[output].solution.theta, designs[mesh].width()),
                shift: output_shift[output],
            })
            .collect();
        let pass = Rc::new(read_residuals(source, &designs[mesh], GasSource::Constant(0.0), &fitted, seen)?);
        for (place, &output) in alike.iter().enumerate() {
            residuals[output] = Some(OutputResiduals { place, pass: Rc::clone(&pass) });
        }
    }
    Ok(residuals.into_iter().flatten().collect())
}

/// An observer that reports progress as well.
pub fn observed<'a>(
    progress: &'a mut Progress<'_>,
    rows: u64,
    observer: &'a mut FitObserver<'_>,
) -> impl FnMut(&FitRow<'_>) + 'a {
    move |seen| {
        progress_now_and_then(progress, "residuals", seen.row, rows);
        observer(seen);
    }
}

/// Reports every so many rows, so that reporting costs nothing.
pub fn progress_now_and_then(progress: &mut Progress<'_>, what: &'static str, row: u64, rows: u64) {
    if row.is_multiple_of(65_536) {
        progress(what, row, rows);
    }
}
