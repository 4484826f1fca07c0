//! How well a calibration answers winds that it has not seen: through dr-core's f32 inverse, as the board will.
//!
//! | error | of a head that tells all | of two hemispheres |
//! |---|---|---|
//! | direction | angle between answer and wind | difference of the angles to the axis |
//! | speed | (answer − wind) / wind | the same, of the whole speed |

use dr_core::sensor::wind::{Measured, Wind as Answer, WindState};

use super::calibration::Calibration;
use super::folds::{Scheme, folds};
use super::run::{self, Head, Steady};
use super::speeds::{Range, ascending, classes};
use super::{CalibrateError, solve};

/// Only a direction that is uncertain by more is none.
const DIRECTION_ERROR_MAX_RAD: f32 = 1.0;

/// One wind, known and answered.
#[derive(Debug, Clone, PartialEq)]
pub struct Error {
    pub label: String,
    pub speed_m_s: f64,
    pub reynolds: f64,
    pub direction_deg: f64,
    /// Relative.
    pub speed: f64,
    /// χ² of the readings at the answer, over its degrees of freedom; zero where there are none.
    pub chi_square: f64,
}

/// Winds that were held out.
#[derive(Debug, Clone, PartialEq)]
pub struct HeldOut {
    pub scheme: Scheme,
    pub folds: usize,
    pub errors: Vec<Error>,
    /// Labels of winds for which there was no answer.
    pub failed: Vec<String>,
    /// Classes of speed, an octave each at most.
    classes: Vec<Range>,
}

/// Errors of a class of speeds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Summary {
    pub winds: usize,
    pub direction_rms_deg: f64,
    pub direction_worst_deg: f64,
    pub speed_rms: f64,
    pub speed_worst: f64,
}

impl Summary {
    pub fn of<'a>(errors: impl Iterator<Item = &'a Error> + Clone) -> Self {
        let winds = errors.clone().count();
        let rms =
            |of: fn(&Error) -> f64| (errors.clone().map(|e| of(e).powi(2)).sum::<f64>() / winds.max(1) as f64).sqrt();
        let worst = |of: fn(&Error) -> f64| errors.clone().map(|e| of(e).abs()).fold(0.0, f64::max);
        Self {
            winds,
            direction_rms_deg: rms(|e| e.direction_deg),
            direction_worst_deg: worst(|e| e.direction_deg),
            speed_rms: rms(|e| e.speed),
            speed_worst: worst(|e| e.speed),
        }
    }
}

impl HeldOut {
    pub fn overall(&self) -> Summary {
        Summary::of(self.errors.iter())
    }

    pub fn by_class(&self) -> Vec<(Range, Summary)> {
        let own = |class: &Range| Summary::of(self.errors.iter().filter(|e| class.holds(e.reynolds)));
        self.classes.iter().map(|class| (*class, own(class))).filter(|(_, summary)| summary.winds > 0).collect()
    }
}

/// Fits every fold anew and asks it for what it has not seen.
///
/// # Errors
/// As those of [`calibrate`](super::calibrate), except that a fold's winds need not be well spread.
pub fn held_out(head: &Head, steady: &[Steady], scheme: Scheme, count: usize) -> Result<HeldOut, CalibrateError> {
    let ready = run::ready(head)?;
    let winds = run::winds(&ready, steady)?;
    let folds = folds(&winds, scheme, count);
    let moving = ascending(&winds);
    let classes = if moving.is_empty() { Vec::new() } else { classes(&moving, 1.0) };
    let mut result = HeldOut { scheme, folds: folds.len(), errors: Vec::new(), failed: Vec::new(), classes };
    for fold in folds {
        let (out, stay): (Vec<_>, Vec<_>) = steady.iter().enumerate().partition(|(at, _)| fold.contains(at));
        let stay: Vec<Steady> = stay.into_iter().map(|(_, steady)| steady.clone()).collect();
        let calibration = solve(head, &stay)?;
        for (_, steady) in out {
            match error(&calibration, steady)? {
                Some(error) => result.errors.push(error),
                None => result.failed.push(steady.label.clone()),
            }
        }
    }
    Ok(result)
}

/// What a calibration says of a known wind; nothing where it has no answer.
///
/// # Errors
/// If the calibration makes no head, or the head has another number of parts than 2, 3 or 4.
pub fn error(calibration: &Calibration, steady: &Steady) -> Result<Option<Error>, CalibrateError> {
    let answer = match calibration.parts.len() {
        2 => answer::<2>(calibration, steady),
        3 => answer::<3>(calibration, steady),
        4 => answer::<4>(calibration, steady),
        n => Err(CalibrateError::Head(format!("{n} parts are more than the inverse has been tried with: 2, 3 or 4"))),
    }?;
    let speed_m_s = steady.wind_m_s.iter().map(|v| v * v).sum::<f64>().sqrt();
    if answer.quality.failed || speed_m_s == 0.0 {
        return Ok(None);
    }
    let gas = gas(steady)?;
    Ok(Some(Error {
        label: steady.label.clone(),
        speed_m_s,
        reynolds: speed_m_s * f64::from(gas.reynolds_per_speed(calibration.diameter_m as f32)),
        direction_deg: direction_deg(calibration, &answer, steady.wind_m_s),
        speed: f64::from(answer.speed_m_s) / speed_m_s - 1.0,
        chi_square: match answer.degrees_of_freedom {
            0 => 0.0,
            n => f64::from(answer.chi_square) / f64::from(n),
        },
    }))
}

fn gas(steady: &Steady) -> Result<dr_core::sensor::wind::Gas, CalibrateError> {
    steady
        .gas
        .core()
        .map_err(|error| CalibrateError::Reading { label: steady.label.clone(), sentence: format!("gas: {error}") })
}

fn answer<const N: usize>(calibration: &Calibration, steady: &Steady) -> Result<Answer, CalibrateError> {
    let head = calibration.head::<N>(DIRECTION_ERROR_MAX_RAD)?;
    let measured: [Option<Measured>; N] =
        std::array::from_fn(|i| steady.parts.get(i).map(|reading| calibration.measured(i, reading)));
    Ok(head.step(&mut WindState::default(), &gas(steady)?, &measured))
}

fn direction_deg(calibration: &Calibration, answer: &Answer, wind_m_s: [f64; 3]) -> f64 {
    let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| a[k] * b[k]).sum::<f64>();
    let found = answer.wind_m_s.map(f64::from);
    // From sine and cosine, so that small angles keep their digits.
    let to_axis = |v: [f64; 3], across: f64, axis: [f64; 3]| across.atan2(dot(v, axis));
    let size = |v: [f64; 3]| dot(v, v).sqrt();
    if answer.quality.undetermined {
        let axis = calibration.parts[0].axis.map(|x| x / size(calibration.parts[0].axis));
        let along = dot(wind_m_s, axis);
        let across = size(std::array::from_fn(|k| wind_m_s[k] - along * axis[k]));
        return (to_axis(found, f64::from(answer.across_m_s), axis) - to_axis(wind_m_s, across, axis)).to_degrees();
    }
    let [a, b] = [found, wind_m_s];
    let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    size(cross).atan2(dot(a, b)).to_degrees()
}
