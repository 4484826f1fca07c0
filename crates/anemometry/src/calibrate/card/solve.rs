//! Calibration of a card in steps: check, spread of the winds, curves, check of the result; and its
//! cross-validation.

use dr_core::wind::card_inverse::{DICE, KNOTS};

use super::super::cross_validation::{CrossValidation, Scheme};
use super::super::error::CalibrateError;
use super::super::steady_wind::SteadyWind;
use super::calibration::CardCalibration;
use super::differences::differences;
use super::drawn::{CardWind, DrawnCard, PLACES, winds};
use super::mean::mean;
use super::spread::{ends, lacking};
use crate::head::calibration::table::CardTable;

/// Calibrates a card.
///
/// # Errors
/// If a reading cannot be meant, if the winds do not determine what is sought, or if what fits best
/// makes no card.
pub fn calibrate(drawn: &DrawnCard, steady: &[SteadyWind]) -> Result<CardCalibration, CalibrateError> {
    let lacking = lacking(&winds(drawn, steady)?);
    if lacking.is_empty() { solve(drawn, steady) } else { Err(CalibrateError::Spread(lacking)) }
}

/// Fits all but every `count`-th wind, from each of the first `count` on, and compares the winds
/// that were left out.
///
/// # Errors
/// As those of [`calibrate`].
pub fn cross_validate(
    drawn: &DrawnCard,
    steady: &[SteadyWind],
    count: usize,
) -> Result<CrossValidation, CalibrateError> {
    let moving = |at: &usize| steady[*at].wind_m_s != [0.0; 3];
    let folds: Vec<Vec<usize>> =
        (0..count).map(|fold| (fold..steady.len()).step_by(count).filter(moving).collect()).collect();
    let fit = |stay: &[SteadyWind]| solve(drawn, stay);
    CrossValidation::new((Scheme::EveryNth, &folds, Vec::new()), steady, fit, CardCalibration::compare)
}

/// Calibrates a card without a check of the spread of the winds.
fn solve(drawn: &DrawnCard, steady: &[SteadyWind]) -> Result<CardCalibration, CalibrateError> {
    let winds = winds(drawn, steady)?;
    let (least_reynolds, most_reynolds) = ends(&winds);
    let differences = differences(&winds).ok_or(CalibrateError::NoMinimum)?;
    let mean = mean(&winds, most_reynolds.sqrt()).ok_or(CalibrateError::NoMinimum)?;
    let squares = |of: &dyn Fn(&CardWind) -> f64| winds.iter().map(of).sum::<f64>();
    let twist = squares(&|wind| wind.twist * wind.mean) / squares(&|wind| wind.mean * wind.mean);
    let [along, around] = differences.unlike;
    let gains = PLACES.map(|[p, q]| 1.0 / (1.0 + along * p + around * q + twist * p * q));
    let usual = gains.iter().sum::<f64>() / DICE as f64;
    let root = |k: usize| most_reynolds.sqrt() * k as f64 / (KNOTS - 1) as f64;
    // Still gas counts at the reference, where the network holds it.
    let conductivity_w_m_k = steady.first().map_or(0.0, |steady| steady.gas.conductivity_w_m_k);
    let calibration = CardCalibration {
        curves: CardTable {
            least_reynolds,
            most_reynolds,
            mean: mean.knots,
            difference: std::array::from_fn(|k| root(k).powf(2.0 * differences.exponent)),
            along: differences.along,
            around: differences.around,
            seen: mean.seen,
            mean_share: mean.share,
            difference_share: differences.share,
        },
        exponent: differences.exponent,
        gains: gains.map(|gain| gain / usual),
        quiescent_w_k: drawn.quiescent_w_k(conductivity_w_m_k),
        winds: winds.len(),
        drawn: drawn.clone(),
    };
    calibration.card()?;
    Ok(calibration)
}
