//! Halves of a recording whose overheat alternates, and how their mean conductances vary by the
//! wind.
//!
//! Two levels are sought in the overheats of the slots. A half is what lies at one of them without
//! a change to the other; its begin is left out. Slots in which a surface is saturated, as while a
//! head cools or warms, are none of any half, for they have no equation.
//!
//! A mean over a half of b batches of a minute varies by the wind with the covariance
//!
//! ```text
//! Σ/b · f     Σ = ½ ⟨(ḡ' − ḡ)(ḡ' − ḡ)ᵀ⟩ over neighbouring batches ḡ, ḡ' of one half
//! ```
//!
//! f ≥ 1 is what differences of equal overheats, a half against its next ones at the same overheat,
//! are larger by than that: the slow part of the wind.
//!
//! Evidence of halves of two overheats of the heat of single surfaces, without varied winds.
//!
//! A surface that takes up heat beside the wind shows it in its conductance by S/θ, so at two
//! overheats differently, whatever the wind is; a gain shows at both alike. Of each half between
//! two of the other overheat
//!
//! ```text
//! D_h = r_h − ½ (r_{h−1} + r_{h+1}) = −Δx_h S + ε        r = G − G(v̄),  Δx likewise of x = c/θ
//! y = L⁻¹ D,  A = −L⁻¹ diag(Δx)                         L Lᵀ = cov ε
//! ```
//!
//! with v̄ the mean wind of the three, so that the gas's properties at other film temperatures, and
//! its rise, are taken out. A wind that becomes faster evenly cancels. The covariance of ε is that
//! above. Halves belong to one equation each.
//!
//! *Limits.* Quiescent-gas network and resistances are wrong at another overheat in their own way,
//! by `MISSED_MW`, which no record tells, and properties that the calibration assumes by more
//! ([`missed_mw`]).

use dr_core::wind::slow_errors::SurfaceCorrection;
use dr_core::wind::sphere::SECTORS;
use dr_core::wind::{Anemometer, MeasuredConductance, QualityFlags, WindState};
use nalgebra::{Cholesky, SMatrix, SVector};

use super::evidence::{SlowEvidence, SlowSlot};
use super::smoother::{OverheatEquation, SlowErrorsAt};

/// Least distance of the levels, as a share of the higher one.
pub const LEAST_SWING: f64 = 0.1;
/// Share of the distance by which a slot may be off a level.
const OFF_LEVEL: f64 = 0.1;
/// Left out after the begin of a half, s.
const SETTLING_S: f64 = 10.0;
/// Longest batch, s, and how many a half should have.
const BATCH_S: f64 = 60.0;
const BATCHES: usize = 4;
/// Least number of differences of batches, for a covariance of four.
const LEAST_DIFFERENCES: usize = 12;
/// Least number of differences of halves of equal overheat to judge the slow part by.
const LEAST_SAME: usize = 4;

/// One number a surface.
pub type BySurface = SVector<f64, SECTORS>;
/// Their covariance.
pub type SurfaceCovariance = SMatrix<f64, SECTORS, SECTORS>;

/// Slots at one overheat.
#[derive(Debug, Clone, PartialEq)]
pub struct OverheatHalf {
    /// It is the higher overheat.
    pub is_high: bool,
    /// Slot in its middle.
    pub slot: usize,
    /// Mean G, W/K.
    pub conductance_w_k: BySurface,
    /// Mean 1/θ, 1/K.
    pub per_overheat: BySurface,
    /// Mean temperature of the gas, °C.
    pub gas_c: f64,
    /// Number of batches.
    pub batches: f64,
}

/// Halves in their order.
#[derive(Debug, Clone, PartialEq)]
pub struct OverheatHalves {
    /// The higher and the lower overheat, K.
    pub overheat_k: [f64; 2],
    /// One after the other; neighbours are of different overheats.
    pub halves: Vec<OverheatHalf>,
    /// Σ f, W²/K².
    pub batch_w2_k2: SurfaceCovariance,
}

