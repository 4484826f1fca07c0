//! Calibration of a head in steps: check, spread of the winds, fit, check of the result.
//!
//! King's law: the exponent, and of wires the yaw factor, for which it fits best.
//!
//! ```text
//! G = A + B U^m        (L. V. King, Phil. Trans. R. Soc. A 214 (1914) 373)
//! U² = v² (cos² φ + k² sin² φ)        of a wire at the angle φ between the wind and its normal
//! ```
//!
//! m and κ = k² are unknowns of [`fit`] beside A, B, gains and mounting, with standard
//! uncertainties as theirs. dr-core has six cosines for the law of a wire, fitted to it at the
//! winds' own angles; A, B, gains and mounting are then those that fit the readings best by these.
//! Where k is small the law has a kink at 90°, which six cosines do not follow: the misfit says by
//! how much. (Fitted by cosines in the first place, a k of 0.1 would come out as 0.116, and of 0 an
//! exponent a fifth too small.)

use dr_core::wind::HeadForm;
use dr_core::wind::nusselt::ORDERS;
use nalgebra::{DMatrix, DVector};

use super::super::steady_wind::{CalibrateError, SteadyWind};
use super::calibration::SurfaceCalibration;
use super::equations::{FitPoint, LawUnknown, SoughtLaw, SurfaceProblem};
use super::family::{AmplitudeFamily, AmplitudeShape};
use super::fit::{self, CalibrationGrade, FittedKing, SurfaceFit};
use super::readings::{self, CheckedWind, DrawnSurfaces, LossLaw, SurfaceGeometry, ascending, distinct, met_m_s};
use super::spread;
use super::spread::all_angles;

use crate::vector::length;

/// Share of the convective power, rms. Two parts in each other's place leave 24 %; no stem takes as
/// much as this.
const MOST_RESIDUAL_RMS: f64 = 0.1;

/// Share of the slowest stream that the rise leaves of a wind: it is known only afterwards.
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
    let mirrored = spread::mirrored(&ready, &ascending(&winds));
    if !mirrored.is_empty() {
        return Err(CalibrateError::Mirrored(mirrored));
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
    let moving = ascending(&winds);
    let (Some(first), Some(last)) = (moving.first(), moving.last()) else {
        return Err(CalibrateError::Spread(vec!["all readings are of quiescent gas: winds are missing".into()]));
    };
    if first.reynolds >= last.reynolds {
        return Err(CalibrateError::Spread(vec!["all winds have one speed".into()]));
    }
    // The middle of every speed, but the first and last wind themselves.
    let mut reynolds: Vec<f64> = distinct(&moving)
        .iter()
        .map(|group| libm::exp(group.iter().map(|wind| libm::log(wind.reynolds)).sum::<f64>() / group.len() as f64))
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
        // A wind that the model cannot follow is no reason to bend it from wind to wind: readings
        // that count for no more than the model is true leave it smooth.
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
            let (problem, fitted, law) = king(ready, winds, family, exponent)?;
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

/// k at which the search begins.
const YAW_FACTOR: f64 = 0.3;
/// Angles from 0° to 90° at which cosines are held to the law besides those of the winds.
const ANGLES: usize = 90;
/// Weight of these together beside the winds'.
const HELD: f64 = 1e-2;

/// The problem of the winds with King's law; its exponent as `given`, or where it fits best.
///
/// # Errors
/// If no exponent gives a fit.
pub fn king<'a>(
    head: &'a SurfaceGeometry<'a>,
    winds: &'a [CheckedWind],
    family: &AmplitudeFamily,
    given: Option<f64>,
) -> Result<(SurfaceProblem<'a>, SurfaceFit, FittedKing), CalibrateError> {
    let by = |shape| SurfaceProblem::new(head, winds, AmplitudeFamily { shape, ..family.clone() });
    let has_angles = head.form() == HeadForm::Wires;
    let mut problem = by(AmplitudeShape::Law);
    problem.sought.extend(given.is_none().then_some(LawUnknown::Exponent));
    problem.sought.extend(has_angles.then_some(LawUnknown::YawSquare));
    let law = SoughtLaw {
        exponent: given.unwrap_or(0.5),
        yaw_square: if has_angles { YAW_FACTOR * YAW_FACTOR } else { 1.0 },
    };
    // About what published cylinders and wires have, so that exponent and yaw factor matter.
    let coefficients = vec![0.0, 0.6 * family.most_reynolds.sqrt()];
    let fitted = fit::fit_from(&problem, FitPoint { coefficients, law, ..problem.drawn() })?;
    let law = fitted.place.law;
    let error = |unknown| {
        let at = problem.sought.iter().position(|of| *of == unknown)?;
        let at = problem.first_of_law(&fitted.place) + at;
        Some(fitted.covariance[(at, at)].sqrt())
    };
    let found = FittedKing {
        exponent: law.exponent,
        se_exponent: error(LawUnknown::Exponent).unwrap_or(0.0),
        yaw_factor: has_angles.then_some(law.yaw_square.sqrt()),
        se_yaw_factor: error(LawUnknown::YawSquare).map(|error| yaw_error(law.yaw_square, error)),
    };
    let shares = match has_angles {
        true => shares(&law, &all_angles(head, &ascending(winds))).ok_or(CalibrateError::NoMinimum)?,
        false => std::array::from_fn(|n| if n == 0 { 1.0 } else { 0.0 }),
    };
    let best = by(AmplitudeShape::King { exponent: law.exponent, shares });
    let fitted = fit::fit(&best)?;
    Ok((best, fitted, found))
}

