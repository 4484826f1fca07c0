//! Slow errors of a recording, as corrections over its time and as what a head may carry of them;
//! reasons why none can be found.
//!
//! The covariance of slow errors adds to that of a wind:
//!
//! C ← C + K D P Dᵀ Kᵀ,  K = (Jᵀ W J)⁻¹ Jᵀ W,  D = ∂G'/∂(S, γ): the wind that follows by least
//! squares from conductances that are wrong by them.

use std::fmt;

use dr_core::wind::slow_errors::SurfaceCorrection;
use dr_core::wind::sphere::SECTORS;
use dr_core::wind::{Anemometer, QualityFlags, WindTick};
use nalgebra::{Matrix3, SMatrix, Vector3};
use serde::Serialize;
use wire::WindSample;

use super::super::gas_uncertainty::add_uncertainty;
use super::evidence::corrections;
use super::halves::LEAST_SWING;
use super::smoother::{ERRORS, OverheatEquation, SlowEquation, SlowErrorsAt, SlowJump, SlowPrior, SlowSeries, doubt};

/// Mean square from which on something has to be explained.
pub(super) const CONTRADICTED: f64 = 2.0;
/// χ² of differences of overheat from which on they show heat.
const SEEN: f64 = 4.0;

/// Alternation of a recording, and how heat explains it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OverheatFinding {
    /// The higher and the lower overheat, K.
    pub overheat_k: [f64; 2],
    /// Number of halves.
    pub halves: usize,
    /// χ² of the differences over their degrees of freedom, without and with heat.
    pub chi_square: [f64; 2],
    #[serde(skip)]
    pub(super) equations: Vec<OverheatEquation>,
}

/// Slow errors over a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldCorrection {
    /// Kind that was sought.
    pub kind: SlowErrorKind,
    /// Size and quickness that were found.
    pub prior: SlowPrior,
    /// Where errors jump.
    pub jumps: Vec<SlowJump>,
    /// Slots with an equation.
    pub count: usize,
    /// Mean square of what the equations leave, in their own variances, without and with errors.
    pub chi_square: [f64; 2],
    /// Finding of halves of alternating overheat, if they do.
    pub overheats: Option<OverheatFinding>,
    pub(super) begin_s: f64,
    pub(super) slot_s: f64,
    pub(super) equations: Vec<Option<SlowEquation>>,
    pub(super) found: Vec<SlowErrorsAt>,
}

impl FieldCorrection {
    /// Tells whether most of the contradictions are gone with these errors.
    pub fn explains(&self) -> bool {
        let is_less = |[before, after]: [f64; 2], least: f64| before > least && after < 0.5 * before;
        match &self.overheats {
            Some(of) if self.kind == SlowErrorKind::Offsets => is_less(of.chi_square, SEEN),
            _ => is_less(self.chi_square, CONTRADICTED),
        }
    }

    /// Errors at the slots that have an equation, with their times, s.
    pub fn known(&self) -> impl Iterator<Item = (f64, &SlowErrorsAt)> {
        let slots = self.equations.iter().zip(&self.found).enumerate().filter(|(_, (equation, _))| equation.is_some());
        slots.map(|(place, (_, at))| (self.begin_s + (place as f64 + 0.5) * self.slot_s, at))
    }

    /// Errors at a time.
    pub fn at(&self, time_s: f64) -> Option<&SlowErrorsAt> {
        let place = ((time_s - self.begin_s) / self.slot_s).max(0.0) as usize;
        self.found.get(place).or_else(|| self.found.last())
    }

    /// Corrections at a time, on top of those with which the recording was gone through; these
    /// alone where the errors do not explain what contradicts. The uncertainty of what was found
    /// is not in them: [`Self::widen`] adds it.
    pub fn corrections(
        &self,
        time_s: f64,
        former: Option<&[SurfaceCorrection; SECTORS]>,
    ) -> [SurfaceCorrection; SECTORS] {
        let former = former.copied().unwrap_or_default();
        let Some(at) = self.at(time_s).filter(|_| self.explains()) else { return former };
        let found = corrections(at);
        core::array::from_fn(|i| found[i].on_top_of(&self.kind.certain(former[i])))
    }
}

