//! Reports of a fit and of estimates, as text and as JSON.

use std::fmt;
use std::path::PathBuf;

use recording::text::count;
use serde::Serialize;

use super::combination::{Combination, CombineError};
use super::estimate::{CombinedWind, Combiner};
use super::readings::{CombinedReadings, KnownWind};
use crate::vector::{angle_deg, length};

/// Winds of every so many are left out together.
const FOLDS: usize = 10;

/// Errors of estimates in known winds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct CombinedErrors {
    /// Winds or estimates that were compared.
    pub compared: usize,
    /// Of these without an estimate.
    pub failed: usize,
    /// Of direction, root mean square, °.
    pub direction_rms_error_deg: f64,
    /// Of direction, greatest, °.
    pub direction_worst_error_deg: f64,
    /// Of speed, root mean square, relative.
    pub speed_rms_error: f64,
    /// Of speed, greatest, relative.
    pub speed_worst_error: f64,
}

/// A fit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CombinationReport {
    /// Known winds.
    pub winds: usize,
    /// Of the harmonics.
    pub degree: usize,
    /// Name of each instrument, its components, and what its answers leave of winds that were left
    /// out, of the speed, rms.
    pub instruments: Vec<(String, usize, f64)>,
    /// Errors in winds that were left out.
    pub cross_validated: CombinedErrors,
    /// The file that was written.
    #[serde(skip)]
    pub written: Option<PathBuf>,
}

/// Estimates.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CombinedReport {
    /// Of the combination, in words.
    pub made_from: String,
    /// Rows.
    pub rows: usize,
    /// Of these without an estimate, as too few instruments have one.
    pub failed: usize,
    /// Estimates with another direction that fits about as well.
    pub ambiguous: usize,
    /// Compared with the true wind, if it is known.
    pub comparison: Option<CombinedErrors>,
    /// Files that were written.
    #[serde(skip)]
    pub written: Vec<PathBuf>,
}

impl CombinedErrors {
    /// Of estimates beside true winds, m/s.
    pub fn of(pairs: impl IntoIterator<Item = (Option<CombinedWind>, [f64; 3])>) -> Self {
        let mut errors = Self::default();
        for (found, true_m_s) in pairs {
            errors.compared += 1;
            let Some(found) = found else {
                errors.failed += 1;
                continue;
            };
            let (direction_deg, speed_m_s) = (angle_deg(found.wind_m_s, true_m_s), length(true_m_s));
            let speed = length(found.wind_m_s) / speed_m_s - 1.0;
            errors.direction_rms_error_deg += direction_deg * direction_deg;
            errors.speed_rms_error += speed * speed;
            errors.direction_worst_error_deg = errors.direction_worst_error_deg.max(direction_deg);
            errors.speed_worst_error = errors.speed_worst_error.max(speed.abs());
        }
        let count = (errors.compared - errors.failed).max(1) as f64;
        errors.direction_rms_error_deg = (errors.direction_rms_error_deg / count).sqrt();
        errors.speed_rms_error = (errors.speed_rms_error / count).sqrt();
        errors
    }

    /// In words.
    pub fn in_words(&self) -> String {
        format!("direction {:.2}° rms, speed {:.2} % rms", self.direction_rms_error_deg, 100.0 * self.speed_rms_error)
    }
}

/// Fits instruments to known winds, and says how well it does in winds that were left out.
///
/// # Errors
/// As [`Combination::fit`].
pub fn fit(names: &[String], known: &[KnownWind]) -> Result<(Combination, CombinationReport), CombineError> {
    let mut combination = Combination::fit(names, known)?;
    let mut pairs = Vec::new();
    for fold in 0..FOLDS {
        let out = |n: usize| n % FOLDS == fold;
        let stay: Vec<KnownWind> =
            known.iter().enumerate().filter(|(n, _)| !out(*n)).map(|(_, of)| of.clone()).collect();
        let without = Combination::fit(names, &stay)?;
        let combiner = Combiner::new(&without);
        let left = known.iter().enumerate().filter(|(n, _)| out(*n));
        pairs.extend(left.map(|(_, of)| (combiner.estimate(&of.readings), of.wind_m_s)));
    }
    let cross_validated = CombinedErrors::of(pairs);
    combination.made_from = format!("{} winds; cross-validated: {}", known.len(), cross_validated.in_words());
    let mut place = 0;
    let mut instruments = Vec::new();
    for of in &combination.instruments {
        let places = place..place + of.axes.len();
        let squares = combination.left.iter().flat_map(|left| &left.shares[places.clone()]).map(|share| share * share);
        let rms = (squares.sum::<f64>() / combination.left.len() as f64).sqrt();
        instruments.push((of.name.clone(), of.axes.len(), rms));
        place = places.end;
    }
    let (winds, degree) = (known.len(), combination.degree);
    Ok((combination, CombinationReport { winds, degree, instruments, cross_validated, written: None }))
}

/// Errors of estimates in the rows that count: from a time on, without the first `settle_s` of each
/// label.
pub fn compared(
    readings: &CombinedReadings,
    estimates: &[Option<CombinedWind>],
    from_s: f64,
    settle_s: f64,
) -> Option<CombinedErrors> {
    let mut since_s = f64::NEG_INFINITY;
    let mut pairs = Vec::new();
    for (row, found) in estimates.iter().enumerate() {
        if row == 0 || readings.events[row] != readings.events[row - 1] {
            since_s = readings.time_s[row];
        }
        let counts = readings.time_s[row] >= from_s.max(since_s + settle_s);
        if let Some(true_m_s) = readings.true_wind_m_s[row].filter(|of| counts && length(*of) > 0.0) {
            pairs.push((*found, true_m_s));
        }
    }
    (!pairs.is_empty()).then(|| CombinedErrors::of(pairs))
}

impl fmt::Display for CombinedErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (rms_deg, worst_deg) = (self.direction_rms_error_deg, self.direction_worst_error_deg);
        let [rms, worst] = [self.speed_rms_error, self.speed_worst_error].map(|share| 100.0 * share);
        if self.failed > 0 {
            writeln!(f, "  no wind    {} of {}", self.failed, self.compared)?;
        }
        writeln!(f, "  direction  {rms_deg:.2}° rms, {worst_deg:.2}° at worst")?;
        writeln!(f, "  speed      {rms:.2} % rms, {worst:.2} % at worst")
    }
}

impl fmt::Display for CombinationReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let instruments = count(self.instruments.len(), "instrument");
        writeln!(f, "{instruments} in {}, harmonics up to degree {}", count(self.winds, "known wind"), self.degree)?;
        for (name, components, rms) in &self.instruments {
            let components = count(*components, "component");
            writeln!(f, "  {name:<16} {components}, known to {:.1} % of the speed", 100.0 * rms)?;
        }
        write!(f, "winds that were left out:\n{}", self.cross_validated)?;
        if let Some(path) = &self.written {
            writeln!(f, "\nwritten to {}", path.display())?;
        }
        Ok(())
    }
}

impl fmt::Display for CombinedReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "combined by {}", self.made_from)?;
        writeln!(f, "{}, {} without a wind, {} ambiguous", count(self.rows, "row"), self.failed, self.ambiguous)?;
        if let Some(errors) = &self.comparison {
            write!(f, "\ncompared with the true wind, {}\n{errors}", count(errors.compared, "estimate"))?;
        }
        for path in &self.written {
            writeln!(f, "\nwritten to {}", path.display())?;
        }
        Ok(())
    }
}
