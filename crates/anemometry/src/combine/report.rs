//! Reports of a fit and of estimates, as text and as JSON.

use std::fmt;
use std::path::PathBuf;

use recording::text::count;
use serde::Serialize;

use super::combination::{Combination, CombineError};
use super::estimate::{CombinedWind, Combiner, chi_square_99};
use super::instrument::InstrumentKind;
use super::readings::{CombinedReadings, KnownWind, RowsThatCount};
use super::space::{KnownDirections, WindSpace};

use crate::vector::{angle_deg, length, unit};
use crate::wind::comparison::ErrorSum;

/// Directions of every so many are left out together.
const FOLDS: usize = 10;
/// Errors of winds that were left out, above which a combination is of little use.
const POOR_DEG: f64 = 10.0;
const POOR_SPEED: f64 = 0.15;
/// The least ratio of the fastest to the slowest known wind.
const SPEED_RATIO: f64 = 1.5;

/// Errors of estimates in known winds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CombinedErrors {
    /// Winds or estimates that were compared.
    pub compared: usize,
    /// Number of these without an estimate.
    pub failed: usize,
    /// Number of these with another direction that fits about as well.
    pub ambiguous: usize,
    /// Share of errors within twice their standard uncertainty, of speeds; of all estimates that
    /// are not flagged.
    pub speed_within_2u: Option<f64>,
    /// The same of directions.
    pub direction_within_2u: Option<f64>,
    /// Error of direction, root mean square, °; none without an estimate, as all that follow.
    pub direction_rms_error_deg: Option<f64>,
    /// Error of direction, greatest, °.
    pub direction_worst_error_deg: Option<f64>,
    /// Error of speed, root mean square, relative.
    pub speed_rms_error: Option<f64>,
    /// Error of speed, mean, relative.
    pub speed_bias: Option<f64>,
    /// Error of speed, greatest, relative.
    pub speed_worst_error: Option<f64>,
}

/// Report on an instrument.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct InstrumentReport {
    /// Its name.
    pub name: String,
    /// Components of the wind that it sees.
    pub components: usize,
    /// Kind of its knowledge.
    pub kind: InstrumentKind,
    /// Residuals of winds that were left out, of the speed, rms.
    pub left_of_speed: f64,
}

/// A fit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CombinationReport {
    /// Known winds.
    pub winds: usize,
    /// Number of these with estimates of all instruments.
    pub fitted: usize,
    /// Their directions.
    pub directions: usize,
    /// Where they are from.
    pub space: WindSpace,
    /// Degree of the functions of the direction.
    pub degree: usize,
    /// One an instrument.
    pub instruments: Vec<InstrumentReport>,
    /// Errors in winds that were left out.
    pub cross_validated: CombinedErrors,
    /// Reasons why it is of little use.
    pub warnings: Vec<String>,
    /// The file that was written.
    #[serde(skip)]
    pub written: Option<PathBuf>,
}

/// Estimates.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CombinedReport {
    /// Origin of the combination, in words.
    pub made_from: String,
    /// Rows that count.
    pub rows: usize,
    /// Number of these without an estimate, as too few instruments have one.
    pub failed: usize,
    /// Estimates with another direction that fits about as well.
    pub ambiguous: usize,
    /// In which the instruments do not say the same.
    pub inconsistent: usize,
    /// Slower or faster than the known winds.
    pub extrapolated: usize,
    /// Whose direction is not known.
    pub no_direction: usize,
    /// In which an instrument has no estimate.
    pub degraded: usize,
    /// Compared with the true wind, if it is known.
    pub comparison: Option<CombinedErrors>,
    /// Files that were written.
    #[serde(skip)]
    pub written: Vec<PathBuf>,
}

