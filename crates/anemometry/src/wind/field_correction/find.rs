//! The search of slow errors: in rounds of linear equations about the winds of the round before,
//! size and quickness by likelihood, then the errors, then a jump as long as one explains much.

use dr_core::wind::Anemometer;
use dr_core::wind::sphere::SECTORS;

use super::correction::{
    CONTRADICTED, FieldCorrection, JUMP_EXPLAINS, LEAST_WINDS, OpenError, OverheatFinding, SlowErrorKind,
    SlowErrorsUnknown, open_errors,
};
use super::evidence::{SlowEvidence, corrections, distinct, equations};
use super::halves::{OverheatHalves, missed_mw, overheat_chi_square, overheat_equations, widen_by_missed};
use super::smoother::{OverheatEquation, SlowEquation, SlowErrorsAt, SlowJump, SlowPrior, SlowSeries, doubt, smooth};

const ROUNDS: usize = 8;
const MOST_JUMPS: usize = 12;
/// Variance of an equation up to which its wind was steady, and how many such winds it takes to
/// find what all surfaces share: means over gusts contradict a little, and in the same way as that.
const STEADY: f64 = 3.0;
const LEAST_STEADY: f64 = 20.0;
/// Uncertainty over the greatest error from which on it is not known which surface is wrong.
const HIDDEN: f64 = 0.25;
/// Standard deviations beyond which a residual counts as less.
const FAR: f64 = 3.0;

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
        // Gains do not show in differences of overheat.
        let halves = OverheatHalves::of(evidence).filter(|_| kind != SlowErrorKind::Gains);
        let mut search = SlowErrorSearch::new(kind, evidence.slot_s());
        for _ in 0..ROUNDS {
            search.equations = equations(evidence, anemometer, &search.found, bandwidth_hz);
            if let Some(halves) = &halves {
                let at = |slot: usize| search.found.get(slot).map_or_else(Default::default, corrections);
                search.overheats = overheat_equations(halves, anemometer, at);
            }
            search.solve();
        }
        search.check(evidence)?;
        let by_overheats = search.by_overheats();
        let chi_square = search.chi_square();
        let SlowErrorSearch { prior, equations, overheats, mut found, jumps, slot_s, .. } = search;
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
        let (count, begin_s) = (equations.iter().flatten().count(), evidence.begin_s());
        let found = Self { kind, prior, jumps, count, chi_square, overheats, begin_s, slot_s, equations, found };
        // Where nothing contradicts, or hardly, errors are as small as they are unknown.
        let open = open_errors(&found.prior, found.known().map(|(_, at)| at));
        let hides = open.iter().any(|open| !open.is_common && found.hides(open));
        if !by_overheats && chi_square[0] > CONTRADICTED && hides {
            return Err(SlowErrorsUnknown::WindsAlike);
        }
        Ok(found)
    }

    /// Tells whether what is left open is a good part of what was found.
    fn hides(&self, open: &OpenError) -> bool {
        let first = if open.is_gain { SECTORS } else { 0 };
        let sizes = self.known().flat_map(|(_, at)| (first..first + SECTORS).map(|i| at.errors[i].abs()));
        open.deviation > HIDDEN * sizes.fold(0.0, f64::max)
    }
}

/// A search after some rounds.
struct SlowErrorSearch {
    kind: SlowErrorKind,
    slot_s: f64,
    prior: SlowPrior,
    /// About what the round before found.
    equations: Vec<Option<SlowEquation>>,
    overheats: Vec<OverheatEquation>,
    found: Vec<SlowErrorsAt>,
    jumps: Vec<SlowJump>,
}

impl SlowErrorSearch {
    fn new(kind: SlowErrorKind, slot_s: f64) -> Self {
        let prior = SlowPrior {
            offset_mw: if kind == SlowErrorKind::Gains { 0.0 } else { 1.0 },
            time_s: 800.0,
            gain_percent: if kind == SlowErrorKind::Offsets { 0.0 } else { 1.0 },
            gain_walk: 0.0,
            is_common_sought: true,
            noise: 1.0,
        };
        let (equations, overheats, found, jumps) = Default::default();
        Self { kind, slot_s, prior, equations, overheats, found, jumps }
    }

    /// Means over gusts contradict a little, in the same way at both overheats: where these are
    /// enough, nothing else is used.
    fn by_overheats(&self) -> bool {
        !self.overheats.is_empty() && self.kind == SlowErrorKind::Offsets
    }

