//! Cross-validation of a calibration: every fold of winds is estimated with a calibration from all
//! others.

use std::fmt;

use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

use super::compared::{ComparedWind, ComparisonSummary, ReynoldsRange};
use super::error::CalibrateError;
use super::steady_wind::SteadyWind;

/// Which winds are left out together.
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
    /// As reports name it.
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
    /// Which winds were left out together.
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
                // What the others determine only just, they do not without these.
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
            return match self.failed.is_empty() {
                true => Ok(()),
                false => writeln!(f, "no direction: {}", self.failed.join(", ")),
            };
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
        if !self.failed.is_empty() {
            writeln!(f, "no estimate: {}", self.failed.join(", "))?;
        }
        Ok(())
    }
}
