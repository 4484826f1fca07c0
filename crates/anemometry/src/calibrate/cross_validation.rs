//! Cross-validation of a calibration: every fold of winds is estimated with a calibration from all
//! others, and compared with the known ones.

use std::fmt;

use dr_core::wind::{MeasuredConductance, WindEstimate, calibration_uncertainty};
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

use super::steady_wind::{CalibrateError, SteadyWind};

/// Scheme of winds that are left out together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scheme {
    /// Winds from one region of directions.
    Directions,
    /// Winds of a band of neighbouring speeds.
    Speeds,
    /// Every n-th wind, which says less: its neighbours stay.
    EveryNth,
}

impl Scheme {
    /// Name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Directions => "directions",
            Self::Speeds => "speeds",
            Self::EveryNth => "every n-th wind",
        }
    }
}

/// Errors of winds that were left out of the calibration that estimates them.
#[derive(Debug, Clone, PartialEq)]
pub struct CrossValidation {
    /// Scheme of winds that were left out together.
    pub scheme: Scheme,
    /// Number of folds.
    pub folds: usize,
    /// Estimated winds.
    pub compared: Vec<ComparedWind>,
    /// Labels of winds without an estimate.
    pub failed: Vec<String>,
    /// Classes of speed, an octave each at most.
    classes: Vec<ReynoldsRange>,
}

impl CrossValidation {
    /// Fits without the winds of each fold, and compares these.
    ///
    /// # Errors
    /// If a fold cannot be fitted, or a reading is refused.
    pub fn new<C>(
        (scheme, folds, classes): (Scheme, &[Vec<usize>], Vec<ReynoldsRange>),
        steady: &[SteadyWind],
        fit: impl Fn(&[SteadyWind]) -> Result<C, CalibrateError>,
        compare: impl Fn(&C, &SteadyWind) -> Result<Option<ComparedWind>, CalibrateError>,
    ) -> Result<Self, CalibrateError> {
        let mut result = Self { scheme, folds: folds.len(), compared: Vec::new(), failed: Vec::new(), classes };
        for fold in folds {
            let (out, stay): (Vec<_>, Vec<_>) = steady.iter().enumerate().partition(|(at, _)| fold.contains(at));
            let stay: Vec<SteadyWind> = stay.into_iter().map(|(_, steady)| steady.clone()).collect();
            let calibration = match fit(&stay) {
                Ok(calibration) => calibration,
                // The others determine some numbers only just, and not without these.
                Err(CalibrateError::Amplitudes(_) | CalibrateError::NoMinimum) => {
                    result.failed.extend(out.into_iter().map(|(_, steady)| steady.label.clone()));
                    continue;
                }
                Err(error) => return Err(error),
            };
            for (_, steady) in out {
                match compare(&calibration, steady)? {
                    Some(compared) => result.compared.push(compared),
                    None => result.failed.push(steady.label.clone()),
                }
            }
        }
        Ok(result)
    }

    /// Errors of all winds.
    pub fn overall(&self) -> ComparisonSummary {
        ComparisonSummary::of(self.compared.iter())
    }

    fn write_failed(&self, f: &mut fmt::Formatter<'_>, what: &str) -> fmt::Result {
        if self.failed.is_empty() { Ok(()) } else { writeln!(f, "{what}: {}", self.failed.join(", ")) }
    }

    /// Errors by class of speed.
    pub fn by_class(&self) -> Vec<(ReynoldsRange, ComparisonSummary)> {
        let own = |class: &ReynoldsRange| {
            ComparisonSummary::of(self.compared.iter().filter(|wind| class.holds(wind.reynolds)))
        };
        self.classes.iter().map(|class| (*class, own(class))).filter(|(_, summary)| summary.winds > 0).collect()
    }
}

impl Serialize for CrossValidation {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let all = self.overall();
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("winds", &all.winds)?;
        match self.scheme {
            Scheme::EveryNth => map.serialize_entry("without_direction", &self.failed.len())?,
            Scheme::Directions | Scheme::Speeds => map.serialize_entry("failed", &self.failed)?,
        }
        map.serialize_entry("direction_rms_error_deg", &all.direction_rms_deg)?;
        map.serialize_entry("direction_worst_error_deg", &all.direction_worst_deg)?;
        map.serialize_entry("speed_rms_error", &all.speed_rms)?;
        map.serialize_entry("speed_worst_error", &all.speed_worst)?;
        map.end()
    }
}

impl fmt::Display for CrossValidation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let all = self.overall();
        if self.scheme == Scheme::EveryNth {
            write!(f, "cross-validated: {} winds, ", all.winds)?;
            if !all.direction_rms_deg.is_nan() {
                write!(f, "direction {:.2}° rms, {:.2}° at worst; ", all.direction_rms_deg, all.direction_worst_deg)?;
            }
            writeln!(f, "speed {:.2} % rms, {:.2} % at worst", 100.0 * all.speed_rms, 100.0 * all.speed_worst)?;
            return self.write_failed(f, "no direction");
        }
        writeln!(f, "cross-validated by {}, {} folds", self.scheme.name(), self.folds)?;
        let has_direction = !all.direction_rms_deg.is_nan();
        let heading = if has_direction { "direction rms worst" } else { "" };
        writeln!(f, "{:<32} {:>5} {heading:>18} {:>20}", "", "winds", "speed rms worst")?;
        let classes = self.by_class().into_iter().map(|(range, summary)| (range.to_string(), summary));
        for (name, s) in classes.chain([("all".to_owned(), all)]) {
            let direction = match has_direction {
                true => format!("{:>9.2}° {:>7.2}°", s.direction_rms_deg, s.direction_worst_deg),
                false => " ".repeat(18),
            };
            let [rms, worst] = [s.speed_rms, s.speed_worst].map(|share| 100.0 * share);
            writeln!(f, "{name:<32} {:>5} {direction} {rms:>10.2} % {worst:>6.2} %", s.winds)?;
        }
        self.write_failed(f, "no estimate")
    }
}

/// Errors that an estimate states, by the noise of the readings alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StatedError {
    /// Uncertainty of the speed, as its share.
    pub speed_u: f64,
    /// Uncertainty of the direction about one axis, rad.
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
    /// Uncertainty of an estimate from these conductances.
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
    /// Tells whether a Reynolds number lies in the range.
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
