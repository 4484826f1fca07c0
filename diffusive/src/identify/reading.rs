//! What identification with a symbol asks of a record, whoever has its rows: sums of them, and sums
//! of what models leave.
//!
//! [`RowReading`] reads the record as often as it is asked; sums that were gathered part by part
//! answer the same questions (`parts`). All choices are made on the answers.

use super::delay::{self, PathDecision};
use super::design::RegressionDesign;
use super::fitted::FittedOutput;
use super::folds::FOLDS;
use super::gas_source::GasSource;
use super::labels::labels;
use super::options::{Constraints, FitObserver, Progress};
use super::pass::{Passed, pass};
use super::record::{RecordError, RecordSource, Survey};
use super::residual_pass::ResidualPass;

/// A record of which sums are asked.
pub trait SumReading {
    fn survey(&self) -> &Survey;

    /// The labels of all classes.
    fn labels(&mut self, progress: &mut Progress<'_>) -> Result<Vec<String>, RecordError>;

    /// Dead time and feed-through.
    fn path(&mut self, given: &Constraints) -> Result<PathDecision, RecordError>;

    /// The normal equations of several designs; `tell` hears of the rows that are done.
    fn sums(&mut self, designs: &[RegressionDesign], tell: &mut dyn FnMut(u64)) -> Result<Passed, RecordError>;

    /// What models leave; `seen` hears of every row, where there are rows.
    fn left_by(&mut self, fitted: &[FittedOutput<'_>], seen: &mut FitObserver<'_>)
    -> Result<ResidualPass, RecordError>;
}

/// A record of which all rows are at hand.
pub struct RowReading<'a>(pub &'a mut dyn RecordSource);

impl SumReading for RowReading<'_> {
    fn survey(&self) -> &Survey {
        self.0.survey()
    }

    fn labels(&mut self, progress: &mut Progress<'_>) -> Result<Vec<String>, RecordError> {
        labels(self.0, progress)
    }

    fn path(&mut self, given: &Constraints) -> Result<PathDecision, RecordError> {
        delay::decide(self.0, given)
    }

    fn sums(&mut self, designs: &[RegressionDesign], tell: &mut dyn FnMut(u64)) -> Result<Passed, RecordError> {
        pass(self.0, designs, FOLDS, GasSource::Constant(0.0), u64::MAX, tell)
    }

    fn left_by(
        &mut self,
        fitted: &[FittedOutput<'_>],
        seen: &mut FitObserver<'_>,
    ) -> Result<ResidualPass, RecordError> {
        ResidualPass::of(self.0, GasSource::Constant(0.0), fitted, seen)
    }
}
