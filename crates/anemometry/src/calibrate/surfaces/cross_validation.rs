//! Errors of a calibration in winds that it has not seen, through dr-core's f32 inverse, as on the
//! board.
//!
//! | error | of a head that determines all | of a cylinder, of wires | of two hemispheres | of a single element |
//! |---|---|---|---|---|
//! | direction | angle between estimate and wind | the same, in the plane | difference of the angles to the axis | none |
//! | speed | (estimate − wind) / wind | the same, of the wind in the plane | the same, of the whole speed | the same |
//!
//! Folds of a cross-validation: winds that are left out together.
//!
//! A wind that is left out while its neighbour stays would be known from it. So neighbours go
//! together, in two ways that ask two questions:
//!
//! | scheme | left out together | question |
//! |---|---|---|
//! | directions | all winds, of whatever speed, from one region of directions: those nearest to one of K of them that lie far apart | does it know directions that it has not seen? |
//! | speeds | all winds, from wherever, of a band of neighbouring speeds; the slowest and the fastest always stay, for beyond them nothing is claimed | does it know speeds that it has not seen? |
//!
//! For a single element, which has no directions, every n-th wind in the order of speeds is left
//! out. Still gas always stays. Every fold is fitted from nothing.

use dr_core::wind::{ConvectionSettings, HeadForm, MeasuredConductance, QualityFlags, WindEstimate, WindState};

use super::super::cross_validation::{ComparedWind, CrossValidation, Scheme, StatedError};
use super::super::steady_wind::{CalibrateError, SteadyWind};
use super::calibration::{BoardHead, SurfaceCalibration};
use super::readings::{self, CheckedWind, DrawnSurfaces, ascending, classes, distinct};
use super::solve::solve;

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
    head: &DrawnSurfaces,
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
/// If the calibration makes no head.
pub fn compare(calibration: &SurfaceCalibration, steady: &SteadyWind) -> Result<Option<ComparedWind>, CalibrateError> {
    let (estimate, measured) = estimate(calibration, steady)?;
    let wind_m_s = seen(calibration, steady.wind_m_s);
    let speed_m_s = length(wind_m_s);
    if estimate.quality.has(QualityFlags::FAILED) || speed_m_s == 0.0 {
        return Ok(None);
    }
    let gas = steady.core_gas(calibration.film_share())?;
    let reynolds = speed_m_s * f64::from(gas.reynolds_per_speed(calibration.diameter_m as f32));
    let [least, most] = calibration.reynolds();
    let is_extrapolated = !(least..=most).contains(&reynolds);
    Ok(Some(ComparedWind {
        reynolds,
        direction_deg: direction_deg(calibration, &estimate, wind_m_s),
        speed: f64::from(estimate.speed_m_s) / speed_m_s - 1.0,
        stated: StatedError::of(&estimate, &measured, is_extrapolated),
    }))
}

/// Part of a wind that the head sees.
fn seen(calibration: &SurfaceCalibration, wind_m_s: [f64; 3]) -> [f64; 3] {
    match calibration.form {
        HeadForm::Cylinder | HeadForm::Wires => {
            across(wind_m_s, unit(calibration.surfaces[0].config.corner.map(f64::from)))
        }
        HeadForm::Sphere | HeadForm::Cube | HeadForm::Single => wind_m_s,
    }
}

/// Estimate that the board makes of a reading, and the conductances from which it does.
fn estimate(
    calibration: &SurfaceCalibration,
    steady: &SteadyWind,
) -> Result<(WindEstimate, Vec<Option<MeasuredConductance>>), CalibrateError> {
    let BoardHead { vector, convection } = calibration.of_board(DIRECTION_ERROR_MAX_RAD)?;
    let measured: Vec<Option<MeasuredConductance>> =
        steady.surfaces.iter().enumerate().map(|(i, reading)| Some(calibration.measured(i, reading))).collect();
    let mut estimate = vector.step(&mut WindState::default(), &steady.core_gas(calibration.film_share())?, &measured);
    if let Some(ConvectionSettings { free_stream, .. }) = convection {
        let (overheat_k, gas_k) = (steady.overheat_k() as f32, steady.gas.temperature_k as f32);
        let rise_speed_m_s = free_stream.rise_speed_m_s(overheat_k, gas_k, calibration.diameter_m as f32);
        estimate = free_stream.described(estimate, rise_speed_m_s, DIRECTION_ERROR_MAX_RAD);
    }
    Ok((estimate, measured))
}