impl OverheatHalves {
    /// Halves of a recording that alternates for long enough; none of others.
    pub fn of(evidence: &SlowEvidence) -> Option<Self> {
        let slots = evidence.slots();
        let overheat_k = levels(slots)?;
        let in_slots = |time_s: f64| (time_s / evidence.slot_s()).round() as usize;
        let runs = runs(slots, overheat_k, in_slots(SETTLING_S).max(1));
        let longest = runs.iter().map(|run| run.places.len()).max()?;
        let length = in_slots(BATCH_S).min(longest / BATCHES).max(1);
        let batched: Vec<_> = runs.iter().map(|run| run.batches(slots, length)).collect();
        let differences: Vec<BySurface> =
            batched.iter().flat_map(|of| of.windows(2).map(|pair| pair[1] - pair[0])).collect();
        if differences.len() < LEAST_DIFFERENCES {
            return None;
        }
        let sum: SurfaceCovariance = differences.iter().map(|of| of * of.transpose()).sum();
        // So few differences leave it as uncertain, by Student's t.
        let freedom = 0.5 * differences.len() as f64;
        let batch_w2_k2 = sum * (0.5 / differences.len() as f64 * freedom / (freedom - SECTORS as f64));
        let halves: Vec<_> =
            runs.iter().zip(&batched).filter_map(|(run, of)| run.half(slots, (of.len() as f64).max(1.0))).collect();
        let mut found = Self { overheat_k, halves, batch_w2_k2 };
        found.batch_w2_k2 *= found.slow_factor();
        Some(found)
    }

    /// Tells whether a recording has two overheats, whatever its halves are.
    pub fn is_two(evidence: &SlowEvidence) -> bool {
        levels(evidence.slots()).is_some()
    }

    /// f
    fn slow_factor(&self) -> f64 {
        let difference = |five: &[OverheatHalf]| {
            let [before, _, at, _, after] = five else { return None };
            let off = at.conductance_w_k - 0.5 * (before.conductance_w_k + after.conductance_w_k);
            let share = 1.0 / at.batches + 0.25 * (1.0 / before.batches + 1.0 / after.batches);
            let inverse = (share * self.batch_w2_k2).try_inverse()?;
            Some(off.dot(&(inverse * off)) / SECTORS as f64)
        };
        let squares: Vec<f64> = self.halves.windows(5).filter_map(difference).collect();
        if squares.len() < LEAST_SAME { 1.0 } else { (squares.iter().sum::<f64>() / squares.len() as f64).max(1.0) }
    }

    /// Covariance of the mean of a half, W²/K².
    pub fn covariance_w2_k2(&self, half: &OverheatHalf) -> SurfaceCovariance {
        self.batch_w2_k2 / half.batches
    }
}

/// Mean overheat of a slot, K.
fn mean_k(slot: &SlowSlot) -> f64 {
    slot.overheat_k.iter().sum::<f64>() / SECTORS as f64
}

/// The higher and the lower overheat, K, if there are two.
fn levels(slots: &[SlowSlot]) -> Option<[f64; 2]> {
    let mut all: Vec<f64> = slots.iter().filter(|slot| slot.count > 0).map(mean_k).collect();
    all.sort_by(f64::total_cmp);
    let [low_k, high_k] = [all.len() / 10, all.len() * 9 / 10].map(|place| all.get(place).copied());
    let (low_k, high_k) = (low_k?, high_k?);
    (high_k - low_k > LEAST_SWING * high_k).then_some([high_k, low_k])
}

/// Slots at one overheat.
struct OverheatRun {
    is_high: bool,
    /// First slot, settled or not.
    begin: usize,
    /// Settled ones.
    places: Vec<usize>,
}

