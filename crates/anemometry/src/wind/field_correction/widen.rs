//! What the covariance of slow errors adds to that of a wind.
//!
//! C ← C + K D P Dᵀ Kᵀ,  K = (Jᵀ W J)⁻¹ Jᵀ W,  D = ∂G'/∂(S, γ): the wind that follows by least
//! squares from conductances that are wrong by them.

use dr_core::wind::sphere::SECTORS;
use dr_core::wind::{Anemometer, QualityFlags, WindTick};
use nalgebra::{Matrix3, SMatrix, Vector3};
use wire::WindSample;

use super::super::added_uncertainty::add_uncertainty;
use super::correction::FieldCorrection;
use super::smoother::ERRORS;

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
