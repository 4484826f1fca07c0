//! Convection that the readings of a sphere determine, other forms have it from an option: at which
//! temperature properties are taken, whether Nu at rest, the rise of the warmed gas and a map of
//! the stem are fitted, and whether quiescent gas contradicts the winds.
//!
//! Each is added if the cost falls by more than chance and the misfit of the model explain:
//!
//! ```text
//! (cost − cost_with) / k > F max(1, cost_with / ν)
//! ```
//!
//! for k numbers more, with ν the degrees of freedom.

use super::super::steady_wind::{CalibrateError, SteadyWind};
use super::readings::{self, DrawnSurfaces, is_behind};
use super::solve::solve;
use super::sought::{Gravity, SoughtConvection};

use crate::head::calibration::PropertyTemperature;

/// Temperatures of quiescent gas that differ by less say nothing of properties and rest, K.
const LEAST_RANGE_K: f64 = 15.0;
/// F of the rise and of a stem map, and how many numbers each counts for.
const RISE: (f64, f64) = (15.0, 2.0);
const STEM: (f64, f64) = (10.0, 8.0);
/// Winds near the stem that a map takes.
const LEAST_BEHIND: usize = 6;
/// Standard uncertainties by which quiescent gas contradicts winds, rms.
const CONTRADICTS: f64 = 8.0;

/// Knowledge of a head's convection beside its readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConvectionOptions {
    /// At which share of the way from the gas to the surfaces properties are taken, if it is known.
    pub film_share: Option<f64>,
    /// Gravity in the tunnel.
    pub gravity: Gravity,
    /// Outward along the stem.
    pub stem: [f64; 3],
}

/// The convection that the readings determine.
///
/// # Errors
/// If a reading cannot be meant.
pub fn chosen(
    head: &DrawnSurfaces,
    steady: &[SteadyWind],
    options: &ConvectionOptions,
) -> Result<SoughtConvection, CalibrateError> {
    let ready = readings::ready(head)?;
    if !ready.form().is_sphere() {
        let film_share = options.film_share.unwrap_or(0.0);
        return Ok(SoughtConvection { film_share, ..SoughtConvection::default() });
    }
    let winds = readings::winds(&ready, steady)?;
    let still = winds.iter().filter(|wind| wind.is_quiescent());
    let is_rest_sought = range(still.map(|wind| wind.gas_k)) > LEAST_RANGE_K;
    let film_share = PropertyTemperature::Film.film_share();
    let shares = match options.film_share {
        Some(share) => vec![share],
        None if is_rest_sought => vec![film_share, 0.0],
        None => vec![film_share],
    };
    let mut best: Option<Candidate<'_>> = None;
    for film_share in shares {
        let convection = SoughtConvection { film_share, is_rest_sought, ..SoughtConvection::default() };
        let found = Candidate::of(head, steady, convection);
        if best.as_ref().is_none_or(|best| found.cost < best.cost) {
            best = Some(found);
        }
    }
    let Some(mut best) = best else { return Err(CalibrateError::NoMinimum) };
    if !ready.is_complete() {
        return Ok(best.convection);
    }
    let rise = (options.gravity.m_s2 > 0.0).then_some(options.gravity);
    best.consider(RISE, |sought| sought.rise = rise);
    if winds.iter().filter(|wind| is_behind(wind, options.stem)).count() >= LEAST_BEHIND {
        best.consider(STEM, |sought| sought.stem = Some(options.stem));
    }
    let rows = winds.iter().filter(|wind| wind.is_quiescent()).map(|wind| wind.rows.len()).sum::<usize>();
    if rows > 0 && rows < winds.len() * head.surfaces.len() {
        best.consider((CONTRADICTS * CONTRADICTS, rows as f64), |sought| {
            (sought.is_without_quiescent, sought.is_rest_sought) = (true, false);
        });
        if best.convection.is_without_quiescent {
            best.consider(RISE, |sought| sought.rise = rise);
        }
    }
    Ok(best.convection)
}

/// A convection, and how well the readings follow it.
struct Candidate<'a> {
    head: &'a DrawnSurfaces,
    steady: &'a [SteadyWind],
    convection: SoughtConvection,
    cost: f64,
    /// Square of what a reading misses, by noise and model, in its own variances.
    spread: f64,
}

impl<'a> Candidate<'a> {
    /// A convection that the readings do not follow has no finite cost: something more may explain
    /// it.
    fn of(head: &'a DrawnSurfaces, steady: &'a [SteadyWind], convection: SoughtConvection) -> Self {
        let (cost, spread) = match solve(&DrawnSurfaces { convection: convection.clone(), ..head.clone() }, steady) {
            Ok(found) => (found.cost, (found.cost / found.degrees_of_freedom.max(1.0)).max(1.0)),
            Err(_) => (f64::INFINITY, 1.0),
        };
        Self { head, steady, convection, cost, spread }
    }

    /// Takes another one that falls by F for so many numbers.
    fn consider(&mut self, (least, numbers): (f64, f64), change: impl Fn(&mut SoughtConvection)) {
        let mut with = self.convection.clone();
        change(&mut with);
        let there = Self::of(self.head, self.steady, with);
        if there.cost.is_finite() && (self.cost - there.cost) / numbers > least * there.spread {
            *self = there;
        }
    }
}

fn range(values: impl Iterator<Item = f64> + Clone) -> f64 {
    values.clone().fold(f64::NEG_INFINITY, f64::max) - values.fold(f64::INFINITY, f64::min)
}