impl FieldCorrection {
    /// Corrections that a head may carry, on top of those that it carries: means over the winds
    /// that said something, with what the errors move by in their uncertainties; none where the
    /// errors do not explain what contradicts.
    pub fn constant(&self, former: Option<&[SurfaceCorrection; SECTORS]>) -> Option<[SurfaceCorrection; SECTORS]> {
        let former = former.copied().unwrap_or_default();
        let count = self.known().count().max(1) as f64;
        let mean = |of: &dyn Fn(&SlowErrorsAt) -> f64| self.known().map(|(_, at)| of(at)).sum::<f64>() / count;
        let number = |error: usize| {
            let value = mean(&|at| at.errors[error]);
            let square = mean(&|at| at.covariance[(error, error)].max(0.0) + (at.errors[error] - value).powi(2));
            [value, square.sqrt()]
        };
        let correction = |i: usize| {
            let [offset_w, offset_u_w] = number(i).map(|mw| (1e-3 * mw) as f32);
            let [gain, gain_u] = number(SECTORS + i).map(|percent| (1e-2 * percent) as f32);
            SurfaceCorrection { offset_w, gain, offset_u_w, gain_u }.on_top_of(&former[i])
        };
        self.explains().then(|| core::array::from_fn(correction))
    }
}

/// Kind of error.
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

impl SlowErrorKind {
    /// Word of an option.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Offsets => "offsets",
            Self::Gains => "gains",
            Self::Both => "both",
        }
    }

    /// The kind that may be wrong in its place.
    pub const fn other(self) -> Option<Self> {
        match self {
            Self::Offsets => Some(Self::Gains),
            Self::Gains => Some(Self::Offsets),
            Self::Both => None,
        }
    }

    /// A correction without the uncertainty of what is sought anew.
    pub(super) const fn certain(self, of: SurfaceCorrection) -> SurfaceCorrection {
        SurfaceCorrection {
            offset_u_w: if matches!(self, Self::Gains) { of.offset_u_w } else { 0.0 },
            gain_u: if matches!(self, Self::Offsets) { of.gain_u } else { 0.0 },
            ..of
        }
    }
}

/// Twice the logarithm of how much likelier a kind must be to be the one.
const AS_LIKELY: f64 = 20.0;

impl FieldCorrection {
    /// The kind that makes the winds that both explain likelier, and the other one if it is hardly
    /// less likely; a jump has its price.
    pub fn likelier<'a>(a: &'a Self, b: &'a Self) -> (&'a Self, Option<&'a Self>) {
        let common = |of: &Self, other: &Self| -> f64 {
            let pairs = of.equations.iter().zip(&other.equations);
            let slots: Vec<_> = pairs.map(|(own, other)| own.filter(|_| other.is_some())).collect();
            let overheats = of.overheats.as_ref().or(other.overheats.as_ref()).map_or(&[][..], |of| &of.equations);
            let series = SlowSeries { slots: &slots, slot_s: of.slot_s, jumps: &of.jumps, overheats };
            doubt(&of.prior, &series) + JUMP_EXPLAINS * of.jumps.len() as f64
        };
        let difference = common(b, a) - common(a, b);
        let (better, other) = if difference < 0.0 { (b, a) } else { (a, b) };
        (better, (difference.abs() < AS_LIKELY).then_some(other))
    }
}

/// Share of its standard deviation before anything is known beyond which an error is left open.
const OPEN: f64 = 0.5;
/// Cosine to what all surfaces share from which on a combination is that.
const COMMON: f64 = 0.9;

/// One combination.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpenError {
    /// All surfaces have it alike.
    pub is_common: bool,
    /// It is of gains, else of heat.
    pub is_gain: bool,
    /// mW or % of each surface.
    pub deviation: f64,
}

/// Errors of offsets and of gains, from the slots that have an equation.
pub fn open_errors<'a>(prior: &SlowPrior, known: impl Iterator<Item = &'a SlowErrorsAt>) -> Vec<OpenError> {
    let mut sum = SMatrix::<f64, ERRORS, ERRORS>::zeros();
    let mut count = 0.0;
    for at in known {
        sum += at.covariance;
        count += 1.0;
    }
    let mut open = Vec::new();
    for (is_gain, first, size) in [(false, 0, prior.offset_mw), (true, SECTORS, prior.gain_percent)] {
        let eigen = (sum.fixed_view::<SECTORS, SECTORS>(first, first) / f64::max(count, 1.0)).symmetric_eigen();
        for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
            let deviation = value.max(0.0).sqrt();
            if size > 0.0 && deviation > OPEN * size {
                let alike = (SECTORS as f64).sqrt();
                open.push(OpenError {
                    is_common: vector.sum().abs() > COMMON * alike,
                    is_gain,
                    deviation: deviation / alike,
                });
            }
        }
    }
    open
}

impl fmt::Display for OpenError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (what, unit) = if self.is_gain { ("gains", "%") } else { ("heat", "mW") };
        let of = if self.is_common { "of all surfaces alike" } else { "other than alike" };
        write!(f, "{what} {of} (± {:.2} {unit})", self.deviation)
    }
}

/// Jumps that take less than this out of the squares of the residuals are not taken.
pub(super) const JUMP_EXPLAINS: f64 = 30.0;
/// Winds that differ: with fewer any kind of error explains what contradicts.
pub(super) const LEAST_WINDS: usize = 16;

