//! What halves of two overheats say of the heat of single surfaces, without varied winds.
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
//! of [`super::halves`]. Halves belong to one equation each.
//!
//! *Limits.* Quiescent-gas network and resistances are wrong at another overheat in their own way,
//! by `MISSED_MW`, which no record tells, and properties that the calibration assumes by more
//! ([`missed_mw`]).

use dr_core::wind::slow_errors::SurfaceCorrection;
use dr_core::wind::sphere::SECTORS;
use dr_core::wind::{Anemometer, MeasuredConductance, QualityFlags, WindState};
use nalgebra::Cholesky;

use super::halves::{BySurface, OverheatHalf, OverheatHalves, SurfaceCovariance};
use super::smoother::{OverheatEquation, SlowErrorsAt};

/// Standard uncertainty of S by two overheats however long they alternate, mW: sphere B without any
/// sun shows −0.07 to 0.09 mW at 30 and 20 K.
const MISSED_MW: f64 = 0.08;
/// The same where the calibration assumes film properties, which two overheats tell from those of
/// the gas: 0.2 to 0.75 mW on each surface, if it is wrong.
const MISSED_BY_FILM_MW: f64 = 0.5;

/// What two overheats miss with such a head, mW.
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