fn runs(slots: &[SlowSlot], [high_k, low_k]: [f64; 2], settling: usize) -> Vec<OverheatRun> {
    let near = OFF_LEVEL * (high_k - low_k);
    let mut runs: Vec<OverheatRun> = Vec::new();
    for (place, slot) in slots.iter().enumerate().filter(|(_, slot)| slot.count > 0) {
        let overheat_k = mean_k(slot);
        let is_high = (overheat_k - high_k).abs() < near;
        if !is_high && (overheat_k - low_k).abs() >= near {
            continue;
        }
        match runs.last_mut() {
            Some(run) if run.is_high == is_high => {
                if place >= run.begin + settling {
                    run.places.push(place);
                }
            }
            _ => runs.push(OverheatRun { is_high, begin: place, places: Vec::new() }),
        }
    }
    runs
}

impl OverheatRun {
    /// Mean conductances of batches of so many slots, W/K.
    fn batches(&self, slots: &[SlowSlot], length: usize) -> Vec<BySurface> {
        self.places.chunks_exact(length).map(|of| mean(of, |place| slots[place].conductance_w_k.into())).collect()
    }

    fn half(&self, slots: &[SlowSlot], batches: f64) -> Option<OverheatHalf> {
        let places = &self.places[..];
        Some(OverheatHalf {
            is_high: self.is_high,
            slot: *places.get(places.len() / 2)?,
            conductance_w_k: mean(places, |place| slots[place].conductance_w_k.into()),
            per_overheat: mean(places, |place| slots[place].overheat_k.map(|k| 1.0 / k).into()),
            gas_c: places.iter().map(|&place| slots[place].gas_c).sum::<f64>() / places.len() as f64,
            batches,
        })
    }
}

/// Mean over slots.
fn mean(places: &[usize], of: impl Fn(usize) -> BySurface) -> BySurface {
    places.iter().map(|&place| of(place)).sum::<BySurface>() / places.len().max(1) as f64
}

/// Standard uncertainty of S by two overheats however long they alternate, mW: sphere B without any
/// sun shows −0.07 to 0.09 mW at 30 and 20 K.
const MISSED_MW: f64 = 0.08;
/// The same where the calibration assumes film properties, which two overheats tell from those of
/// the gas: 0.2 to 0.75 mW on each surface, if it is wrong.
const MISSED_BY_FILM_MW: f64 = 0.5;

/// Heat that two overheats miss with such a head, mW.
pub fn missed_mw<const N: usize>(anemometer: &Anemometer<N>) -> f64 {
    if anemometer.is_film_assumed() { MISSED_BY_FILM_MW } else { MISSED_MW }
}

/// Least number of equations.
const LEAST_EQUATIONS: usize = 2;

/// One equation of each three halves; none where there are too few.
pub fn overheat_equations<const N: usize>(
    halves: &OverheatHalves,
    anemometer: &Anemometer<N>,
    corrections: impl Fn(usize) -> [SurfaceCorrection; SECTORS],
) -> Vec<OverheatEquation> {
    let gains: Vec<f64> = anemometer.gains().map(f64::from).collect();
    let gains = BySurface::from_fn(|i, _| gains.get(i).copied().unwrap_or(1.0));
    let of = |three: &[OverheatHalf]| {
        let [before, at, after] = three else { return None };
        let all = [before, at, after];
        let [before_w_k, at_w_k, after_w_k] = beyond_gas(all, anemometer, &gains, &corrections(at.slot))?;
        let difference = at_w_k - 0.5 * (before_w_k + after_w_k);
        let share = (at.per_overheat - 0.5 * (before.per_overheat + after.per_overheat)).component_mul(&gains);
        let [before, at_itself, after] = all.map(|half| halves.covariance_w2_k2(half));
        let lower = Cholesky::new(at_itself + 0.25 * (before + after))?.l();
        let value = lower.solve_lower_triangular(&difference)?;
        let per_mw = lower.solve_lower_triangular(&SurfaceCovariance::from_diagonal(&(-1e-3 * share)))?;
        Some(OverheatEquation { slot: at.slot, value, per_mw })
    };
    let found: Vec<_> = halves.halves.chunks_exact(3).filter_map(of).collect();
    if found.len() < LEAST_EQUATIONS { Vec::new() } else { found }
}

