//! Reports of a fit and of estimates, as text and as JSON.

use std::fmt;
use std::path::PathBuf;

use recording::text::count;
use serde::Serialize;

use super::combination::{Combination, CombineError};
use super::estimate::{CombinedWind, Combiner};
use super::readings::{CombinedReadings, KnownWind, RowsThatCount};
use super::space::WindSpace;
use crate::vector::{angle_deg, length};
use crate::wind::comparison::ErrorSum;

/// Winds of every so many are left out together.
const FOLDS: usize = 10;

/// Errors of estimates in known winds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CombinedErrors {
    /// Winds or estimates that were compared.
    pub compared: usize,
    /// Of these without an estimate.
    pub failed: usize,
    /// Of these with another direction that fits about as well.
    pub ambiguous: usize,
    /// Of direction, root mean square, °; none without an estimate, as all that follow.
    pub direction_rms_error_deg: Option<f64>,
    /// Of direction, greatest, °.
    pub direction_worst_error_deg: Option<f64>,
    /// Of speed, root mean square, relative.
    pub speed_rms_error: Option<f64>,
    /// Of speed, mean, relative.
    pub speed_bias: Option<f64>,
    /// Of speed, greatest, relative.
    pub speed_worst_error: Option<f64>,
}

/// What is known of an instrument.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct InstrumentReport {
    /// Its name.
    pub name: String,
    /// Components of the wind that it sees.
    pub components: usize,
    /// Whether it knows no speed.
    pub is_direction: bool,
    /// What its answers leave of winds that were left out, of the speed, rms.
    pub left_of_speed: f64,
}

/// A fit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CombinationReport {
    /// Known winds.
    pub winds: usize,
    /// Where they are from.
    pub space: WindSpace,
    /// Of the functions of the direction.
    pub degree: usize,
    /// One an instrument.
    pub instruments: Vec<InstrumentReport>,
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
    /// Rows that count.
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
    pub fn of(pairs: &[(Option<CombinedWind>, [f64; 3])]) -> Self {
        let (mut direction_deg, mut speed) = (ErrorSum::default(), ErrorSum::default());
        for (found, true_m_s) in pairs.iter().filter_map(|(found, truth)| Some((found.as_ref()?, *truth))) {
            direction_deg.add(angle_deg(found.wind_m_s, true_m_s));
            speed.add(length(found.wind_m_s) / length(true_m_s) - 1.0);
        }
        Self {
            compared: pairs.len(),
            failed: pairs.iter().filter(|(found, _)| found.is_none()).count(),
            ambiguous: pairs.iter().filter(|(found, _)| found.is_some_and(|of| of.is_ambiguous)).count(),
            direction_rms_error_deg: direction_deg.rms(),
            direction_worst_error_deg: direction_deg.worst(),
            speed_rms_error: speed.rms(),
            speed_bias: speed.mean(),
            speed_worst_error: speed.worst(),
        }
    }

    /// In words.
    pub fn in_words(&self) -> String {
        match (self.direction_rms_error_deg, self.speed_rms_error) {
            (Some(deg), Some(speed)) => format!("direction {deg:.2}° rms, speed {:.2} % rms", 100.0 * speed),
            _ => "no wind".to_owned(),
        }
    }
}

/// Fits instruments to known winds, and says how well it does in winds that were left out.
///
/// # Errors
/// As [`Combination::fit`].
pub fn fit(
    readings: &CombinedReadings,
    which: RowsThatCount,
) -> Result<(Combination, CombinationReport), CombineError> {
    let (names, whats, known) = (&readings.names, &readings.whats, readings.known(which));
    let mut combination = Combination::fit(names, whats, &known)?;
    let mut pairs = Vec::new();
    for fold in 0..FOLDS.min(known.len()) {
        let (out, stay): (Vec<_>, Vec<_>) = known.iter().enumerate().partition(|(n, _)| n % FOLDS == fold);
        let stay: Vec<KnownWind> = stay.into_iter().map(|(_, of)| of.clone()).collect();
        let without = Combination::fit(names, whats, &stay)?;
        let combiner = Combiner::new(&without);
        pairs.extend(out.into_iter().map(|(_, of)| (combiner.estimate(&of.readings), of.wind_m_s)));
    }
    let cross_validated = CombinedErrors::of(&pairs);
    combination.made_from = format!("{}; cross-validated: {}", count(known.len(), "wind"), cross_validated.in_words());
    let report = CombinationReport {
        winds: known.len(),
        space: combination.space,
        degree: combination.degree,
        instruments: instruments(&combination),
        cross_validated,
        written: None,
    };
    Ok((combination, report))
}

