//! The slow errors of a recording: their size and quickness by likelihood, then they themselves.

use dr_core::wind::Anemometer;
use dr_core::wind::slow_errors::SurfaceCorrection;
use dr_core::wind::sphere::SECTORS;
use serde::Serialize;

use super::equations::{corrections, distinct, equations};
use super::evidence::SlowEvidence;
use super::halves::OverheatHalves;
use super::open::{OpenError, open_errors};
use super::overheats::{missed_mw, overheat_chi_square, overheat_equations, widen_by_missed};
use super::smoother::{OverheatEquation, SlowEquation, SlowErrorsAt, SlowJump, SlowPrior, SlowSeries, doubt, smooth};

/// Rounds of linear equations about the winds of the round before.
const ROUNDS: usize = 8;
/// Jumps that take less than this out of the squares of the residuals are none, and most of them.
const JUMP_EXPLAINS: f64 = 30.0;
const MOST_JUMPS: usize = 12;
/// Variance of an equation up to which its wind was steady, and how many such winds it takes to
/// find what all surfaces share: means over gusts contradict a little, and in the same way as that.
const STEADY: f64 = 3.0;
const LEAST_STEADY: f64 = 20.0;
/// Mean square from which on something has to be explained.
const CONTRADICTED: f64 = 2.0;
/// χ² of differences of overheat from which on they show heat.
const SEEN: f64 = 4.0;
/// Winds that differ: with fewer any kind of error explains what contradicts.
const LEAST_WINDS: usize = 16;
/// Twice the logarithm of how much likelier a kind must be to be the one.
const AS_LIKELY: f64 = 20.0;
/// Uncertainty over the greatest error from which on it is not known which surface is wrong.
const HIDDEN: f64 = 0.25;
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

impl SlowErrorKind {
    /// As an option has it.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Offsets => "offsets",
            Self::Gains => "gains",
            Self::Both => "both",
        }
    }

    /// A correction without the uncertainty of what is sought anew.
    const fn certain(self, of: SurfaceCorrection) -> SurfaceCorrection {
        SurfaceCorrection {
            offset_u_w: if matches!(self, Self::Gains) { of.offset_u_w } else { 0.0 },
            gain_u: if matches!(self, Self::Offsets) { of.gain_u } else { 0.0 },
            ..of
        }
    }
}

/// How a recording alternates, and how heat explains it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OverheatFinding {
    /// The higher and the lower overheat, K.
    pub overheat_k: [f64; 2],
    /// How many halves.
    pub halves: usize,
    /// χ² of the differences over their degrees of freedom, without and with heat.
    pub chi_square: [f64; 2],
    #[serde(skip)]
    equations: Vec<OverheatEquation>,
}

/// Slow errors over a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldCorrection {
    /// What was sought.
    pub kind: SlowErrorKind,
    /// Size and quickness that were found.
    pub prior: SlowPrior,
    /// Where errors jump.
    pub jumps: Vec<SlowJump>,
    /// Slots with an equation.
    pub count: usize,
    /// Mean square of what the equations leave, in their own variances, without and with errors.
    pub chi_square: [f64; 2],
    /// What halves of alternating overheat say, if they do.
    pub overheats: Option<OverheatFinding>,
    begin_s: f64,
    slot_s: f64,
    equations: Vec<Option<SlowEquation>>,
    found: Vec<SlowErrorsAt>,
}

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
        "slow errors take {least} winds that differ by 17° or 30 % of speed, and the recording has fewer: record more of them"
    )]
    FewWinds {
        /// So many it takes.
        least: usize,
    },
    /// The overheat changes, but not in halves that count.
    #[error(
        "the overheat changes, but fewer than six halves of it count, and there are too few winds without them: let it alternate between overheats at least 15 % apart, for longer at each than the head takes to cool (its estimates are `saturated` meanwhile), and for a multiple of that"
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