    /// The errors of a round.
    fn solve(&mut self) {
        let steady = self.equations.iter().flatten().filter(|of| of.variance < STEADY);
        let steady: f64 = steady.map(|of| 1.0 - of.correlation.powi(2)).sum();
        self.prior.is_common_sought = steady >= LEAST_STEADY || !self.overheats.is_empty();
        let slots = if self.by_overheats() { vec![None; self.equations.len()] } else { self.doubted() };
        loop {
            let Self { slot_s, jumps, overheats, .. } = &*self;
            let series = SlowSeries { slots: &slots, slot_s: *slot_s, jumps, overheats };
            let prior = likeliest(self.prior, &series, self.kind);
            let (found, jump) = smooth(&prior, &series);
            (self.prior, self.found) = (prior, found);
            match jump {
                Some((jump, explains)) if explains > JUMP_EXPLAINS && self.jumps.len() < MOST_JUMPS => {
                    self.jumps.push(jump);
                }
                _ => return,
            }
        }
    }

    /// The equations with those that contradict the errors widened.
    fn doubted(&self) -> Vec<Option<SlowEquation>> {
        let widened = |(place, equation): (usize, &Option<SlowEquation>)| {
            let mut equation = (*equation)?;
            if let Some(at) = self.found.get(place) {
                let off = equation.left(&at.errors).powi(2) / (self.prior.noise * equation.own_variance());
                equation.variance *= (off / FAR.powi(2)).max(1.0);
            }
            Some(equation)
        };
        self.equations.iter().enumerate().map(widened).collect()
    }

    /// Tells whether there is something that errors can be found by.
    fn check(&self, evidence: &SlowEvidence) -> Result<(), SlowErrorsUnknown> {
        if self.equations.iter().flatten().next().is_none() {
            return Err(SlowErrorsUnknown::NoWind);
        }
        if self.by_overheats() || distinct(&self.equations) >= LEAST_WINDS {
            return Ok(());
        }
        Err(if self.kind == SlowErrorKind::Offsets && OverheatHalves::is_two(evidence) {
            SlowErrorsUnknown::NoHalves
        } else {
            SlowErrorsUnknown::FewWinds
        })
    }

    /// Mean square of what the equations leave, in their own variances, without and with errors.
    fn chi_square(&self) -> [f64; 2] {
        let known = || self.equations.iter().zip(&self.found).filter_map(|(of, at)| Some((of.as_ref()?, at)));
        let count = known().count().max(1) as f64;
        let mean = |left: &dyn Fn(&SlowEquation, &SlowErrorsAt) -> f64| {
            known().map(|(of, at)| left(of, at).powi(2) / of.own_variance()).sum::<f64>() / count
        };
        [mean(&|of, _| of.value), mean(&|of, at| of.left(&at.errors))]
    }
}

const OFFSETS_MW: [f64; 9] = [0.0, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0];
const GAINS_PERCENT: [f64; 8] = [0.0, 0.1, 0.3, 1.0, 2.0, 4.0, 8.0, 16.0];
const WALKS: [f64; 6] = [0.0, 0.01, 0.03, 0.1, 0.2, 0.4];
const TIMES_S: [f64; 11] = [100.0, 200.0, 400.0, 800.0, 1600.0, 3200.0, 6400.0, 12800.0, 25600.0, 51200.0, 102400.0];
const NOISES: [f64; 7] = [0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0];

/// A prior with each number in turn taken as it makes the equations likeliest.
pub fn likeliest(mut prior: SlowPrior, series: &SlowSeries<'_>, kind: SlowErrorKind) -> SlowPrior {
    let mut best = |of: &[f64], set: &dyn Fn(&mut SlowPrior, f64)| {
        let with = |&value: &f64| {
            let mut other = prior;
            set(&mut other, value);
            (other, doubt(&other, series))
        };
        if let Some((other, _)) = of.iter().map(with).min_by(|a, b| a.1.total_cmp(&b.1)) {
            prior = other;
        }
    };
    for _ in 0..2 {
        if kind != SlowErrorKind::Gains {
            best(&OFFSETS_MW, &|of, mw| of.offset_mw = mw);
            best(&TIMES_S, &|of, time_s| of.time_s = time_s);
        }
        if kind != SlowErrorKind::Offsets {
            best(&GAINS_PERCENT, &|of, percent| of.gain_percent = percent);
            best(&WALKS, &|of, walk| of.gain_walk = walk);
        }
        best(&NOISES, &|of, noise| of.noise = noise);
    }
    prior
}
