//! The filter whose output is white where a drift is beside white noise.

use dr_core::model::mesh;

use super::DriftKind;

/// (1 − φL)/(1 − ϑL).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Section {
    /// ξ, of ϑ = e^(−ξ Ts), rad/s.
    pub pole_rad_s: f64,
    /// ζ, of φ = e^(−ζ Ts), rad/s; 0 for a walk.
    pub zero_rad_s: f64,
}

impl Section {
    /// 1 − ϑ
    fn gain(self, sample_period_s: f64) -> f64 {
        mesh::gain(self.pole_rad_s, sample_period_s)
    }

    /// What of the mean E of the past is expected now: v = y − c E, c = (φ − ϑ)/(1 − ϑ).
    pub fn weight(self, sample_period_s: f64) -> f64 {
        1.0 - mesh::gain(self.zero_rad_s, sample_period_s) / self.gain(sample_period_s)
    }
}

/// A kind of drift with its size, as the filter that makes it white.
#[derive(Debug, Clone, PartialEq)]
pub struct NoiseFilter {
    pub kind: DriftKind,
    /// One or two.
    pub sections: Vec<Section>,
}

impl NoiseFilter {
    /// Of a random walk whose level is found over 1/rate.
    pub fn walk(rate_rad_s: f64) -> Self {
        let section = Section { pole_rad_s: rate_rad_s, zero_rad_s: 0.0 };
        Self { kind: DriftKind::RandomWalk, sections: vec![section] }
    }

    /// The rate at which a last level decays, rad/s; 0 if it is held.
    pub fn rate_rad_s(&self) -> f64 {
        match self.kind {
            DriftKind::RandomWalk | DriftKind::IntegratedWalk => 0.0,
            DriftKind::Correlated => {
                self.sections.iter().map(|section| section.zero_rad_s).fold(f64::INFINITY, f64::min)
            }
        }
    }

    /// The rate over which its level is found, rad/s: the product of its poles over that of zeros
    /// that are none of the drift's.
    pub fn level_rad_s(&self) -> f64 {
        let poles: f64 = self.sections.iter().map(|section| section.pole_rad_s).product();
        match (self.kind, &self.sections[..]) {
            (DriftKind::IntegratedWalk, _) => poles.sqrt(),
            (_, [_, second]) => poles / second.zero_rad_s,
            _ => poles,
        }
    }

    /// What of a level is left, on the mean over a time to come.
    pub fn left_within(&self, time_s: f64) -> f64 {
        let decays = self.rate_rad_s() * time_s;
        if decays > 0.0 { -libm::expm1(-decays) / decays } else { 1.0 }
    }

    /// The increment's standard deviation of a walk in K/√s, or the standard deviation of a level
    /// that returns in K, for innovations of a variance in K². The power of the drift at low
    /// frequencies is that of white noise, times (level rate/ω)²; v of it stands in the
    /// innovations.
    pub fn size(&self, innovation_variance: f64, sample_period_s: f64) -> f64 {
        let level = self.level_rad_s();
        let increments = innovation_variance.sqrt() * level * sample_period_s.sqrt();
        match self.kind {
            DriftKind::RandomWalk => increments,
            DriftKind::IntegratedWalk => increments * level,
            DriftKind::Correlated => increments / (2.0 * self.rate_rad_s()).sqrt(),
        }
    }
}

/// A filter that goes over the residuals of a record, row by row.
pub struct RunningFilter {
    /// c, 1 − ϑ and E of every section.
    sections: Vec<(f64, f64, f64)>,
}

impl RunningFilter {
    pub fn new(filter: &NoiseFilter, sample_period_s: f64) -> Self {
        let of = |section: &Section| (section.weight(sample_period_s), section.gain(sample_period_s), 0.0);
        Self { sections: filter.sections.iter().map(of).collect() }
    }

    /// The innovation of a residual; what it lacks of it is the drift that was expected.
    pub fn innovation(&mut self, residual: f64) -> f64 {
        self.sections.iter_mut().fold(residual, |value, (weight, gain, mean)| {
            let new = value - *weight * *mean;
            *mean += *gain * (value - *mean);
            new
        })
    }
}
