//! The sums of all parts, as identification asks for those of a record.

use super::design_sums;
use super::left::LeftSums;
use super::plan::GramPlan;
use super::summed::{SummedBatches, SummedDesigns, SummedRows};
use crate::identify::delay::PathDecision;
use crate::identify::design::RegressionDesign;
use crate::identify::drift::{ChosenDrift, PoleColumns};
use crate::identify::fitted::FittedOutput;
use crate::identify::folds::FOLDS;
use crate::identify::options::{Constraints, FitObserver, Progress};
use crate::identify::pass::Passed;
use crate::identify::reading::SumReading;
use crate::identify::record::{RecordError, Survey};
use crate::identify::residual_pass::ResidualPass;
use crate::identify::residuals::Residuals;
use crate::model::RecordEnd;

/// A record of which sums are at hand, and no rows.
pub struct PartReading<'a> {
    plan: &'a GramPlan,
    summed: SummedDesigns,
    whole: SummedBatches,
}

impl<'a> PartReading<'a> {
    /// `whole`: the sums of all rows.
    pub fn of(plan: &'a GramPlan, whole: SummedRows) -> Result<Self, RecordError> {
        let summed = plan.designs()?;
        let whole = summed.whole(whole).ok_or_else(|| plan.survey.refuse("has no sums of its first rows"))?;
        Ok(Self { plan, summed, whole })
    }

    fn place(&self, design: &RegressionDesign) -> Result<usize, RecordError> {
        let place = self.summed.designs.iter().position(|own| own == design);
        place.ok_or_else(|| {
            self.plan.survey.refuse("was summed for other models than are tried: make plan and parts anew")
        })
    }

    fn residuals(&self, output: usize, fitted: &FittedOutput<'_>, at: usize) -> Residuals {
        let (design, opened) = (fitted.design, &self.summed.opened[at]);
        let columns = design_sums::columns_of(design, opened);
        let explained = fitted.weights();
        let y = design.width() - design.outputs + output;
        let own = explained.iter().enumerate().filter(|(_, weight)| **weight != 0.0);
        let mut unexplained: Vec<(usize, f64)> = own.map(|(column, weight)| (column, -weight)).collect();
        unexplained.push((y, 1.0));
        let filter = fitted.drift.and_then(|drift| drift.filter.as_ref());
        let left = match filter {
            None => unexplained.clone(),
            Some(filter) => PoleColumns::of(design, fitted.sample_period_s).innovations(&unexplained, filter),
        };
        let in_opened = |of: &[(usize, f64)]| {
            let mut weights = vec![0.0; opened.width()];
            of.iter().for_each(|&(column, weight)| weights[columns[column]] += weight);
            weights
        };
        let (unexplained, left) = (in_opened(&unexplained), in_opened(&left));
        let sums = &self.whole.designs[at];
        let gram = sums.total(opened.width());
        let last = &self.whole.states[at][..];
        let states = [sums.first.as_deref().unwrap_or(last), last];
        let of = LeftSums::of(opened, self.summed.sample_period_s, &gram, &self.whole.lags, states);
        let (offset, y) = (opened.decays().end, columns[y]);
        let facts = &self.plan.facts.outputs[output];
        // From its first value, as residuals count it; the sums count from another.
        let (n, apart) = (gram.rows as f64, self.summed.output_shift[output] - facts.from);
        let (sum, squares) = (gram.sums[(offset, y)], gram.sums[(y, y)]);
        let moved = [sum + n * apart, squares + 2.0 * apart * sum + n * apart * apart];
        let moved = if facts.least == facts.greatest { [0.0; 2] } else { moved };
        let squares = [of.squares(&left), of.squares(&unexplained)];
        let greatest = of.greatest_of_first(&left);
        Residuals::of_sums(gram.rows, squares, of.products(&left), greatest, facts.from, moved)
    }

    fn end(&self, fitted: &[FittedOutput<'_>], places: &[usize]) -> RecordEnd {
        let decays = |(fitted, &at): (&FittedOutput<'_>, &usize)| {
            let columns = design_sums::columns_of(fitted.design, &self.summed.opened[at]);
            let states: Vec<f64> = columns.iter().map(|&column| self.whole.states[at][column]).collect();
            let mut decays = fitted.design.decays_of(&states, &fitted.weights());
            decays.extend(fitted.drift.map(ChosenDrift::end));
            decays
        };
        let survey = &self.plan.survey;
        let tail = &self.whole.late;
        RecordEnd {
            next_time_s: survey.last_time_s + survey.sample_period_s,
            decays: fitted.iter().zip(places).map(decays).collect(),
            pending: if tail.is_empty() { vec![Vec::new(); survey.inputs.len()] } else { tail.inputs.clone() },
            pending_class: tail.class.iter().map(|&class| class as usize).collect(),
        }
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
        let of = |design: &RegressionDesign| {
            let at = self.place(design)?;
            let opened = &self.summed.opened[at];
            let columns = design_sums::columns_of(design, opened);
            Ok(self.whole.designs[at].selected(&columns, FOLDS, &self.whole.states[at]))
        };
        let sums: Result<Vec<_>, RecordError> = designs.iter().map(of).collect();
        let (folds, ends) = sums?.into_iter().unzip();
        let (facts, output_shift) = (self.plan.facts.clone(), self.plan.output_shift.clone());
        Ok(Passed { folds, ends, facts, output_shift })
    }

    fn left_by(&mut self, fitted: &[FittedOutput<'_>], _: &mut FitObserver<'_>) -> Result<ResidualPass, RecordError> {
        let places: Result<Vec<usize>, RecordError> = fitted.iter().map(|fitted| self.place(fitted.design)).collect();
        let places = places?;
        let of = |(output, (fitted, &at))| self.residuals(output, fitted, at);
        let residuals = fitted.iter().zip(&places).enumerate().map(of).collect();
        Ok(ResidualPass { residuals, end: self.end(fitted, &places) })
    }
}
