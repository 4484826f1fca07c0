//! The equations of a recording's slots, about the winds that follow from the errors found so far.
//!
//! A surface answers to a change of the wind a little later than another, so what G changes in a
//! slot, and from the slot before, adds to the variance of its equation. Winds are missed alike by
//! the calibration with the correlation exp(−d²/2), d² = (angle/0.3)² + (ln of speeds/0.3)².

use dr_core::wind::slow_errors::{SpareNumber, SurfaceCorrection};
use dr_core::wind::sphere::SECTORS;
use dr_core::wind::{Anemometer, Conductance, MeasuredConductance, QualityFlags, WindState};

use super::evidence::{SlowEvidence, SlowSlot};
use super::smoother::{SlowEquation, SlowErrorsAt};
use crate::vector::{angle_deg, length};

/// Shares of what G changes in a slot, and of what it has changed since the slot before, that are
/// not one wind's.
const WITHIN: f64 = 1.0;
const SINCE: f64 = 0.01;
/// Change of direction in rad, and of speed as logarithm, beyond which winds are missed each in its
/// own way.
const ALIKE: f64 = 0.3;

/// With one of these a wind says nothing about slow errors.
const NOT_USED: [QualityFlags; 5] = [
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
        let linear = linear(slot, anemometer, &correction, &mut inverse)?;
        let LinearSlot { mut spare, wind_m_s, missed } = linear;
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
            correlation = (-0.5 * distance_square(wind_m_s, *last_m_s)).exp();
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

/// How many winds differ from each other by more than what is missed alike.
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
    let faster = (length(a) / length(b)).ln();
    (angle_rad.powi(2) + faster.powi(2)) / ALIKE.powi(2)
}

struct LinearSlot {
    spare: SpareNumber,
    wind_m_s: [f64; 3],
    missed: f64,
}

/// The spare number of a slot about its corrected wind.
fn linear<const N: usize>(
    slot: &SlowSlot,
    anemometer: &Anemometer<N>,
    correction: &[SurfaceCorrection; SECTORS],
    inverse: &mut WindState,
) -> Option<LinearSlot> {
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
    if NOT_USED.iter().any(|&flag| wind.quality.has(flag)) {
        return None;
    }
    let [a, b, c, d, ..] = vector.conductances(&gas, wind.wind_m_s);
    let expected: [Conductance; SECTORS] = [a, b, c, d];
    let spare = SpareNumber::of(&measured, &share_per_k, &expected)?;
    let square: f64 = (0..SECTORS).map(|i| slot.conductance_w_k[i].powi(2) / slot.variance_w2_k2[i]).sum();
    let share = f64::from(anemometer.missed_share(&gas, slot.gas_c as f32, wind.speed_m_s));
    let missed = share * (square / SECTORS as f64).sqrt();
    Some(LinearSlot { spare, wind_m_s: wind.wind_m_s.map(f64::from), missed })
}