impl CombinedErrors {
    /// Errors of estimates beside true winds, m/s.
    pub fn of(pairs: &[(Option<CombinedWind>, [f64; 3])]) -> Self {
        let (mut direction_deg, mut speed) = (ErrorSum::default(), ErrorSum::default());
        let (mut good, mut within) = (0, [0, 0]);
        for (found, true_m_s) in pairs.iter().filter_map(|(found, truth)| Some((found.as_ref()?, *truth))) {
            let off_deg = angle_deg(found.wind_m_s, true_m_s);
            let off_m_s = length(found.wind_m_s) - length(true_m_s);
            direction_deg.add(off_deg);
            speed.add(off_m_s / length(true_m_s));
            if !found.is_flagged() {
                good += 1;
                within[0] += usize::from(off_m_s.abs() <= 2.0 * found.speed_u_m_s);
                within[1] += usize::from(off_deg.to_radians() <= 2.0 * found.direction_u_rad);
            }
        }
        let within = within.map(|of| (good > 0).then(|| of as f64 / good as f64));
        Self {
            compared: pairs.len(),
            failed: pairs.iter().filter(|(found, _)| found.is_none()).count(),
            ambiguous: pairs.iter().filter(|(found, _)| found.is_some_and(|of| of.is_ambiguous)).count(),
            speed_within_2u: within[0],
            direction_within_2u: within[1],
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
    let directions = KnownDirections::new(known.iter().map(|of| unit(of.wind_m_s)).collect());
    let mut pairs = Vec::new();
    for fold in 0..FOLDS.min(directions.count) {
        let (out, stay): (Vec<_>, Vec<_>) =
            known.iter().zip(&directions.groups).partition(|(_, group)| *group % FOLDS == fold);
        let stay: Vec<KnownWind> = stay.into_iter().map(|(of, _)| of.clone()).collect();
        let without = Combination::fit(names, whats, &stay)?;
        let combiner = Combiner::new(&without);
        pairs.extend(out.into_iter().map(|(of, _)| (combiner.estimate(&of.readings), of.wind_m_s)));
    }
    combination.chi_square_ratio = chi_square_ratio(pairs.iter().filter_map(|(found, _)| found.as_ref()));
    let cross_validated = CombinedErrors::of(&pairs);
    combination.made_from = format!("{}; cross-validated: {}", count(known.len(), "wind"), cross_validated.in_words());
    let report = CombinationReport {
        winds: known.len(),
        fitted: combination.left.len(),
        directions: directions.count,
        space: combination.space,
        degree: combination.degree,
        instruments: instruments(&combination),
        cross_validated,
        warnings: warnings(&combination, &cross_validated),
        written: None,
    };
    Ok((combination, report))
}

/// 99th percentile of χ² over that of chance; 1 at least.
fn chi_square_ratio<'a>(found: impl Iterator<Item = &'a CombinedWind>) -> f64 {
    let found = found.filter(|of| of.degrees_of_freedom > 0 && !of.is_ambiguous);
    let mut ratios: Vec<f64> = found.map(|of| of.chi_square / chi_square_99(of.degrees_of_freedom)).collect();
    ratios.sort_by(f64::total_cmp);
    let last = ratios.len().saturating_sub(1);
    ratios.get((0.99 * last as f64).round() as usize).map_or(1.0, |of| of.max(1.0))
}

fn warnings(combination: &Combination, errors: &CombinedErrors) -> Vec<String> {
    let mut warnings = Vec::new();
    let is_poor = errors.direction_rms_error_deg.is_none_or(|of| of > POOR_DEG)
        || errors.speed_rms_error.is_none_or(|of| of > POOR_SPEED);
    if is_poor {
        let sentence =
            "the errors in winds that were left out are large: more directions, or instruments that see more";
        warnings.push(sentence.to_owned());
    }
    let [slowest, fastest] = combination.speeds_m_s;
    if fastest < SPEED_RATIO * slowest {
        warnings.push(format!(
            "the known winds have {slowest:.2} to {fastest:.2} m/s: all others will be extrapolated, by answers that grow with the speed"
        ));
    }
    warnings
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
            kind: of.kind,
            left_of_speed: (squares.sum::<f64>() / combination.left.len() as f64).sqrt(),
        }
    };
    combination.instruments.iter().map(report).collect()
}

impl CombinedReport {
    /// Report of the estimates of all rows.
    pub fn new(
        combination: &Combination,
        readings: &CombinedReadings,
        estimates: &[Option<CombinedWind>],
        which: RowsThatCount,
    ) -> Self {
        let rows = readings.stretches(which).concat();
        let flagged = |which: &dyn Fn(&CombinedWind) -> bool| {
            rows.iter().filter(|row| estimates[**row].as_ref().is_some_and(which)).count()
        };
        let pairs: Vec<_> = rows.iter().filter_map(|row| Some((estimates[*row], readings.true_wind(*row)?))).collect();
        Self {
            made_from: combination.made_from.clone(),
            rows: rows.len(),
            failed: rows.iter().filter(|row| estimates[**row].is_none()).count(),
            ambiguous: flagged(&|of| of.is_ambiguous),
            inconsistent: flagged(&|of| of.is_inconsistent),
            extrapolated: flagged(&|of| of.is_extrapolated),
            no_direction: flagged(&|of| of.has_no_direction),
            degraded: flagged(&|of| of.is_degraded),
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
        writeln!(f, "  speed      {rms:.2} % rms, {mean:.2} % mean, {worst:.2} % at worst")?;
        let Some((direction, speed)) = self.direction_within_2u.zip(self.speed_within_2u) else { return Ok(()) };
        write!(f, "  within twice the standard uncertainty, of estimates without a flag: ")?;
        writeln!(f, "direction {:.0} %, speed {:.0} %", 100.0 * direction, 100.0 * speed)
    }
}

impl fmt::Display for CombinationReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (instruments, mut winds) = (count(self.instruments.len(), "instrument"), count(self.winds, "known wind"));
        if self.fitted < self.winds {
            winds = format!("{} of {winds}", self.fitted);
        }
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
            let kind = match of.kind {
                InstrumentKind::Vector => String::new(),
                kind => format!(", {}", kind.name()),
            };
            let (components, left) = (count(of.components, "component"), 100.0 * of.left_of_speed);
            writeln!(f, "  {:<16} {components}{kind}, known to {left:.1} %", of.name)?;
        }
        write!(f, "\nin winds that were left out, direction by direction\n{}", self.cross_validated)?;
        self.warnings.iter().try_for_each(|warning| writeln!(f, "warning: {warning}"))?;
        self.written.iter().try_for_each(|path| writeln!(f, "\nwritten to {}", path.display()))
    }
}

impl fmt::Display for CombinedReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "combined by {}", self.made_from)?;
        let rows = count(self.rows, "row");
        writeln!(f, "{rows} that count, {} without a wind", self.failed)?;
        let flagged = [
            (self.ambiguous, "ambiguous: another direction fits about as well"),
            (self.inconsistent, "inconsistent: the instruments do not say the same"),
            (self.extrapolated, "extrapolated: beyond the speeds of the known winds"),
            (self.no_direction, "no-direction: its standard uncertainty is above 20°"),
            (self.degraded, "degraded: an instrument has no estimate"),
        ];
        for (rows, what) in flagged.into_iter().filter(|(rows, _)| *rows > 0) {
            writeln!(f, "{rows:>6}  {what}")?;
        }
        if let Some(errors) = &self.comparison {
            write!(f, "\ncompared with the true wind, {}\n{errors}", count(errors.compared, "estimate"))?;
        }
        self.written.iter().try_for_each(|path| writeln!(f, "\nwritten to {}", path.display()))
    }
}
