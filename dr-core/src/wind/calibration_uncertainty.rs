//! Amount that a calibration adds to the standard uncertainty of a wind, and which residuals it
//! explains.
//!
//! The inverse knows the noise of the readings. A calibration misses each conductance besides, and
//! with them the wind; by how much was seen in winds that were left out of it, by Reynolds number:
//!
//! ```text
//! C = C_n + w² ( s² ê êᵀ + d² (1 − ê êᵀ) )      w = max(v, v_least)
//! χ² = χ_n² / (1 + mean_i κ² G_i² / σ_i²)       contradicted beyond χ²_most
//! m ← m + g (1 − m) if contradicted, else m − g m
//! C ← C (χ²/ν) (1 + 3/ν)                          if contradicted
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | C_n, χ_n² | covariance and χ² by the noise of the readings | m²/s², 1 |
//! | v, ê, v_least | speed, direction of the wind, least speed of the calibration | m/s, 1, m/s |
//! | s, d, κ | shares of speed, direction and conductances at the wind's Reynolds number | 1, rad, 1 |
//! | G_i, σ_i² | conductance of a surface, its variance by the noise | W/K, W²/K² |
//! | ν | conductances less unknowns | 1 |
//! | m, g | share of contradicted estimates, remembered for five minutes; weight of one | 1 |
//!
//! Between the [`KNOTS`] Reynolds numbers s, d and κ are linear in log Re, beyond them constant.
//! What contradicts is known by ν numbers only, often by one, and the wind may miss more than these
//! show, hence the last factor: with it 95 % intervals hold some 85 % of winds with the gain of one
//! sector off by 5 %, without it 63 %.
//!
//! Winds that show a fault depends on where they come from, so the flag `inconsistent` stays while
//! more than a quarter of the remembered estimates were contradicted; a wind that jumps contradicts
//! itself for a moment, too. Starting, saturated, ambiguous and extrapolated ones, and those of
//! still or slow gas, are not remembered. Winds that are slower than all of the calibration, and
//! not still, are flagged `below-calibration`.
//!
//! A gas temperature that no calibration has had adds its own shares, which are not widened.
//!
//! *Limits.* The errors of gas and pressure readings are not in it; the host's program adds them
//! where they are stated.

use super::estimate::WindEstimate;
use super::quality_flags::QualityFlags;
use super::surface_inverse::MeasuredConductance;
use crate::arithmetic::{log2, sqrt};
use crate::error::{self, ConfigError, Parameter};
use core::f32::consts::PI;

/// Reynolds numbers at which shares are given, in geometric progression over the calibration's.
pub const KNOTS: usize = 4;

/// Factor for the size of a contradiction by few numbers.
const BY_FEW: f32 = 3.0;

/// Speeds of fewer standard uncertainties are none: that of three components of noise is often two.
const STILL: f32 = 4.0;
/// Time for which contradictions are remembered, s.
pub const MEMORY_S: f32 = 300.0;
/// Share of them from which on the flag stays.
const MOST_CONTRADICTED: f32 = 0.25;

/// Contradictions of the last minutes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ContradictionMemory {
    share: f32,
}

impl ContradictionMemory {
    /// Remembers the flags of an estimate, whose weight is `gain`; returns them with what is
    /// remembered.
    pub fn with(&mut self, flags: QualityFlags, gain: f32) -> QualityFlags {
        let not_counted = [
            QualityFlags::FAILED,
            QualityFlags::NO_DIRECTION,
            QualityFlags::BELOW_CALIBRATION,
            QualityFlags::STARTING,
            QualityFlags::NOT_RUNNING,
            QualityFlags::SATURATED,
            QualityFlags::EXTRAPOLATED,
            QualityFlags::AMBIGUOUS,
            QualityFlags::NO_GAS,
        ];
        if !not_counted.iter().any(|&flag| flags.has(flag)) {
            let now = if flags.has(QualityFlags::INCONSISTENT) { 1.0 } else { 0.0 };
            self.share += gain * (now - self.share);
        }
        flags.with(QualityFlags::INCONSISTENT, self.share > MOST_CONTRADICTED)
    }
}

/// Scale that turns speeds into Reynolds numbers of a calibration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedScale {
    /// Least and greatest Reynolds number of the calibration.
    pub reynolds: [f32; 2],
    /// Reynolds number of 1 m/s.
    pub per_speed: f32,
    /// Amount that the gas's temperature adds: shares of the speed, and rad.
    pub away: [f32; 2],
}

impl SpeedScale {
    /// Where a Reynolds number lies among the knots: 0 at the first, `KNOTS` − 1 at the last.
    pub fn place(&self, reynolds: f32) -> f32 {
        let [least, most] = self.reynolds;
        let last = (KNOTS - 1) as f32;
        if reynolds > least { (last * log2(reynolds / least) / log2(most / least)).min(last) } else { 0.0 }
    }
}