fn instruments(combination: &Combination) -> Vec<InstrumentReport> {
    let mut place = 0;
    let report = |of: &super::combination::InstrumentAnswer| {
        let places = place..place + of.axes.len();
        place = places.end;
        let squares = combination.left.iter().flat_map(|left| &left.shares[places.clone()]).map(|share| share * share);
        InstrumentReport {
            name: of.name.clone(),
            components: of.axes.len(),
            is_direction: of.is_direction,
            left_of_speed: (squares.sum::<f64>() / combination.left.len() as f64).sqrt(),
        }
    };
    combination.instruments.iter().map(report).collect()
}

impl CombinedReport {
    /// Of the estimates of all rows.
    pub fn new(
        combination: &Combination,
        readings: &CombinedReadings,
        estimates: &[Option<CombinedWind>],
        which: RowsThatCount,
    ) -> Self {
        let rows = readings.stretches(which).concat();
        let pairs: Vec<_> = rows.iter().filter_map(|row| Some((estimates[*row], readings.true_wind(*row)?))).collect();
        Self {
            made_from: combination.made_from.clone(),
            rows: rows.len(),
            failed: rows.iter().filter(|row| estimates[**row].is_none()).count(),
            ambiguous: rows.iter().filter_map(|row| estimates[*row]).filter(|of| of.is_ambiguous).count(),
            comparison: (!pairs.is_empty()).then(|| CombinedErrors::of(&pairs)),
            written: Vec::new(),
        }
    }
}

impl fmt::Display for CombinedErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let number = |of: Option<f64>| of.unwrap_or(f64::NAN);
        let [rms_deg, worst_deg] = [self.direction_rms_error_deg, self.direction_worst_error_deg].map(number);
        let speed = [self.speed_rms_error, self.speed_bias, self.speed_worst_error];
        let [rms, mean, worst] = speed.map(|of| 100.0 * number(of));
        if self.failed > 0 {
            writeln!(f, "  no wind    {} of {}", self.failed, self.compared)?;
        }
        if self.ambiguous > 0 {
            writeln!(f, "  ambiguous  {} of {}: another direction fits about as well", self.ambiguous, self.compared)?;
        }
        if self.failed == self.compared {
            return Ok(());
        }
        writeln!(f, "  direction  {rms_deg:.2}° rms, {worst_deg:.2}° at worst")?;
        writeln!(f, "  speed      {rms:.2} % rms, {mean:.2} % mean, {worst:.2} % at worst")
    }
}

impl fmt::Display for CombinationReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (instruments, winds) = (count(self.instruments.len(), "instrument"), count(self.winds, "known wind"));
        let space = match self.space {
            WindSpace::Everywhere => "from everywhere".to_owned(),
            WindSpace::Across(normal) => {
                // Without a minus before a zero.
                let [x, y, z] = normal.map(|x| (100.0 * x).round() / 100.0 + 0.0);
                format!("across ({x}, {y}, {z})")
            }
        };
        writeln!(f, "{instruments} in {winds} {space}; functions of the direction up to degree {}", self.degree)?;
        for of in &self.instruments {
            let kind = if of.is_direction { ", direction only" } else { "" };
            let (components, left) = (count(of.components, "component"), 100.0 * of.left_of_speed);
            writeln!(f, "  {:<16} {components}{kind}, known to {left:.1} %", of.name)?;
        }
        write!(f, "\nin winds that were left out\n{}", self.cross_validated)?;
        if let Some(path) = &self.written {
            writeln!(f, "\nwritten to {}", path.display())?;
        }
        Ok(())
    }
}

impl fmt::Display for CombinedReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "combined by {}", self.made_from)?;
        let rows = count(self.rows, "row");
        writeln!(f, "{rows} that count, {} without a wind, {} ambiguous", self.failed, self.ambiguous)?;
        if let Some(errors) = &self.comparison {
            write!(f, "\ncompared with the true wind, {}\n{errors}", count(errors.compared, "estimate"))?;
        }
        for path in &self.written {
            writeln!(f, "\nwritten to {}", path.display())?;
        }
        Ok(())
    }
}
