//! A calibrated card, as text and as the inverse that the board runs.

use std::fmt;

use dr_core::wind::card_inverse::{Card, DICE, anisotropy};
use dr_core::wind::{MeasuredConductance, QualityFlags};

use super::super::compared::{ComparedWind, StatedError};
use super::super::error::CalibrateError;
use super::super::steady_wind::SteadyWind;
use super::drawn::DrawnCard;
use crate::head::calibration::table::CardTable;
use crate::vector::{angle_deg, length};

/// Only a direction that is uncertain by more is none.
const DIRECTION_ERROR_MAX_RAD: f32 = 1.0;

/// A calibrated card.
#[derive(Debug, Clone, PartialEq)]
pub struct CardCalibration {
    /// The card as drawn.
    pub drawn: DrawnCard,
    /// As a head file has them.
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
        writeln!(
            f,
            "mean: {:.2} % of what the wind adds is left over; differences: {:.2} %, as Re^{:.3}",
            100.0 * mean_share,
            100.0 * difference_share,
            self.exponent
        )?;
        let seen = |degrees: f64| self.seen_at(degrees.to_radians());
        writeln!(
            f,
            "of the speed head-on the card sees {:.2} across and {:.2} in reverse",
            0.5 * (seen(90.0) + seen(-90.0)),
            seen(0.0)
        )?;
        let gains: Vec<String> = self.gains.iter().map(|gain| format!("{gain:.4}")).collect();
        writeln!(f, "gains {}; in quiescent gas {:.4} mW/K", gains.join(", "), 1e3 * self.quiescent_w_k)
    }
}