const OFFSETS_MW: [f64; 9] = [0.0, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0];
const GAINS_PERCENT: [f64; 8] = [0.0, 0.1, 0.3, 1.0, 2.0, 4.0, 8.0, 16.0];
const WALKS: [f64; 6] = [0.0, 0.01, 0.03, 0.1, 0.2, 0.4];
const TIMES_S: [f64; 11] = [100.0, 200.0, 400.0, 800.0, 1600.0, 3200.0, 6400.0, 12800.0, 25600.0, 51200.0, 102400.0];
const NOISES: [f64; 7] = [0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0];

impl FieldCorrection {
    /// Finds them.
    ///
    /// # Errors
    /// If the head has no number to spare, or no slot an equation.
    pub fn find<const N: usize>(
        evidence: &SlowEvidence,
        anemometer: &Anemometer<N>,
        kind: SlowErrorKind,
        bandwidth_hz: f64,
    ) -> Result<Self, SlowErrorsUnknown> {
        if !SlowEvidence::is_of(anemometer) {
            return Err(SlowErrorsUnknown::NothingToSpare);
        }
        let slot_s = evidence.slot_s();
        let mut prior = SlowPrior {
            offset_mw: if kind == SlowErrorKind::Gains { 0.0 } else { 1.0 },
            time_s: 800.0,
            gain_percent: if kind == SlowErrorKind::Offsets { 0.0 } else { 1.0 },
            gain_walk: 0.0,
            is_common_sought: true,
            noise: 1.0,
        };
        let mut found: Vec<SlowErrorsAt> = Vec::new();
        let mut own = Vec::new();
        let mut jumps: Vec<SlowJump> = Vec::new();
        // Gains do not show in differences of overheat.
        let halves = OverheatHalves::of(evidence).filter(|_| kind != SlowErrorKind::Gains);
        let mut overheats = Vec::new();
        // Means over gusts contradict a little, in the same way at both overheats: where these are
        // enough, nothing else is used.
        let tells = |overheats: &[OverheatEquation]| !overheats.is_empty() && kind == SlowErrorKind::Offsets;
        for _ in 0..ROUNDS {
            own = equations(evidence, anemometer, &found, bandwidth_hz);
            if let Some(halves) = &halves {
                let at = |slot: usize| found.get(slot).map_or_else(Default::default, corrections);
                overheats = overheat_equations(halves, anemometer, at);
            }
            let steady = own.iter().flatten().filter(|of| of.variance < STEADY);
            prior.is_common_sought =
                steady.map(|of| 1.0 - of.correlation.powi(2)).sum::<f64>() >= LEAST_STEADY || !overheats.is_empty();
            let mut slots = doubted(&own, &found, prior.noise);
            if tells(&overheats) {
                slots.fill(None);
            }
            likeliest(&mut prior, &SlowSeries { slots: &slots, slot_s, jumps: &jumps, overheats: &overheats }, kind);
            loop {
                let jump;
                (found, jump) =
                    smooth(&prior, &SlowSeries { slots: &slots, slot_s, jumps: &jumps, overheats: &overheats });
                match jump {
                    Some((jump, explains)) if explains > JUMP_EXPLAINS && jumps.len() < MOST_JUMPS => {
                        jumps.push(jump);
                        likeliest(
                            &mut prior,
                            &SlowSeries { slots: &slots, slot_s, jumps: &jumps, overheats: &overheats },
                            kind,
                        );
                    }
                    _ => break,
                }
            }
        }
        let count = own.iter().flatten().count();
        let tells = tells(&overheats);
        if count > 0 && !tells && distinct(&own) < LEAST_WINDS {
            if kind == SlowErrorKind::Offsets && OverheatHalves::is_two(evidence) {
                return Err(SlowErrorsUnknown::NoHalves);
            }
            return Err(SlowErrorsUnknown::FewWinds { least: LEAST_WINDS });
        }
        let square = |of: &SlowEquation, errors: Option<&SlowErrorsAt>| {
            errors.map_or(of.value, |at| of.left(&at.errors)).powi(2) / of.own_variance()
        };
        let mean = |with: bool| {
            let each = own.iter().zip(&found).filter_map(|(of, at)| Some(square(of.as_ref()?, with.then_some(at))));
            each.sum::<f64>() / count.max(1) as f64
        };
        let chi_square = [mean(false), mean(true)];
        if count == 0 {
            return Err(SlowErrorsUnknown::NoWind);
        }
        let begin_s = evidence.begin_s();
        let missed_mw = missed_mw(anemometer);
        let overheats = halves.filter(|_| !overheats.is_empty()).map(|halves| OverheatFinding {
            overheat_k: halves.overheat_k,
            halves: halves.halves.len(),
            chi_square: overheat_chi_square(&overheats, missed_mw, |slot| found[slot]),
            equations: overheats,
        });
        if overheats.is_some() {
            widen_by_missed(&mut found, missed_mw);
        }
        let found = Self { kind, prior, jumps, count, chi_square, overheats, begin_s, slot_s, equations: own, found };
        // Where nothing contradicts, or hardly, errors are as small as they are unknown.
        let open = open_errors(&found.prior, found.known().map(|(_, at)| at));
        if !tells && found.chi_square[0] > CONTRADICTED && open.iter().any(|open| !open.is_common && found.hides(open))
        {
            return Err(SlowErrorsUnknown::WindsAlike);
        }
        Ok(found)
    }