/// Standard uncertainty of k by that of its square: half of what k changes by as the square changes
/// by its own up and down, which also holds where k is not known to be more than 0.
fn yaw_error(yaw_square: f64, error: f64) -> f64 {
    0.5 * ((yaw_square + error).sqrt() - (yaw_square - error).max(0.0).sqrt())
}

/// F_n: the cosine series in 2φ that is nearest to (cos² φ + k² sin² φ)^(m/2) at these angles,
/// degrees; elsewhere it is held to the law by a little weight.
fn shares(law: &SoughtLaw, angles_deg: &[f64]) -> Option<[f64; ORDERS]> {
    let everywhere = (0..ANGLES).map(|j| (90.0 * (j as f64 + 0.5) / ANGLES as f64, HELD / ANGLES as f64));
    let of_winds = angles_deg.iter().map(|&angle| (angle, 1.0 / angles_deg.len() as f64));
    let (mut h, mut b) = (DMatrix::zeros(ORDERS, ORDERS), DVector::zeros(ORDERS));
    for (degrees, weight) in everywhere.chain(of_winds) {
        let angle = degrees.to_radians();
        let cosines = DVector::from_fn(ORDERS, |n, _| libm::cos(2.0 * n as f64 * angle));
        b += weight * law.seen(libm::cos(angle)) * &cosines;
        h += weight * &cosines * cosines.transpose();
    }
    let found = h.cholesky()?.solve(&b);
    Some(std::array::from_fn(|n| found[n]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_series_of_a_wire_is_its_law_at_the_angles_of_the_winds() {
        let off = |yaw_factor: f64, most_deg: u32| {
            let law = SoughtLaw { exponent: 0.45, yaw_square: yaw_factor * yaw_factor };
            let angles: Vec<f64> = (0..=most_deg).map(f64::from).collect();
            let shares = shares(&law, &angles).unwrap();
            let error = |degrees: &f64| {
                let angle = degrees.to_radians();
                let series: f64 =
                    shares.iter().enumerate().map(|(n, share)| share * libm::cos(2.0 * n as f64 * angle)).sum();
                (series / law.seen(libm::cos(angle)) - 1.0).abs()
            };
            angles.iter().map(error).fold(0.0, f64::max)
        };
        assert!(off(0.3, 90) < 0.02 && off(0.3, 75) < 2e-3, "{} {}", off(0.3, 90), off(0.3, 75));
        // A wire of no yaw has a kink.
        assert!(off(0.0, 75) < 0.01 && off(0.1, 90) > 0.02, "{} {}", off(0.0, 75), off(0.1, 90));
    }

    #[test]
    fn a_yaw_factor_that_is_not_known_to_be_more_than_zero_has_an_error() {
        assert!((yaw_error(0.04, 4e-4) - 1e-3).abs() < 1e-5);
        assert!((yaw_error(0.0, 4e-4) - 0.01).abs() < 1e-12);
    }
}
