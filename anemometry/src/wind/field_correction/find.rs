//! The slow errors of a recording: their size and quickness by likelihood, then they themselves.

use dr_core::wind::Anemometer;
use dr_core::wind::slow_errors::SurfaceCorrection;
use dr_core::wind::sphere::SECTORS;
use serde::Serialize;

use super::equations::{corrections, equations};
use super::evidence::SlowEvidence;
use super::smoother::{SlowEquation, SlowErrorsAt, SlowPrior, doubt, smooth};

/// Rounds of linear equations about the winds of the round before.
const ROUNDS: usize = 6;
/// Standard deviations beyond which a residual counts as less.
const FAR: f64 = 3.0;

/// What may be wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SlowErrorKind {
    /// Heat: sun, sky, leaks, drifts of R₀.
    Offsets,
    /// Gains: dust, coatings, contacts.
    Gains,
    /// Both.
    Both,
}

/// Slow errors over a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldCorrection {
    /// What was sought.
    pub kind: SlowErrorKind,
    /// Size and quickness that were found.
    pub prior: SlowPrior,
    /// Slots with an equation.
    pub count: usize,
    /// Mean square of what the equations leave, in their own variances, without and with errors.
    pub chi_square: [f64; 2],
    begin_s: f64,
    slot_s: f64,
    found: Vec<SlowErrorsAt>,
}

const OFFSETS_MW: [f64; 9] = [0.0, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0];
const GAINS_PERCENT: [f64; 8] = [0.0, 0.1, 0.3, 1.0, 2.0, 4.0, 8.0, 16.0];
const TIMES_S: [f64; 11] = [100.0, 200.0, 400.0, 800.0, 1600.0, 3200.0, 6400.0, 12800.0, 25600.0, 51200.0, 102400.0];
const NOISES: [f64; 9] = [0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0];

impl FieldCorrection {
    /// Finds them; none without a head that has a number to spare, or without equations.
    pub fn find<const N: usize>(
        evidence: &SlowEvidence,
        anemometer: &Anemometer<N>,
        kind: SlowErrorKind,
        bandwidth_hz: f64,
    ) -> Option<Self> {
        if !SlowEvidence::is_of(anemometer) {
            return None;
        }
        let slot_s = evidence.slot_s();
        let mut prior = SlowPrior {
            offset_mw: [if kind == SlowErrorKind::Gains { 0.0 } else { 1.0 }; SECTORS],
            time_s: 800.0,
            gain_percent: [if kind == SlowErrorKind::Offsets { 0.0 } else { 1.0 }; SECTORS],
            noise: 1.0,
        };
        let mut found: Vec<SlowErrorsAt> = Vec::new();
        let mut own = Vec::new();
        for _ in 0..ROUNDS {
            own = equations(evidence, anemometer, &found, bandwidth_hz);
            let robust = doubted(&own, &found, prior.noise);
            likeliest(&mut prior, &robust, slot_s, kind);
            found = smooth(&prior, &robust, slot_s);
        }
        let count = own.iter().flatten().count();
        let square = |of: &SlowEquation, errors: Option<&SlowErrorsAt>| {
            errors.map_or(of.value, |at| of.left(&at.errors)).powi(2) / of.own_variance()
        };
        let mean = |with: bool| {
            let each = own.iter().zip(&found).filter_map(|(of, at)| Some(square(of.as_ref()?, with.then_some(at))));
            each.sum::<f64>() / count.max(1) as f64
        };
        let chi_square = [mean(false), mean(true)];
        (count > 0).then(|| Self { kind, prior, count, chi_square, begin_s: evidence.begin_s(), slot_s, found })
    }

    /// Errors at a time.
    pub fn at(&self, time_s: f64) -> Option<&SlowErrorsAt> {
        let place = ((time_s - self.begin_s) / self.slot_s).max(0.0) as usize;
        self.found.get(place).or_else(|| self.found.last())
    }

    /// Corrections at a time.
    pub fn corrections(&self, time_s: f64) -> [SurfaceCorrection; SECTORS] {
        self.at(time_s).map_or([SurfaceCorrection::default(); SECTORS], corrections)
    }
}

/// The equations with those that contradict the errors widened.
fn doubted(own: &[Option<SlowEquation>], found: &[SlowErrorsAt], noise: f64) -> Vec<Option<SlowEquation>> {
    let widened = |(place, equation): (usize, &Option<SlowEquation>)| {
        let mut equation = (*equation)?;
        if let Some(at) = found.get(place) {
            let off = equation.left(&at.errors).powi(2) / (noise * equation.own_variance());
            equation.variance *= (off / FAR.powi(2)).max(1.0);
        }
        Some(equation)
    };
    own.iter().enumerate().map(widened).collect()
}

/// Takes each number of the prior that makes the equations likeliest, in turn.
fn likeliest(prior: &mut SlowPrior, slots: &[Option<SlowEquation>], slot_s: f64, kind: SlowErrorKind) {
    let best = |prior: &mut SlowPrior, of: &[f64], set: &dyn Fn(&mut SlowPrior, f64)| {
        let with = |value: f64| {
            let mut other = *prior;
            set(&mut other, value);
            other
        };
        let least = of.iter().map(|&value| (with(value), doubt(&with(value), slots, slot_s)));
        if let Some((other, _)) = least.min_by(|a, b| a.1.total_cmp(&b.1)) {
            *prior = other;
        }
    };
    for _ in 0..2 {
        if kind != SlowErrorKind::Gains {
            best(prior, &OFFSETS_MW, &|of, mw| of.offset_mw = [mw; SECTORS]);
            best(prior, &TIMES_S, &|of, time_s| of.time_s = time_s);
        }
        if kind != SlowErrorKind::Offsets {
            best(prior, &GAINS_PERCENT, &|of, percent| of.gain_percent = [percent; SECTORS]);
        }
        best(prior, &NOISES, &|of, noise| of.noise = noise);
    }
}