/// Conductances of halves less those of their mean wind, W/K; those themselves would hold the gas's
/// properties at the overheat.
fn beyond_gas<const N: usize>(
    halves: [&OverheatHalf; 3],
    anemometer: &Anemometer<N>,
    gains: &BySurface,
    corrections: &[SurfaceCorrection; SECTORS],
) -> Option<[BySurface; 3]> {
    let vector = anemometer.vector()?;
    let gas = |half: &OverheatHalf| {
        let (gas_c, overheat_k) = (half.gas_c as f32, half.per_overheat.map(|x| 1.0 / x).mean() as f32);
        Some((anemometer.gas_at(gas_c, overheat_k)?, anemometer.free_stream(gas_c, overheat_k)))
    };
    let mut inverse = WindState::default();
    let mut sum_m_s = [0.0_f32; 3];
    for half in halves {
        let measured = |i: usize| {
            let share = (gains[i] * half.per_overheat[i]) as f32;
            let conductance_w_k = corrections[i].corrected_w_k(half.conductance_w_k[i] as f32, share);
            Some(MeasuredConductance { conductance_w_k, variance_w2_k2: 1e-12 })
        };
        let (gas, (free, rise_speed_m_s)) = gas(half)?;
        let met = vector.step(&mut inverse, &gas, &core::array::from_fn::<_, SECTORS, _>(measured));
        if met.quality.has(QualityFlags::FAILED) {
            return None;
        }
        let wind_m_s = free.wind(met.wind_m_s, rise_speed_m_s);
        sum_m_s = core::array::from_fn(|k| sum_m_s[k] + wind_m_s[k] / 3.0);
    }
    let mut beyond = halves.map(|half| half.conductance_w_k);
    for (of, half) in beyond.iter_mut().zip(halves) {
        let (gas, (free, rise_speed_m_s)) = gas(half)?;
        let expected = vector.conductances(&gas, free.met(sum_m_s, rise_speed_m_s));
        *of -= BySurface::from_fn(|i, _| expected[i].conductance_w_k.into());
    }
    Some(beyond)
}

/// χ² of S = 0 over its degrees of freedom, without and with errors: of the mean that fits all
/// equations, with what two overheats miss in its variance.
pub fn overheat_chi_square(
    equations: &[OverheatEquation],
    missed_mw: f64,
    errors: impl Fn(usize) -> SlowErrorsAt,
) -> [f64; 2] {
    let mut normal = SurfaceCovariance::zeros();
    let mut pulls = [BySurface::zeros(); 2];
    for of in equations {
        normal += of.per_mw.transpose() * of.per_mw;
        let explained: BySurface = of.per_mw * errors(of.slot).errors.fixed_rows::<SECTORS>(0);
        for (pull, left) in pulls.iter_mut().zip([of.value, of.value - explained]) {
            *pull += of.per_mw.transpose() * left;
        }
    }
    let missed = SurfaceCovariance::identity() * missed_mw.powi(2);
    let Some(covariance) = normal.try_inverse() else { return [0.0; 2] };
    let Some(precision) = (covariance + missed).try_inverse() else { return [0.0; 2] };
    pulls.map(|pull| {
        let mean_mw = covariance * pull;
        mean_mw.dot(&(precision * mean_mw)) / SECTORS as f64
    })
}

