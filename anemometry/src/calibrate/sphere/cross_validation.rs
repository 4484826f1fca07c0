//! Errors of a calibration in winds that it has not seen, through dr-core's f32 inverse, as on the
//! board.
//!
//! | error | of a head that determines all | of two hemispheres |
//! |---|---|---|
//! | direction | angle between estimate and wind | difference of the angles to the axis |
//! | speed | (estimate − wind) / wind | the same, of the whole speed |

use dr_core::wind::{MeasuredConductance, QualityFlags, SurfaceConfig, WindEstimate, WindState, WindVector};

use super::super::compared::ComparedWind;
use super::super::cross_validation::{CrossValidation, Scheme};
use super::super::error::CalibrateError;
use super::super::steady_wind::SteadyWind;
use super::calibration::SphereCalibration;
use super::folds::folds;
use super::readings::{self, DrawnSphere};
use super::solve::solve;
use super::speeds::{ascending, classes};
use crate::vector::{across, angle_deg, dot, length, unit};

/// Only a direction that is uncertain by more is none.
const DIRECTION_ERROR_MAX_RAD: f32 = 1.0;

/// Fits every fold anew and compares the winds that it has not seen; `count` is the greatest number
/// of folds.
///
/// # Errors
/// As those of [`calibrate`](super::solve::calibrate), except that a fold's winds need not be well
/// spread.
pub fn cross_validate(
    head: &DrawnSphere,
    steady: &[SteadyWind],
    scheme: Scheme,
    count: usize,
) -> Result<CrossValidation, CalibrateError> {
    let ready = readings::ready(head)?;
    let winds = readings::winds(&ready, steady)?;
    let folds = folds(&winds, scheme, count);
    let moving = ascending(&winds);
    let classes = if moving.is_empty() { Vec::new() } else { classes(&moving, 1.0) };
    CrossValidation::new((scheme, &folds, classes), steady, |stay| solve(head, stay), compare)
}

/// Estimates a known wind; none where there is no estimate.
///
/// # Errors
/// If the calibration makes no head, or the head has another number of surfaces than 2, 3 or 4.
pub fn compare(calibration: &SphereCalibration, steady: &SteadyWind) -> Result<Option<ComparedWind>, CalibrateError> {
    let estimate = match calibration.surfaces.len() {
        2 => estimate::<2>(calibration, steady),
        3 => estimate::<3>(calibration, steady),
        4 => estimate::<4>(calibration, steady),
        n => {
            Err(CalibrateError::Head(format!("{n} surfaces are more than the inverse has been tried with: 2, 3 or 4")))
        }
    }?;
    let speed_m_s = length(steady.wind_m_s);
    if estimate.quality.has(QualityFlags::FAILED) || speed_m_s == 0.0 {
        return Ok(None);
    }
    let gas = steady.core_gas()?;
    Ok(Some(ComparedWind {
        reynolds: speed_m_s * f64::from(gas.reynolds_per_speed(calibration.diameter_m as f32)),
        direction_deg: direction_deg(calibration, &estimate, steady.wind_m_s),
        speed: f64::from(estimate.speed_m_s) / speed_m_s - 1.0,
    }))
}

/// What the board makes of a reading by a calibration of N surfaces.
fn estimate<const N: usize>(
    calibration: &SphereCalibration,
    steady: &SteadyWind,
) -> Result<WindEstimate, CalibrateError> {
    let surfaces: [SurfaceConfig; N] = std::array::from_fn(|i| calibration.surfaces[i].config);
    let (curves, diameter_m) = (calibration.curves.config(), calibration.diameter_m as f32);
    let head = WindVector::new(HeadForm::Sphere, &curves, &surfaces, diameter_m, DIRECTION_ERROR_MAX_RAD)?;
    let measured: [Option<MeasuredConductance>; N] =
        std::array::from_fn(|i| steady.surfaces.get(i).map(|reading| calibration.measured(i, reading)));
    Ok(head.step(&mut WindState::default(), &steady.core_gas()?, &measured))
}

fn direction_deg(calibration: &SphereCalibration, estimate: &WindEstimate, wind_m_s: [f64; 3]) -> f64 {
    let found = estimate.wind_m_s.map(f64::from);
    if !estimate.quality.has(QualityFlags::UNDETERMINED) {
        return angle_deg(found, wind_m_s);
    }
    // From sine and cosine, so that small angles keep their digits.
    let axis = unit(calibration.surfaces[0].axis);
    let to_axis = |v: [f64; 3], across_m_s: f64| across_m_s.atan2(dot(v, axis));
    let truth = to_axis(wind_m_s, length(across(wind_m_s, axis)));
    (to_axis(found, f64::from(estimate.across_m_s)) - truth).to_degrees()
}
