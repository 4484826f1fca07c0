//! The drift of a choice, and how a model reports it.

use super::filter::NoiseFilter;
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
