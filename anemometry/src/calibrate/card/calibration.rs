//! A calibrated card, as text and as dr-core's configuration.

use std::fmt;

use dr_core::wind::card_inverse::{Card, CardConfig, DICE, KNOTS, TERMS, anisotropy};
use dr_core::wind::{MeasuredConductance, QualityFlags};

use super::super::compared::ComparedWind;
use super::super::error::CalibrateError;
use super::super::steady_wind::SteadyWind;
use super::drawn::DrawnCard;
use crate::head::calibration::CardTable;
use crate::wind::comparison::{angle_deg, length};

/// Only a direction that is uncertain by more is none.
const DIRECTION_ERROR_MAX_RAD: f32 = 1.0;

/// A calibrated card.
#[derive(Debug, Clone, PartialEq)]
pub struct CardCalibration {
    /// The card as drawn.
    pub drawn: DrawnCard,
    /// Least Reynolds number of the winds.
    pub least_reynolds: f64,
    /// Greatest Reynolds number of the winds.
    pub most_reynolds: f64,
    /// Mean Nusselt number over √Re.
    pub mean: [f64; KNOTS],
    /// Re^n over √Re.
    pub difference: [f64; KNOTS],
    /// P
    pub along: [f64; TERMS],
    /// Q
    pub around: [f64; TERMS],
    /// E
    pub seen: [f64; TERMS],
    /// n
    pub exponent: f64,
    /// Residuals of the mean over what the wind adds, rms.
    pub mean_share: f64,
    /// Residuals of the differences over their size, rms.
    pub difference_share: f64,
    /// c, of mean one.
    pub gains: [f64; DICE],
    /// G0 at the reference, W/K.
    pub quiescent_w_k: f64,
    /// Number of winds.
    pub winds: usize,
}

impl CardCalibration {
    /// As a head file has it.
    pub fn table(&self) -> CardTable {
        CardTable {
            least_reynolds: self.least_reynolds,
            most_reynolds: self.most_reynolds,
            mean: self.mean,
            difference: self.difference,
            along: self.along,
            around: self.around,
            seen: self.seen,
            mean_share: self.mean_share,
            difference_share: self.difference_share,
        }
    }

    /// As the board takes it.
    pub fn config(&self) -> CardConfig {
        self.table().config()
    }

    /// The inverse that the board runs.
    pub(super) fn card(&self) -> Result<Card, dr_core::ConfigError> {
        let (side_m, most) = (self.drawn.side_m as f32, self.most_reynolds as f32);
        Card::new(&self.config(), &self.drawn.dice(), side_m, most, DIRECTION_ERROR_MAX_RAD)
    }

    /// E at an angle, rad: the share of the speed that the card sees.
    pub fn seen_at(&self, angle: f64) -> f64 {
        anisotropy(&self.config(), angle).2
    }

    /// Estimates a known wind; none where there is no estimate.
    ///
    /// # Errors
    /// If it makes no card, or the reading cannot be meant.
    pub fn compare(&self, steady: &SteadyWind) -> Result<Option<ComparedWind>, CalibrateError> {
        let gas = steady.core_gas()?;
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
        Ok(Some(ComparedWind {
            label: steady.label.clone(),
            speed_m_s,
            reynolds: speed_m_s * self.drawn.reynolds_per_speed(steady),
            direction_deg: angle_deg(estimate.wind_m_s.map(f64::from), steady.wind_m_s),
            speed: f64::from(estimate.speed_m_s) / speed_m_s - 1.0,
            chi_square: f64::from(estimate.chi_square) / f64::from(estimate.degrees_of_freedom.max(1)),
        }))
    }
}

impl fmt::Display for CardCalibration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} winds, Re {:.1} to {:.1}", self.winds, self.least_reynolds, self.most_reynolds)?;
        writeln!(
            f,
            "mean: {:.2} % of what the wind adds is left over; differences: {:.2} %, as Re^{:.3}",
            100.0 * self.mean_share,
            100.0 * self.difference_share,
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