/// Shares of a calibration in the standard uncertainty.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CalibrationUncertainty {
    /// κ, of a conductance.
    pub conductance_share: [f32; KNOTS],
    /// s, of the speed.
    pub speed_share: [f32; KNOTS],
    /// d, of the direction about one axis across it, rad.
    pub direction_rad: [f32; KNOTS],
    /// Greatest χ² that the calibration explains.
    pub chi_square_most: f32,
}

impl CalibrationUncertainty {
    /// Returns it as it is, if it can be.
    ///
    /// # Errors
    /// A share that is negative or more than one, a direction beyond π, or a χ² below one.
    pub fn checked(self) -> Result<Self, ConfigError> {
        let parameter = Parameter::CalibrationUncertainty;
        for share in self.conductance_share.into_iter().chain(self.speed_share) {
            error::within(parameter, share, 0.0, 1.0)?;
        }
        for direction_rad in self.direction_rad {
            error::within(parameter, direction_rad, 0.0, PI)?;
        }
        error::within(parameter, self.chi_square_most, 1.0, 1e9)?;
        Ok(self)
    }

    /// κ at a [place](SpeedScale::place) among the knots.
    pub fn conductance_share_at(&self, place: f32) -> f32 {
        at(&self.conductance_share, place)
    }

    /// A wind with the calibration's share in its uncertainty and χ²; one that failed stays.
    ///
    /// Not inlined, so that its vectors are not on the stack while the inverse is.
    #[inline(never)]
    pub fn added_to(
        &self,
        wind: WindEstimate,
        measured: &[Option<MeasuredConductance>],
        scale: &SpeedScale,
        direction_error_max_rad: f32,
    ) -> WindEstimate {
        if wind.quality.has(QualityFlags::FAILED) {
            return wind;
        }
        let place = scale.place(wind.speed_m_s * scale.per_speed);
        let chi_square = wind.chi_square / (1.0 + square(self.conductance_share_at(place)) * precision(measured));
        let is_inconsistent = wind.degrees_of_freedom > 0 && chi_square > self.chi_square_most;
        let freedom = f32::from(wind.degrees_of_freedom);
        let wider = if is_inconsistent { chi_square / freedom * (1.0 + BY_FEW / freedom) } else { 1.0 };

        let size_m_s = wind.speed_m_s.max(scale.reynolds[0] / scale.per_speed);
        let [away_along_m_s, away_across_m_s] = scale.away.map(|share| share * size_m_s);
        let along_m_s = at(&self.speed_share, place) * size_m_s;
        let across_m_s = at(&self.direction_rad, place) * size_m_s;
        let per_square = if wind.speed_m_s > 0.0 { 1.0 / square(wind.speed_m_s) } else { 0.0 };
        // The uncertainty of another gas temperature causes contradictions, and is not widened.
        let whole = |known_m_s: f32, away_m_s: f32| wider * square(known_m_s) + square(away_m_s);
        let (added_along, added_across) = (whole(along_m_s, away_along_m_s), whole(across_m_s, away_across_m_s));
        let mut covariance_m2_s2 = wind.covariance_m2_s2;
        for (i, row) in covariance_m2_s2.iter_mut().enumerate() {
            for (j, element) in row.iter_mut().enumerate() {
                let across = if i == j { added_across } else { 0.0 };
                let along = (added_along - added_across) * per_square * wind.wind_m_s[i] * wind.wind_m_s[j];
                *element = wider * *element + across + along;
            }
        }
        let speed_error_m_s = sqrt(wider * square(wind.speed_error_m_s) + added_along);
        let is_still = wind.speed_m_s < STILL * speed_error_m_s;
        let is_below = wind.speed_m_s + speed_error_m_s < scale.reynolds[0] / scale.per_speed;
        let across_square = if wind.speed_m_s > 0.0 { added_across * per_square } else { PI * PI };
        let direction_error_rad = sqrt(wider * square(wind.direction_error_rad) + across_square).min(PI);
        let no_direction = direction_error_rad > direction_error_max_rad;
        WindEstimate {
            covariance_m2_s2,
            speed_error_m_s,
            direction_error_rad,
            chi_square,
            quality: wind
                .quality
                .with(QualityFlags::INCONSISTENT, is_inconsistent)
                .with(QualityFlags::BELOW_CALIBRATION, is_below && !is_still)
                .with(QualityFlags::NO_DIRECTION, no_direction),
            ..wind
        }
    }
}

/// Mean of G²/σ² over the surfaces that were measured.
pub fn precision(measured: &[Option<MeasuredConductance>]) -> f32 {
    let (mut sum, mut count) = (0.0, 0.0);
    for part in measured.iter().flatten().filter(|part| part.variance_w2_k2 > 0.0) {
        sum += square(part.conductance_w_k) / part.variance_w2_k2;
        count += 1.0;
    }
    if count > 0.0 { sum / count } else { 0.0 }
}

/// A share at a place.
fn at(knots: &[f32; KNOTS], place: f32) -> f32 {
    let first = (place as usize).min(KNOTS - 2);
    let [from, to] = [knots[first], knots[first + 1]];
    from + (place - first as f32) * (to - from)
}

fn square(x: f32) -> f32 {
    x * x
}

#[cfg(test)]
mod tests;
