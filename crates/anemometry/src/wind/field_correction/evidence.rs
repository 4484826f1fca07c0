//! Evidence of a recording about slow errors: conductances of its four surfaces, averaged over
//! slots of some seconds.
//!
//! Slots grow with the recording, so that there are 4096 at most; of two that become one
//! the steadier is kept, for a mean over a wind that has changed is of no wind.
//!
//! Each slot has an equation, about the winds that follow from the errors found so far.
//!
//! A surface answers to a change of the wind a little later than another, so what G changes in a
//! slot, and from the slot before, adds to the variance of its equation. Winds are missed alike by
//! the calibration with the correlation exp(−d²/2), d² = (angle/0.3)² + (ln of speeds/0.3)².

use dr_core::wind::slow_errors::{SpareNumber, SurfaceCorrection};
use dr_core::wind::sphere::SECTORS;
use dr_core::wind::{Anemometer, Conductance, MeasuredConductance, QualityFlags, WindState, WindTick};

use super::smoother::{SlowEquation, SlowErrorsAt};

use crate::vector::{angle_deg, length};

/// First length of a slot, s.
const SLOT_S: f64 = 2.0;
const MOST_SLOTS: usize = 4096;

/// Estimates that are `starting` later than this are so for their stored heat, which is a slow
/// error as any, or is none: a head in the sun looks as if it had been warm, s.
const BEGUN_S: f64 = 60.0;

/// With one of these the conductances themselves are wrong or missing.
const NOT_USED: [QualityFlags; 7] = [
    QualityFlags::REFUSED,
    QualityFlags::DEGRADED,
    QualityFlags::UNCALIBRATED,
    QualityFlags::NO_GAS,
    QualityFlags::NOT_RUNNING,
    QualityFlags::SATURATED,
    QualityFlags::COLD,
];

/// Means over a slot.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SlowSlot {
    /// Number of estimates.
    pub count: u32,
    /// G, W/K.
    pub conductance_w_k: [f64; SECTORS],
    /// Variances of single estimates by the noise, W²/K².
    pub variance_w2_k2: [f64; SECTORS],
    /// Mean squares of what G changes within the slot, W²/K².
    pub spread_w2_k2: [f64; SECTORS],
    /// θ, K.
    pub overheat_k: [f64; SECTORS],
    /// Temperature of the gas, °C.
    pub gas_c: f64,
}

/// Slots of a recording, from its first estimate on.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SlowEvidence {
    begin_s: Option<f64>,
    /// Number of times that the slots have become twice as long.
    doubled: i32,
    slots: Vec<SlowSlot>,
}

impl SlowEvidence {
    /// Adds an estimate as it was before any correction; those without all four conductances leave
    /// nothing.
    pub fn add(&mut self, time_s: f64, estimate: &WindTick) {
        let begin_s = *self.begin_s.get_or_insert(time_s);
        let is_used = usize::from(estimate.surfaces) == SECTORS
            && (time_s - begin_s >= BEGUN_S || !estimate.quality_flags.has(QualityFlags::STARTING))
            && NOT_USED.iter().all(|&flag| !estimate.quality_flags.has(flag))
            && estimate.variance_w2_k2.iter().take(SECTORS).all(|&variance| variance > 0.0);
        if !is_used || time_s < begin_s {
            return;
        }
        let mut place = self.place(time_s - begin_s);
        while place >= MOST_SLOTS {
            self.halve();
            place = self.place(time_s - begin_s);
        }
        if self.slots.len() <= place {
            self.slots.resize(place + 1, SlowSlot::default());
        }
        if let Some(slot) = self.slots.get_mut(place) {
            slot.add(estimate);
        }
    }

    fn place(&self, since_s: f64) -> usize {
        (since_s / self.slot_s()) as usize
    }

    fn halve(&mut self) {
        self.doubled += 1;
        self.slots =
            self.slots.chunks(2).map(|pair| *pair.iter().reduce(SlowSlot::steadier).unwrap_or(&pair[0])).collect();
    }

    /// Length of a slot, s.
    pub fn slot_s(&self) -> f64 {
        SLOT_S * libm::exp2(f64::from(self.doubled))
    }

    /// Time of the first estimate, s.
    pub fn begin_s(&self) -> f64 {
        self.begin_s.unwrap_or_default()
    }

    /// All slots; some are empty.
    pub fn slots(&self) -> &[SlowSlot] {
        &self.slots
    }

    /// Tells whether a head can be corrected: four surfaces round a body, with a calibration.
    pub fn is_of<const N: usize>(anemometer: &Anemometer<N>) -> bool {
        anemometer.vector().is_some() && anemometer.gains().count() == SECTORS
    }
}