fn direction_deg(calibration: &SurfaceCalibration, estimate: &WindEstimate, wind_m_s: [f64; 3]) -> Option<f64> {
    let found = estimate.wind_m_s.map(f64::from);
    match calibration.form {
        HeadForm::Single => return None,
        HeadForm::Cylinder | HeadForm::Wires => return Some(angle_deg(found, wind_m_s)),
        HeadForm::Sphere | HeadForm::Cube if !estimate.quality.has(QualityFlags::UNDETERMINED) => {
            return Some(angle_deg(found, wind_m_s));
        }
        HeadForm::Sphere | HeadForm::Cube => {}
    }
    // From sine and cosine, so that small angles keep their digits.
    let axis = unit(calibration.surfaces[0].axis);
    let to_axis = |v: [f64; 3], across_m_s: f64| libm::atan2(across_m_s, dot(v, axis));
    let truth = to_axis(wind_m_s, length(across(wind_m_s, axis)));
    Some((to_axis(found, f64::from(estimate.across_m_s)) - truth).to_degrees())
}

/// Places of the winds, as given, that are left out together: at most `count` folds, none empty.
pub fn folds(winds: &[CheckedWind], scheme: Scheme, count: usize) -> Vec<Vec<usize>> {
    let moving = ascending(winds);
    let mut folds = match scheme {
        Scheme::Directions => directions(&moving, count),
        Scheme::Speeds => speeds(&moving, count),
        Scheme::EveryNth => {
            let nth = |n: usize| moving.iter().skip(n).step_by(count).map(|wind| wind.given).collect();
            (0..count).map(nth).collect()
        }
    };
    folds.retain(|fold| !fold.is_empty());
    folds
}

fn directions(moving: &[&CheckedWind], count: usize) -> Vec<Vec<usize>> {
    let cosine = |a: &CheckedWind, b: &CheckedWind| (0..3).map(|k| a.towards[k] * b.towards[k]).sum::<f64>();
    let nearness =
        |wind: &CheckedWind, seeds: &[&CheckedWind]| seeds.iter().map(|seed| cosine(wind, seed)).fold(-1.0, f64::max);
    let mut seeds: Vec<&CheckedWind> = moving.iter().take(1).copied().collect();
    while seeds.len() < count {
        // The one farthest from all of them.
        match moving.iter().min_by(|a, b| nearness(a, &seeds).total_cmp(&nearness(b, &seeds))) {
            Some(next) if nearness(next, &seeds) < 1.0 - 1e-6 => seeds.push(next),
            _ => break,
        }
    }
    let mut folds = vec![Vec::new(); seeds.len()];
    for wind in moving {
        let nearest = (0..seeds.len()).max_by(|&a, &b| cosine(wind, seeds[a]).total_cmp(&cosine(wind, seeds[b])));
        if let Some(nearest) = nearest {
            folds[nearest].push(wind.given);
        }
    }
    folds
}

fn speeds(moving: &[&CheckedWind], count: usize) -> Vec<Vec<usize>> {
    let groups = distinct(moving);
    let inner = groups.get(1..groups.len().saturating_sub(1)).unwrap_or_default();
    let count = count.min(inner.len());
    let mut folds = vec![Vec::new(); count];
    for (j, group) in inner.iter().enumerate() {
        folds[j * count / inner.len()].extend(group.iter().map(|wind| wind.given));
    }
    folds
}