    /// Whether what is left open is a good part of what was found.
    fn hides(&self, open: &OpenError) -> bool {
        let first = if open.is_gain { SECTORS } else { 0 };
        let sizes = self.known().flat_map(|(_, at)| (first..first + SECTORS).map(|i| at.errors[i].abs()));
        open.deviation > HIDDEN * sizes.fold(0.0, f64::max)
    }

    /// The kind that makes the winds that both explain likelier, and the other one if it is hardly
    /// less likely; a jump has its price.
    pub fn likelier(a: Self, b: Self) -> (Self, Option<Self>) {
        let common = |of: &Self, other: &Self| -> f64 {
            let pairs = of.equations.iter().zip(&other.equations);
            let slots: Vec<_> = pairs.map(|(own, other)| own.filter(|_| other.is_some())).collect();
            let overheats = of.overheats.as_ref().or(other.overheats.as_ref()).map_or(&[][..], |of| &of.equations);
            let series = SlowSeries { slots: &slots, slot_s: of.slot_s, jumps: &of.jumps, overheats };
            doubt(&of.prior, &series) + JUMP_EXPLAINS * of.jumps.len() as f64
        };
        let difference = common(&b, &a) - common(&a, &b);
        let (better, other) = if difference < 0.0 { (b, a) } else { (a, b) };
        (better, (difference.abs() < AS_LIKELY).then_some(other))
    }

    /// Whether most of the contradictions are gone with these errors.
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
fn likeliest(prior: &mut SlowPrior, series: &SlowSeries<'_>, kind: SlowErrorKind) {
    let best = |prior: &mut SlowPrior, of: &[f64], set: &dyn Fn(&mut SlowPrior, f64)| {
        let with = |value: f64| {
            let mut other = *prior;
            set(&mut other, value);
            other
        };
        let least = of.iter().map(|&value| (with(value), doubt(&with(value), series)));
        if let Some((other, _)) = least.min_by(|a, b| a.1.total_cmp(&b.1)) {
            *prior = other;
        }
    };
    for _ in 0..2 {
        if kind != SlowErrorKind::Gains {
            best(prior, &OFFSETS_MW, &|of, mw| of.offset_mw = mw);
            best(prior, &TIMES_S, &|of, time_s| of.time_s = time_s);
        }
        if kind != SlowErrorKind::Offsets {
            best(prior, &GAINS_PERCENT, &|of, percent| of.gain_percent = percent);
            best(prior, &WALKS, &|of, walk| of.gain_walk = walk);
        }
        best(prior, &NOISES, &|of, noise| of.noise = noise);
    }
}