/// Adds what two overheats miss to the covariance of the errors.
pub fn widen_by_missed(errors: &mut [SlowErrorsAt], missed_mw: f64) {
    for at in errors {
        for i in 0..SECTORS {
            at.covariance[(i, i)] += missed_mw.powi(2);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dr_core::wind::form::MOST_SURFACES;
    use dr_core::wind::{QualityFlags, WindEstimate, WindTick};

    const HALF_S: f64 = 400.0;
    const NOISE_W_K: f64 = 1e-5;

    /// So many halves, of which the first 100 s are saturated, as an estimate each second: steps of
    /// noise of their own, and a slow wave.
    fn evidence(halves: u32, overheat_k: [f32; 2], wave_w_k: f64) -> SlowEvidence {
        let mut evidence = SlowEvidence::default();
        for second in 0..u64::from(halves) * HALF_S as u64 {
            let time_s = second as f64;
            let (half, since_s) = ((time_s / HALF_S) as usize, time_s % HALF_S);
            // Uniform of variance 1, another one each slot and surface.
            let noise = |i: usize| {
                let step = [0.754_877_666, 0.569_840_291, 0.618_033_989, 0.414_213_562][i % SECTORS];
                12.0_f64.sqrt() * (((second / 2) as f64 * step).fract() - 0.5)
            };
            let wave = wave_w_k * libm::sin(0.6 * half as f64);
            let moves = if since_s < 100.0 { QualityFlags::SATURATED } else { QualityFlags::default() };
            evidence.add(
                time_s,
                &WindTick {
                    surfaces: 4,
                    conductance_w_k: core::array::from_fn::<_, MOST_SURFACES, _>(|i| {
                        (1e-3 + NOISE_W_K * noise(i) + wave) as f32
                    }),
                    raw_w_k: [0.0; MOST_SURFACES],
                    variance_w2_k2: [1e-12; SECTORS],
                    overheat_k: [overheat_k[half % 2]; SECTORS],
                    gas_c: -53.0,
                    wind: WindEstimate::none(),
                    quality_flags: moves,
                },
            );
        }
        evidence
    }

    #[test]
    fn halves_are_what_lies_at_two_overheats_in_turn() {
        let found = OverheatHalves::of(&evidence(8, [30.0, 20.0], 0.0)).unwrap();
        assert_eq!(found.overheat_k, [30.0, 20.0]);
        let high: Vec<bool> = found.halves.iter().map(|half| half.is_high).collect();
        assert_eq!(high, [true, false, true, false, true, false, true, false]);
        for (n, half) in found.halves.iter().enumerate() {
            // In the middle of the last 290 s.
            let expected = (HALF_S * n as f64 + 255.0) / 2.0;
            assert!((half.slot as f64 - expected).abs() < 3.0, "{n}: {half:?}");
            assert!((half.per_overheat[2] - if half.is_high { 1.0 / 30.0 } else { 0.05 }).abs() < 1e-9);
            assert_eq!(half.batches, 4.0);
        }
        // Quasi-random noise of a slot averages out at least as well as white one over 30 slots.
        let batch_w_k = found.batch_w2_k2[(1, 1)].sqrt();
        assert!(batch_w_k < 1.5 * NOISE_W_K / 30.0_f64.sqrt(), "{batch_w_k}");
    }

    #[test]
    fn a_wind_that_moves_slowly_makes_halves_more_uncertain_than_their_batches_say() {
        let quiet = OverheatHalves::of(&evidence(12, [30.0, 20.0], 0.0)).unwrap();
        let slow = OverheatHalves::of(&evidence(12, [30.0, 20.0], 1e-4)).unwrap();
        let half_w_k = slow.covariance_w2_k2(&slow.halves[5])[(0, 0)].sqrt();
        // Differences of equal overheat: the wave times 1 − cos 1.2, by √1.5.
        assert!((2e-5..8e-5).contains(&half_w_k), "{half_w_k}");
        assert!(quiet.covariance_w2_k2(&quiet.halves[5])[(0, 0)].sqrt() < 2e-6);
    }

    #[test]
    fn a_recording_of_one_overheat_or_of_few_halves_has_none() {
        assert_eq!(OverheatHalves::of(&evidence(8, [30.0, 30.0], 0.0)), None);
        assert_eq!(OverheatHalves::of(&evidence(8, [30.0, 28.0], 0.0)), None);
        assert_eq!(OverheatHalves::of(&evidence(2, [30.0, 20.0], 0.0)), None);
        assert_eq!(OverheatHalves::of(&SlowEvidence::default()), None);
    }
}
