//! Calibration of a head in steps: check, spread of the winds, fit, check of the result.

use super::super::error::CalibrateError;
use super::super::steady_wind::SteadyWind;
use super::calibration::SurfaceCalibration;
use super::equations::SurfaceProblem;
use super::family::AmplitudeFamily;
use super::grade::CalibrationGrade;
use super::readings::{self, CheckedWind, DrawnSurfaces, LossLaw, SurfaceGeometry};
use super::stream::met_m_s;
use super::{fit, king, speeds, spread};
use crate::vector::length;

/// Of the convective power, rms. Two parts in each other's place leave 24 %; no stem takes as much
/// as this.
const MOST_RESIDUAL_RMS: f64 = 0.1;

/// Of the slowest stream that the rise leaves of a wind: it is known only afterwards.
const SLOWER: f64 = 0.7;

/// Calibrates a head.
///
/// # Errors
/// If a reading cannot be meant, if the winds do not determine what is sought, or if what fits best
/// makes no head.
pub fn calibrate(head: &DrawnSurfaces, steady: &[SteadyWind]) -> Result<SurfaceCalibration, CalibrateError> {
    let ready = readings::ready(head)?;
    let winds = readings::winds(&ready, steady)?;
    let lacking = spread::lacking(&ready, &winds);
    if !lacking.is_empty() {
        return Err(CalibrateError::Spread(lacking));
    }
    let mirrored = spread::mirrored(&ready, &speeds::ascending(&winds));
    if !mirrored.is_empty() {
        return Err(CalibrateError::Mirrored { labels: mirrored });
    }
    solve(head, steady)
}

/// Calibrates a head without a check of the spread of the winds.
///
/// # Errors
/// As [`calibrate`].
pub fn solve(head: &DrawnSurfaces, steady: &[SteadyWind]) -> Result<SurfaceCalibration, CalibrateError> {
    let ready = readings::ready(head)?;
    let mut winds = readings::winds(&ready, steady)?;
    if head.convection.is_without_quiescent {
        winds.retain(|wind| !wind.is_quiescent());
    }
    let moving = speeds::ascending(&winds);
    let (Some(first), Some(last)) = (moving.first(), moving.last()) else {
        return Err(CalibrateError::Spread(vec!["all readings are of quiescent gas: winds are missing".into()]));
    };
    if first.reynolds >= last.reynolds {
        return Err(CalibrateError::Spread(vec!["all winds have one speed".into()]));
    }
    // The middle of every speed, but the first and last wind themselves.
    let mut reynolds: Vec<f64> = speeds::distinct(&moving)
        .iter()
        .map(|group| (group.iter().map(|wind| wind.reynolds.ln()).sum::<f64>() / group.len() as f64).exp())
        .collect();
    reynolds.dedup();
    if let [only] = reynolds[..] {
        reynolds.push(only);
    }
    let end = reynolds.len() - 1;
    (reynolds[0], reynolds[end]) = (first.reynolds, last.reynolds);
    if head.convection.rise.is_some() {
        // The rise alone is a slow stream, too, and takes from a slow wind that sinks.
        let stream = head.convection.free_stream(&head.convection.start()).unwrap_or_default();
        let slow = winds.iter().map(|wind| wind.reynolds_per_speed * length(met_m_s(&stream, wind)));
        let slowest = SLOWER * slow.fold(f64::INFINITY, f64::min);
        if slowest < reynolds[0] && slowest > 0.0 {
            reynolds.insert(0, slowest);
        }
    }

    let orders = ready.orders.iter().copied().take(spread::angles_apart(&ready, &moving)).collect();
    let mut family = AmplitudeFamily::new(head.form, &reynolds, orders, moving.len() * head.surfaces.len());
    family.is_rest_sought = head.convection.is_rest_sought;
    let mut calibration = by_law(head.law, &ready, &winds, &family)?;
    if calibration.grade() == CalibrationGrade::Poor {
        // What the model cannot follow is no reason to bend it from wind to wind: readings that
        // count for no more than the model is true leave it smooth.
        let coarse = by_law(head.law, &ready, &coarser(&winds, calibration.misfit_rms), &family)?;
        let SurfaceCalibration { chi_square, reading_rms, misfit_rms, .. } = calibration;
        calibration = SurfaceCalibration { chi_square, reading_rms, misfit_rms, ..coarse };
    }
    if calibration.residual_rms > MOST_RESIDUAL_RMS {
        let SurfaceCalibration { residual_rms, worst, .. } = calibration;
        return Err(CalibrateError::Unexplained { residual_rms, worst });
    }
    let mut curves = dr_core::wind::Nusselt::new(head.form, &calibration.curves.config())?;
    if let Some(convection) = &calibration.convection {
        curves.rest_at(convection.nusselt_at_rest as f32)?;
    }
    Ok(calibration)
}

fn by_law(
    law: LossLaw,
    ready: &SurfaceGeometry<'_>,
    winds: &[CheckedWind],
    family: &AmplitudeFamily,
) -> Result<SurfaceCalibration, CalibrateError> {
    Ok(match law {
        LossLaw::Spline => {
            let problem = SurfaceProblem::new(ready, winds, family.clone());
            SurfaceCalibration::of(&problem, &fit::fit(&problem)?, None)
        }
        LossLaw::King { exponent } => {
            let (problem, fitted, law) = king::king(ready, winds, family, exponent)?;
            SurfaceCalibration::of(&problem, &fitted, Some(law))
        }
    })
}

/// Winds whose readings are uncertain by a share of their power, too.
fn coarser(winds: &[CheckedWind], share: f64) -> Vec<CheckedWind> {
    let mut winds = winds.to_vec();
    for of in winds.iter_mut().filter(|wind| !wind.is_quiescent()).flat_map(|wind| &mut wind.rows) {
        of.reading.variance_w2 += (share * of.reading.power_w).powi(2);
    }
    winds
}
