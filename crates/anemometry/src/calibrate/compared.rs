//! Winds estimated with a calibration and compared with the known ones.

use dr_core::wind::{MeasuredConductance, WindEstimate, calibration_uncertainty};

/// Errors that an estimate states, by the noise of the readings alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StatedError {
    /// Of the speed, as its share.
    pub speed_u: f64,
    /// Of the direction about one axis, rad.
    pub direction_u_rad: f64,
    /// χ².
    pub chi_square: f64,
    /// Conductances less unknowns.
    pub degrees_of_freedom: u8,
    /// Mean of (G/σ)² of the surfaces.
    pub precision: f64,
    /// Slower or faster than all winds of the calibration that estimated it.
    pub is_extrapolated: bool,
}

impl StatedError {
    /// Of an estimate from these conductances.
    pub fn of(estimate: &WindEstimate, measured: &[Option<MeasuredConductance>], is_extrapolated: bool) -> Self {
        Self {
            speed_u: f64::from(estimate.speed_error_m_s / estimate.speed_m_s),
            direction_u_rad: estimate.direction_error_rad.into(),
            chi_square: estimate.chi_square.into(),
            degrees_of_freedom: estimate.degrees_of_freedom,
            precision: calibration_uncertainty::precision(measured).into(),
            is_extrapolated,
        }
    }

    /// χ² if the calibration misses conductances by a share.
    pub fn chi_square_with(&self, conductance_share: f64) -> f64 {
        self.chi_square / (1.0 + conductance_share.powi(2) * self.precision)
    }
}

/// One wind, known and estimated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ComparedWind {
    /// Reynolds number.
    pub reynolds: f64,
    /// Error of direction, °; none of a single element.
    pub direction_deg: Option<f64>,
    /// Relative error of speed.
    pub speed: f64,
    /// Errors that the estimate states.
    pub stated: StatedError,
}

/// Errors of several winds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ComparisonSummary {
    /// Number of winds.
    pub winds: usize,
    /// Error of direction, root mean square, °; not a number where there is none.
    pub direction_rms_deg: f64,
    /// Error of direction, greatest, °.
    pub direction_worst_deg: f64,
    /// Relative error of speed, root mean square.
    pub speed_rms: f64,
    /// Relative error of speed, greatest.
    pub speed_worst: f64,
}

impl ComparisonSummary {
    /// Errors in words: `direction 0.20° rms, speed 0.50 % rms`.
    pub fn in_words(&self) -> String {
        let speed = format!("speed {:.2} % rms", 100.0 * self.speed_rms);
        if self.direction_rms_deg.is_nan() {
            return speed;
        }
        format!("direction {:.2}° rms, {speed}", self.direction_rms_deg)
    }

    /// Summary of these winds.
    pub fn of<'a>(errors: impl Iterator<Item = &'a ComparedWind> + Clone) -> Self {
        let winds = errors.clone().count();
        let rms = |of: fn(&ComparedWind) -> f64| {
            (errors.clone().map(|e| of(e).powi(2)).sum::<f64>() / winds.max(1) as f64).sqrt()
        };
        let worst = |of: fn(&ComparedWind) -> f64| errors.clone().map(|e| of(e).abs()).fold(0.0, f64::max);
        Self {
            winds,
            direction_rms_deg: rms(|e| e.direction_deg.unwrap_or(f64::NAN)),
            direction_worst_deg: worst(|e| e.direction_deg.unwrap_or(f64::NAN)),
            speed_rms: rms(|e| e.speed),
            speed_worst: worst(|e| e.speed),
        }
    }
}

/// A range of Reynolds numbers with its speeds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReynoldsRange {
    /// Least and greatest Reynolds number.
    pub reynolds: [f64; 2],
    /// The same in m/s.
    pub speed_m_s: [f64; 2],
}

impl ReynoldsRange {
    /// Whether a Reynolds number lies in the range.
    pub fn holds(&self, reynolds: f64) -> bool {
        // A wind on the border belongs to the upper range, but the fastest to the last.
        (self.reynolds[0]..self.reynolds[1]).contains(&reynolds)
    }
}

impl std::fmt::Display for ReynoldsRange {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let ([a, b], [from, to]) = (self.speed_m_s, self.reynolds);
        write!(f, "{} to {} m/s (Re {from:.0} to {to:.0})", digits(a), digits(b))
    }
}

/// Speed with as many digits as matter.
pub fn digits(speed: f64) -> String {
    if speed < 1.0 { format!("{speed:.2}") } else { format!("{speed:.1}") }
}
