//! The sums of all parts, as identification asks for those of a record.

use super::closed::ClosedSums;
use super::designs::{SummedDesigns, columns_of};
use super::plan::GramPlan;
use super::residual_sums::ResidualSums;
use super::summed::SummedRows;
use crate::identify::delay::PathDecision;
use crate::identify::design::RegressionDesign;
use crate::identify::drift::ChosenDrift;
use crate::identify::fitted::FittedOutput;
use crate::identify::options::{Constraints, FitObserver, Progress};
use crate::identify::pass::Passed;
use crate::identify::reading::SumReading;
use crate::identify::record::{RecordError, Survey};
use crate::identify::residual_pass::ResidualPass;
use crate::model::RecordEnd;

/// A record of which sums are at hand, and no rows.
pub struct PartReading<'a> {
    plan: &'a GramPlan,
    summed: SummedDesigns,
    whole: ClosedSums,
}

impl<'a> PartReading<'a> {
    /// `whole`: the sums of all rows.
    pub fn of(plan: &'a GramPlan, whole: SummedRows) -> Result<Self, RecordError> {
        let is_whole = whole.is_closed() && whole.rows == plan.survey.rows;
        plan.survey.refuse_if(!is_whole, "lacks the sums of some of its rows")?;
        let mut whole = whole.closed;
        whole.round();
        Ok(Self { plan, summed: plan.designs()?, whole })
    }

    fn place(&self, design: &RegressionDesign) -> Result<usize, RecordError> {
        let place = self.summed.tried.iter().position(|own| own == design);
        place.ok_or_else(|| {
            self.plan.survey.refuse("was summed for other models than are tried: make plan and parts anew")
        })
    }

    fn sums_of<'s>(&'s self, output: usize, fitted: &'s FittedOutput<'s>, at: usize) -> ResidualSums<'s> {
        ResidualSums::of(&self.summed, &self.whole, at, fitted, output)
    }

    fn end(&self, fitted: &[FittedOutput<'_>], places: &[usize]) -> RecordEnd {
        let (survey, tail) = (&self.plan.survey, &self.whole.late);
        let of = |(output, (fitted, &at))| self.decays(output, fitted, at);
        RecordEnd {
            next_time_s: survey.last_time_s + survey.sample_period_s,
            decays: fitted.iter().zip(places).enumerate().map(of).collect(),
            pending: if tail.is_empty() { vec![Vec::new(); survey.inputs.len()] } else { tail.inputs.clone() },
            pending_class: tail.class.iter().map(|&class| class as usize).collect(),
        }
    }

    /// What an output's model, its drift and the last segment's own start decay from behind the
    /// last row.
    fn decays(&self, output: usize, fitted: &FittedOutput<'_>, at: usize) -> Vec<(f64, f64)> {
        let (number, design) = (self.whole.segments.len() - 1, fitted.design);
        let (segment, columns) = (&self.whole.segments[number], columns_of(design, &self.summed.opened[at]));
        let states: Vec<f64> = columns.iter().map(|&column| segment.states[at][1][column]).collect();
        let mut decays = design.decays_of(&states, &fitted.weights());
        let mut apart = None;
        if number > 0 {
            let (own, offset) = self.sums_of(output, fitted, at).start_of(segment);
            decays.extend(own);
            apart = Some(offset - fitted.weights()[design.decays().end]);
        }
        decays.extend(fitted.drift.map(ChosenDrift::end));
        // The last segment's own offset, over the model's.
        decays.extend(apart.map(|apart| (0.0, apart)));
        decays
    }
}

impl SumReading for PartReading<'_> {
    fn survey(&self) -> &Survey {
        &self.plan.survey
    }

    fn labels(&mut self, _: &mut Progress<'_>) -> Result<Vec<String>, RecordError> {
        Ok(self.plan.classes.clone())
    }

    fn path(&mut self, given: &Constraints) -> Result<PathDecision, RecordError> {
        let is_open = *given != self.plan.options.constraints;
        Ok(if is_open { self.plan.open_path.clone() } else { self.plan.path.clone() })
    }

    fn sums(&mut self, designs: &[RegressionDesign], _: &mut dyn FnMut(u64)) -> Result<Passed, RecordError> {
        let of = |design: &RegressionDesign| Ok(self.whole.folds(self.place(design)?, design));
        let sums: Result<Vec<_>, RecordError> = designs.iter().map(of).collect();
        let (folds, ends) = sums?.into_iter().unzip();
        let (facts, output_shift) = (self.plan.facts.clone(), self.plan.output_shift.clone());
        Ok(Passed { folds, ends, facts, output_shift })
    }

    fn left_by(&mut self, fitted: &[FittedOutput<'_>], _: &mut FitObserver<'_>) -> Result<ResidualPass, RecordError> {
        let places: Result<Vec<usize>, RecordError> = fitted.iter().map(|fitted| self.place(fitted.design)).collect();
        let places = places?;
        let facts = &self.plan.facts.outputs;
        let of = |(output, (fitted, &at))| self.sums_of(output, fitted, at).residuals(&facts[output]);
        let residuals = fitted.iter().zip(&places).enumerate().map(of).collect();
        Ok(ResidualPass { residuals, end: self.end(fitted, &places) })
    }
}