impl SlowSlot {
    fn add(&mut self, estimate: &WindTick) {
        self.count += 1;
        let share = 1.0 / f64::from(self.count);
        let mean = |of: &mut f64, value: f64| *of += share * (value - *of);
        for i in 0..SECTORS {
            let conductance_w_k = f64::from(estimate.conductance_w_k[i]);
            let before = conductance_w_k - self.conductance_w_k[i];
            mean(&mut self.conductance_w_k[i], conductance_w_k);
            mean(&mut self.spread_w2_k2[i], before * (conductance_w_k - self.conductance_w_k[i]));
            mean(&mut self.variance_w2_k2[i], f64::from(estimate.variance_w2_k2[i]));
            mean(&mut self.overheat_k[i], f64::from(estimate.overheat_k[i]));
        }
        mean(&mut self.gas_c, f64::from(estimate.gas_c));
    }

    fn unrest(&self) -> f64 {
        if self.count == 0 { f64::INFINITY } else { self.spread_w2_k2.iter().sum() }
    }

    fn steadier<'a>(a: &'a Self, b: &'a Self) -> &'a Self {
        if b.unrest() < a.unrest() { b } else { a }
    }
}

/// Shares of what G changes in a slot, and of what it has changed since the slot before, that are
/// not one wind's.
const WITHIN: f64 = 1.0;
const SINCE: f64 = 0.01;
/// Change of direction in rad, and of speed as logarithm, beyond which winds are missed each in its
/// own way.
const ALIKE: f64 = 0.3;

/// With one of these a wind says nothing about slow errors.
const UNUSABLE_WINDS: [QualityFlags; 5] = [
    QualityFlags::FAILED,
    QualityFlags::NO_DIRECTION,
    QualityFlags::AMBIGUOUS,
    QualityFlags::EXTRAPOLATED,
    QualityFlags::REFUSED,
];

/// Corrections in the units of a board.
pub fn corrections(errors: &SlowErrorsAt) -> [SurfaceCorrection; SECTORS] {
    core::array::from_fn(|i| SurfaceCorrection {
        offset_w: (1e-3 * errors.errors[i]) as f32,
        gain: (1e-2 * errors.errors[SECTORS + i]) as f32,
        ..SurfaceCorrection::default()
    })
}

/// One equation a slot where there is one; `found` are the errors at the slots, or none yet.
pub fn equations<const N: usize>(
    evidence: &SlowEvidence,
    anemometer: &Anemometer<N>,
    found: &[SlowErrorsAt],
    bandwidth_hz: f64,
) -> Vec<Option<SlowEquation>> {
    let mut inverse = WindState::default();
    let mut last: Option<(SlowSlot, [f64; 3], [f32; SECTORS])> = None;
    let mut each = |(place, slot): (usize, &SlowSlot)| {
        let correction = found.get(place).map_or([SurfaceCorrection::default(); SECTORS], corrections);
        let (mut spare, wind_m_s, missed) = linear(slot, anemometer, &correction, &mut inverse)?;
        let before = last.replace((*slot, wind_m_s, spare.null));
        let mut correlation = 0.0;
        if let Some((_, last_m_s, last_null)) = &before {
            let turned: f32 = spare.null.iter().zip(last_null).map(|(a, b)| a * b).sum();
            if turned < 0.0 {
                spare = SpareNumber {
                    residual: -spare.residual,
                    per_offset_w: spare.per_offset_w.map(|x| -x),
                    per_gain: spare.per_gain.map(|x| -x),
                    null: spare.null.map(|x| -x),
                };
            }
            if let Some((_, _, null)) = &mut last {
                *null = spare.null;
            }
            correlation = libm::exp(-0.5 * distance_square(wind_m_s, *last_m_s));
        }
        let unrest = |i: usize| {
            let since = before.as_ref().map_or(0.0, |(of, ..)| slot.conductance_w_k[i] - of.conductance_w_k[i]);
            let changed = WITHIN.powi(2) * slot.spread_w2_k2[i] + (SINCE * since).powi(2);
            f64::from(spare.null[i]).powi(2) * changed / slot.variance_w2_k2[i]
        };
        let independent = (2.0 * bandwidth_hz * evidence.slot_s()).clamp(1.0, f64::from(slot.count));
        Some(SlowEquation {
            value: -f64::from(spare.residual),
            per_mw: spare.per_offset_w.map(|x| 1e-3 * f64::from(x)),
            per_percent: spare.per_gain.map(|x| 1e-2 * f64::from(x)),
            variance: 1.0 / independent + (0..SECTORS).map(unrest).sum::<f64>(),
            missed,
            correlation,
            wind_m_s,
        })
    };
    evidence.slots().iter().enumerate().map(&mut each).collect()
}

/// Number of winds that differ from each other by more than what is missed alike.
pub fn distinct(equations: &[Option<SlowEquation>]) -> usize {
    let mut winds: Vec<[f64; 3]> = Vec::new();
    for of in equations.iter().flatten() {
        if winds.iter().all(|known| distance_square(of.wind_m_s, *known) > 1.0) {
            winds.push(of.wind_m_s);
        }
    }
    winds.len()
}