/// Why slow errors cannot be found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum SlowErrorsUnknown {
    /// The head has as many surfaces as unknowns, or more than one to spare, or is a card.
    #[error(
        "slow errors are found by the number that four surfaces round a body have to spare: this head has another form"
    )]
    NothingToSpare,
    /// Too few winds say anything.
    #[error(
        "slow errors take {LEAST_WINDS} winds that differ by 17° or 30 % of speed, and the recording has fewer: record more of them"
    )]
    FewWinds,
    /// The overheat changes, but not in halves that count.
    #[error(
        "the overheat changes, but fewer than six halves of it count, and there are too few winds without them: let it alternate between overheats at least {:.0} % apart, for longer at each than the head takes to cool (its estimates are `saturated` meanwhile), and for a multiple of that",
        100.0 * LEAST_SWING
    )]
    NoHalves,
    /// The winds do not say which surface is wrong.
    #[error(
        "the winds of the recording do not say which surface is wrong, so nothing can be corrected: record winds of more directions and speeds, or seek offsets or gains alone in place of both"
    )]
    WindsAlike,
    /// No estimate has a wind with a direction.
    #[error(
        "slow errors show in winds that have a direction, and the recording has none: record winds of many directions"
    )]
    NoWind,
}

impl FieldCorrection {
    /// Adds the uncertainty of the correction to an estimate that was made with it.
    pub fn widen<const N: usize>(
        &self,
        time_s: f64,
        anemometer: &Anemometer<N>,
        estimate: &WindTick,
        sample: &mut WindSample,
    ) {
        let speed_m_s = f64::from(sample.speed_m_s);
        if sample.quality_flags.has(QualityFlags::FAILED) || speed_m_s.is_nan() || speed_m_s <= 0.0 {
            return;
        }
        let errors = self.at(time_s).filter(|_| self.explains());
        let Some(added) = errors.and_then(|at| by_errors(&at.covariance, anemometer, estimate)) else { return };
        let along = Vector3::from(sample.wind_m_s.map(f64::from)) / speed_m_s;
        let along_m2_s2 = along.dot(&(added * along)).max(0.0);
        let across_rad2 = 0.5 * (added.trace() - along_m2_s2).max(0.0) / speed_m_s.powi(2);
        let elements = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(|at| added[at]);
        add_uncertainty(sample, elements, [along_m2_s2, across_rad2].map(f64::sqrt));
    }
}

/// K D P Dᵀ Kᵀ, m²/s².
pub(super) fn by_errors<const N: usize>(
    errors: &SMatrix<f64, ERRORS, ERRORS>,
    anemometer: &Anemometer<N>,
    estimate: &WindTick,
) -> Option<Matrix3<f64>> {
    let warm = estimate.overheat_k.iter().filter(|of| **of > 0.0);
    let overheat_k = warm.clone().sum::<f32>() / warm.count().max(1) as f32;
    let gas = anemometer.gas_at(estimate.gas_c, overheat_k)?;
    let (free, rise_speed_m_s) = anemometer.free_stream(estimate.gas_c, overheat_k);
    let wind_m_s = estimate.wind.wind_m_s;
    let expected = anemometer.vector()?.conductances(&gas, free.met(wind_m_s, rise_speed_m_s));
    let gains: Vec<f64> = anemometer.gains().map(f64::from).collect();
    let (mut normal, mut pull) = (Matrix3::zeros(), SMatrix::<f64, 3, SECTORS>::zeros());
    let mut change = SMatrix::<f64, SECTORS, ERRORS>::zeros();
    for i in 0..SECTORS {
        let variance = f64::from(estimate.variance_w2_k2[i]);
        // One that was left out moves no wind.
        if variance.is_nan() || variance <= 0.0 {
            continue;
        }
        let gradient = free.gradient(expected[i].gradient_w_s_k_m, wind_m_s, rise_speed_m_s);
        let gradient = Vector3::from(gradient.map(f64::from));
        normal += gradient * gradient.transpose() / variance;
        pull.set_column(i, &(gradient / variance));
        change[(i, i)] = 1e-3 * gains.get(i)? / f64::from(estimate.overheat_k[i]);
        change[(i, SECTORS + i)] = 1e-2 * f64::from(estimate.conductance_w_k[i]);
    }
    let pull = normal.try_inverse()? * pull * change;
    Some(pull * errors * pull.transpose())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sentence_on_halves_states_the_swing_that_counts() {
        let sentence = SlowErrorsUnknown::NoHalves.to_string();
        assert!(sentence.contains(&format!("at least {:.0} % apart", 100.0 * LEAST_SWING)), "{sentence}");
    }
}
