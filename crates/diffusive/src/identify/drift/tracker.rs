//! The drift of a choice, and its level row by row, as the rows before tell it.
//!
//! ```text
//! d_n = r_n − v_n,    se² = a_nᵀ C a_n
//! ```
//!
//! r is what the inputs leave of the output, v its innovation, a the row's columns but for the
//! offset's, C the covariance of their parameters: what a slow resistance takes too much, the
//! drift lacks. The filter's own error is small beside it, and left out.

use nalgebra::DVector;

use super::{NoiseFilter, RunningFilter};
use crate::identify::design::Role;
use crate::identify::fitted::FittedOutput;
use crate::model::OutputDrift;

/// A drift that was found.
#[derive(Debug, Clone, PartialEq)]
pub struct ChosenDrift {
    /// `None` where several stand in an average.
    pub filter: Option<NoiseFilter>,
    /// Evidence over none, nats; 0 where it was not asked.
    pub evidence: f64,
    /// Its level behind the last row, K, and at what rate that decays, rad/s.
    pub level_k: f64,
    pub rate_rad_s: f64,
}

impl ChosenDrift {
    /// As a model says it. `innovations` is their variance, K².
    pub fn described(&self, innovations: f64, sample_period_s: f64) -> OutputDrift {
        let rate = self.rate_rad_s;
        let kind = self.filter.as_ref().map_or(OutputDrift::AVERAGE, |filter| filter.kind.name());
        OutputDrift {
            kind: kind.to_owned(),
            size: self.filter.as_ref().map_or(0.0, |filter| filter.size(innovations, sample_period_s)),
            correlation_s: (rate > 0.0).then(|| 1.0 / rate),
            last_level_k: self.level_k,
            evidence_nats: self.evidence,
        }
    }

    /// As a decay behind the last row.
    pub fn end(&self) -> (f64, f64) {
        (self.rate_rad_s, self.level_k)
    }
}

/// The drift of one output; it stands at 0 where the model has none.
pub struct DriftTracker<'a> {
    fitted: &'a FittedOutput<'a>,
    filter: Option<RunningFilter>,
    period_s: f64,
    se: f64,
}

impl<'a> DriftTracker<'a> {
    pub fn new(fitted: &'a FittedOutput<'a>, period_s: f64) -> Self {
        Self { fitted, filter: filter_of(fitted, period_s), period_s, se: 0.0 }
    }

    /// Begins anew behind a gap, over which nothing is known of the level.
    pub fn restart(&mut self) {
        self.filter = filter_of(self.fitted, self.period_s);
    }

    /// What was expected of a residual, K.
    pub fn level(&mut self, residual: f64) -> f64 {
        self.filter.as_mut().map_or(0.0, |filter| residual - filter.innovation(residual))
    }

    /// Takes a row's columns for the standard error from here on: it changes as slowly as what it
    /// is unsure of, and need not be known of every row.
    pub fn update_se(&mut self, column: impl Fn(usize) -> f64) {
        if self.filter.is_some() {
            let of = |(column_number, weight): &(usize, f64)| weight * column(*column_number);
            let is_offset = |role: Role| role == Role::Offset;
            let terms = self.fitted.terms.iter();
            let row = terms.map(|term| if is_offset(term.role) { 0.0 } else { term.of.iter().map(of).sum() });
            let row = DVector::from_iterator(self.fitted.terms.len(), row);
            self.se = row.dot(&(self.fitted.covariance * &row)).max(0.0).sqrt();
        }
    }

    /// Standard error of offset and level together, K.
    pub fn se(&self) -> f64 {
        self.se
    }
}

fn filter_of(fitted: &FittedOutput<'_>, period_s: f64) -> Option<RunningFilter> {
    let filter = fitted.drift?.filter.as_ref()?;
    Some(RunningFilter::new(filter, period_s))
}