/// d²
fn distance_square(a: [f64; 3], b: [f64; 3]) -> f64 {
    let angle_rad = angle_deg(a, b).to_radians();
    let faster = libm::log(length(a) / length(b));
    (angle_rad.powi(2) + faster.powi(2)) / ALIKE.powi(2)
}

/// The spare number of a slot about its corrected wind, this wind in m/s, and what the calibration
/// misses.
fn linear<const N: usize>(
    slot: &SlowSlot,
    anemometer: &Anemometer<N>,
    correction: &[SurfaceCorrection; SECTORS],
    inverse: &mut WindState,
) -> Option<(SpareNumber, [f64; 3], f64)> {
    if slot.count == 0 {
        return None;
    }
    let vector = anemometer.vector()?;
    let overheat_k = slot.overheat_k.iter().sum::<f64>() / SECTORS as f64;
    let gas = anemometer.gas_at(slot.gas_c as f32, overheat_k as f32)?;
    let mut share_per_k = [0.0; SECTORS];
    for (i, gain) in anemometer.gains().enumerate().take(SECTORS) {
        share_per_k[i] = gain / slot.overheat_k[i] as f32;
    }
    let measured: [MeasuredConductance; SECTORS] = core::array::from_fn(|i| MeasuredConductance {
        conductance_w_k: slot.conductance_w_k[i] as f32,
        variance_w2_k2: slot.variance_w2_k2[i] as f32,
    });
    let corrected: [Option<MeasuredConductance>; SECTORS] = core::array::from_fn(|i| {
        let conductance_w_k = correction[i].corrected_w_k(measured[i].conductance_w_k, share_per_k[i]);
        Some(MeasuredConductance { conductance_w_k, ..measured[i] })
    });
    let wind = vector.step(inverse, &gas, &corrected);
    if UNUSABLE_WINDS.iter().any(|&flag| wind.quality.has(flag)) {
        return None;
    }
    let [a, b, c, d, ..] = vector.conductances(&gas, wind.wind_m_s);
    let expected: [Conductance; SECTORS] = [a, b, c, d];
    let spare = SpareNumber::of(&measured, &share_per_k, &expected)?;
    let square: f64 = (0..SECTORS).map(|i| slot.conductance_w_k[i].powi(2) / slot.variance_w2_k2[i]).sum();
    let share = f64::from(anemometer.missed_share(&gas, slot.gas_c as f32, wind.speed_m_s));
    let missed = share * (square / SECTORS as f64).sqrt();
    Some((spare, wind.wind_m_s.map(f64::from), missed))
}

#[cfg(test)]
mod tests {
    use super::*;
    use dr_core::wind::WindEstimate;
    use dr_core::wind::form::MOST_SURFACES;

    fn estimate(conductance_w_k: f32) -> WindTick {
        WindTick {
            surfaces: 4,
            conductance_w_k: [conductance_w_k; MOST_SURFACES],
            raw_w_k: [0.0; MOST_SURFACES],
            variance_w2_k2: [1e-12; SECTORS],
            overheat_k: [30.0; SECTORS],
            gas_c: -53.0,
            wind: WindEstimate::none(),
            quality_flags: QualityFlags::default(),
        }
    }

    #[test]
    fn slots_hold_means_and_what_changes_within_them() {
        let mut evidence = SlowEvidence::default();
        for (time_s, g) in [(10.0, 1e-3), (11.0, 2e-3), (12.5, 3e-3)] {
            evidence.add(time_s, &estimate(g));
        }
        let saturated = WindTick { quality_flags: QualityFlags::SATURATED, ..estimate(9.0) };
        evidence.add(13.0, &saturated);
        let [first, second] = evidence.slots() else { panic!("{evidence:?}") };
        assert!((first.conductance_w_k[3] - 1.5e-3).abs() < 1e-9 && (first.spread_w2_k2[3] - 0.25e-6).abs() < 1e-12);
        assert_eq!((first.count, second.count), (2, 1));
    }

    #[test]
    fn of_a_long_recording_the_steadier_slots_are_kept() {
        let mut evidence = SlowEvidence::default();
        for n in 0..2 * MOST_SLOTS {
            // Every other slot is a gust.
            let gust = if n % 2 == 1 { 1e-3 } else { 0.0 };
            evidence.add(2.0 * n as f64, &estimate(1e-3));
            evidence.add(2.0 * n as f64 + 1.0, &estimate(1e-3 + gust));
        }
        assert_eq!((evidence.slot_s(), evidence.slots().len()), (4.0, MOST_SLOTS));
        let early = &evidence.slots()[..MOST_SLOTS / 2];
        assert!(early.iter().all(|slot| slot.count == 2 && slot.spread_w2_k2[0] < 1e-12));
    }
}
