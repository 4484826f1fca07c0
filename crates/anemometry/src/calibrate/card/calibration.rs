//! A calibrated card, as text and as the inverse that the board runs; the steps to it: check, spread
//! of the winds, curves, check of the result; and its cross-validation.

use std::fmt;

use dr_core::wind::card_inverse::{Card, DICE, KNOTS, anisotropy};
use dr_core::wind::{MeasuredConductance, QualityFlags};

use super::super::cross_validation::{ComparedWind, CrossValidation, Scheme, StatedError};
use super::super::steady_wind::{CalibrateError, SteadyWind};
use super::curves::{differences, mean};
use super::drawn::{CardWind, DrawnCard, PLACES, ends, lacking, winds};

use crate::head::calibration::table::CardTable;
use crate::vector::{angle_deg, length};

/// Only a direction that is uncertain by more is none.
const DIRECTION_ERROR_MAX_RAD: f32 = 1.0;

/// A calibrated card.
#[derive(Debug, Clone, PartialEq)]
pub struct CardCalibration {
    /// The card as drawn.
    pub drawn: DrawnCard,
    /// Curves as a head file has them.
    pub curves: CardTable,
    /// n
    pub exponent: f64,
    /// c, of mean one.
    pub gains: [f64; DICE],
    /// G0 at the reference, W/K.
    pub quiescent_w_k: f64,
    /// Number of winds.
    pub winds: usize,
}

impl CardCalibration {
    /// The inverse that the board runs.
    pub(super) fn card(&self) -> Result<Card, dr_core::ConfigError> {
        let (side_m, most) = (self.drawn.side_m as f32, self.curves.most_reynolds as f32);
        Card::new(&self.curves.config(), &self.drawn.dice(), side_m, most, DIRECTION_ERROR_MAX_RAD)
    }

    /// E at an angle, rad: the share of the speed that the card sees.
    pub fn seen_at(&self, angle: f64) -> f64 {
        anisotropy(&self.curves.config(), angle).2
    }

    /// Estimates a known wind; none where there is no estimate.
    ///
    /// # Errors
    /// If it makes no card, or the reading cannot be meant.
    pub fn compare(&self, steady: &SteadyWind) -> Result<Option<ComparedWind>, CalibrateError> {
        let gas = steady.core_gas(0.0)?;
        let mut measured = [None; DICE];
        for (i, (measured, reading)) in measured.iter_mut().zip(&steady.surfaces).enumerate() {
            let share = self.gains[i] / reading.overheat_k;
            *measured = Some(MeasuredConductance {
                conductance_w_k: (self.gains[i] * self.drawn.conductance_w_k(steady, reading)) as f32,
                variance_w2_k2: (share * share * reading.variance_w2) as f32,
            });
        }
        let estimate = self.card()?.step(&gas, &measured);
        let speed_m_s = length(steady.wind_m_s);
        if estimate.quality.has(QualityFlags::FAILED)
            || estimate.quality.has(QualityFlags::NO_DIRECTION)
            || speed_m_s == 0.0
        {
            return Ok(None);
        }
        let reynolds = speed_m_s * self.drawn.reynolds_per_speed(steady);
        let is_extrapolated = !(self.curves.least_reynolds..=self.curves.most_reynolds).contains(&reynolds);
        Ok(Some(ComparedWind {
            reynolds,
            direction_deg: Some(angle_deg(estimate.wind_m_s.map(f64::from), steady.wind_m_s)),
            speed: f64::from(estimate.speed_m_s) / speed_m_s - 1.0,
            stated: StatedError::of(&estimate, &measured, is_extrapolated),
        }))
    }
}

impl fmt::Display for CardCalibration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let CardTable { least_reynolds, most_reynolds, mean_share, difference_share, .. } = self.curves;
        writeln!(f, "{} winds, Re {least_reynolds:.1} to {most_reynolds:.1}", self.winds)?;
        let [mean, differences] = [mean_share, difference_share].map(|share| 100.0 * share);
        write!(f, "mean: {mean:.2} % of what the wind adds is left over; ")?;
        writeln!(f, "differences: {differences:.2} %, as Re^{:.3}", self.exponent)?;
        let seen = |degrees: f64| self.seen_at(degrees.to_radians());
        let (across, reverse) = (0.5 * (seen(90.0) + seen(-90.0)), seen(0.0));
        writeln!(f, "of the speed head-on the card sees {across:.2} across and {reverse:.2} in reverse")?;
        let gains: Vec<String> = self.gains.iter().map(|gain| format!("{gain:.4}")).collect();
        writeln!(f, "gains {}; in quiescent gas {:.4} mW/K", gains.join(", "), 1e3 * self.quiescent_w_k)
    }
}

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
            difference: std::array::from_fn(|k| libm::pow(root(k), 2.0 * differences.exponent)),
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
