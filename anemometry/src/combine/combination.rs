//! How several instruments answer to winds from everywhere, fitted to known winds.

use nalgebra::{DMatrix, Matrix3, SymmetricEigen, Vector3};
use serde::{Deserialize, Serialize};

use super::instrument::InstrumentReading;
use super::readings::KnownWind;
use super::space::WindSpace;
use crate::vector::{angle_deg, dot, length, unit};
use recording::text;

/// Winds a function, at least.
const WINDS_A_FUNCTION: f64 = 1.5;
/// A component whose size is a smaller share of the greatest is none.
const NO_COMPONENT: f64 = 1e-3;
/// What is never known better of a component, of the speed.
const LEAST_SHARE: f64 = 1e-3;
/// Residuals count for a direction by e^(κ (cos − 1)): those within 25°.
const CONCENTRATION: f64 = 10.0;
/// Directions among which a gap between the known winds is sought.
const SOUGHT: usize = 200;
/// The widest way from there to the nearest known wind, °.
const WIDEST_DEG: f64 = 60.0;

/// Why instruments cannot be combined: a sentence.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct CombineError(pub String);

/// Instruments that were calibrated together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Combination {
    /// Winds and errors, in words.
    pub made_from: String,
    /// Where the winds are from.
    pub space: WindSpace,
    /// Of the functions of the direction.
    pub degree: usize,
    /// Least and greatest speed of the winds, m/s.
    pub speeds_m_s: [f64; 2],
    /// One an instrument, in the order of the files.
    pub instruments: Vec<InstrumentAnswer>,
    /// What these leave of known winds that were left out.
    pub left: Vec<LeftOver>,
}

/// What an instrument answers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InstrumentAnswer {
    /// Name of its file, without the ending.
    pub name: String,
    /// What it is, as its file says; empty if it does not.
    pub what: String,
    /// Whether it knows no speed.
    pub is_direction: bool,
    /// Directions in its frame in which it has estimates, one to three.
    pub axes: Vec<[f64; 3]>,
    /// By axis: c.
    pub coefficients: Vec<Vec<f64>>,
}

/// What is left of one wind.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LeftOver {
    /// v/|v|
    pub towards: [f64; 3],
    /// By component of all instruments, of the speed.
    pub shares: Vec<f64>,
}

impl Combination {
    /// Fits instruments to known winds.
    ///
    /// # Errors
    /// If there are too few winds, they are not from everywhere or all around a plane, or the
    /// instruments do not see enough of them.
    pub fn fit(names: &[String], whats: &[String], known: &[KnownWind]) -> Result<Self, CombineError> {
        if known.is_empty() {
            let sentence =
                "no wind is known: the first file has no true winds in rows that count, or --winds not its labels";
            return Err(CombineError(sentence.to_owned()));
        }
        let whole: Vec<&KnownWind> = known.iter().filter(|of| of.readings.iter().all(Option::is_some)).collect();
        let towards: Vec<[f64; 3]> = whole.iter().map(|of| unit(of.wind_m_s)).collect();
        let space = WindSpace::of(&towards);
        let enough = |degree: usize| WINDS_A_FUNCTION * space.count(degree) as f64 <= whole.len() as f64;
        if !enough(1) {
            let seen_by = |i: usize| known.iter().filter(|of| of.readings[i].is_some()).count();
            let least = (0..names.len()).map(|i| (seen_by(i), &names[i])).min();
            let least = least.map_or_else(String::new, |(seen, name)| format!(" ({name}: {seen})"));
            return Err(CombineError(format!(
                "{} known winds of {} have estimates of all instruments{least}; 100 do well, from everywhere or all around a plane",
                whole.len(),
                known.len()
            )));
        }
        spread(space, &towards)?;
        let axes: Vec<Vec<[f64; 3]>> = (0..names.len()).map(|i| axes(&whole, i)).collect();
        let components: usize = axes.iter().map(Vec::len).sum();
        if components < space.dimensions() {
            return Err(CombineError(format!(
                "all instruments together have {}, and these winds have {}",
                text::count(components, "component"),
                space.dimensions()
            )));
        }
        let shares: Vec<Vec<f64>> = whole.iter().map(|of| shares_of(of, &axes)).collect();
        let shares = DMatrix::from_fn(whole.len(), components, |row, k| shares[row][k]);
        let fits = (1..=space.most_degree()).filter(|degree| enough(*degree));
        let fits = fits.filter_map(|degree| DirectionFit::of(space, &towards, &shares, degree));
        let best = fits.min_by(|a, b| a.left.norm_squared().total_cmp(&b.left.norm_squared()));
        let best =
            best.ok_or_else(|| CombineError("the winds do not determine how the instruments answer".to_owned()))?;
        let mut columns = best.coefficients.column_iter().map(|of| of.iter().copied().collect());
        let answer = |((i, axes), reading): ((usize, Vec<[f64; 3]>), &Option<InstrumentReading>)| InstrumentAnswer {
            name: names[i].clone(),
            what: whats[i].clone(),
            is_direction: reading.is_some_and(|of| of.is_direction),
            coefficients: columns.by_ref().take(axes.len()).collect(),
            axes,
        };
        let instruments: Vec<_> = axes.into_iter().enumerate().zip(&whole[0].readings).map(answer).collect();
        if instruments.iter().all(|of| of.is_direction) {
            return Err(CombineError("no instrument knows a speed".to_owned()));
        }
        let speeds = whole.iter().map(|of| length(of.wind_m_s));
        let left = towards.iter().zip(best.left.row_iter());
        let left = left.map(|(towards, row)| LeftOver { towards: *towards, shares: row.iter().copied().collect() });
        Ok(Self {
            made_from: String::new(),
            space,
            degree: best.degree,
            speeds_m_s: [speeds.clone().fold(f64::INFINITY, f64::min), speeds.fold(0.0, f64::max)],
            instruments,
            left: left.collect(),
        })
    }

    /// Number of components of all instruments.
    pub fn components(&self) -> usize {
        self.instruments.iter().map(|of| of.axes.len()).sum()
    }

    /// The components in a unit wind in a direction.
    pub fn answers(&self, towards: [f64; 3]) -> Vec<f64> {
        let values = self.space.functions(towards, self.degree);
        let sum = |of: &Vec<f64>| of.iter().zip(&values).map(|(c, y)| c * y).sum();
        self.instruments.iter().flat_map(|of| &of.coefficients).map(sum).collect()
    }

    /// s²: what answers leave of winds from about there, of the speed.
    pub fn variances(&self, towards: [f64; 3]) -> Vec<f64> {
        let (mut sums, mut weights) = (vec![0.0; self.components()], 0.0);
        for of in &self.left {
            let weight = (CONCENTRATION * (dot(towards, of.towards) - 1.0)).exp();
            weights += weight;
            sums.iter_mut().zip(&of.shares).for_each(|(sum, share)| *sum += weight * share * share);
        }
        sums.into_iter().map(|sum| sum / weights + LEAST_SHARE * LEAST_SHARE).collect()
    }
}

/// Components of what instruments say in a known wind, of its speed.
fn shares_of(of: &KnownWind, axes: &[Vec<[f64; 3]>]) -> Vec<f64> {
    let speed_m_s = length(of.wind_m_s);
    let share = |reading: &InstrumentReading, axis: &[f64; 3]| {
        dot(reading.wind_m_s, *axis) / if reading.is_direction { 1.0 } else { speed_m_s }
    };
    let each = of.readings.iter().flatten().zip(axes);
    each.flat_map(|(reading, axes)| axes.iter().map(move |axis| share(reading, axis))).collect()
}

/// The directions in which an instrument has estimates.
fn axes(winds: &[&KnownWind], instrument: usize) -> Vec<[f64; 3]> {
    let moments: Matrix3<f64> = winds
        .iter()
        .filter_map(|of| of.readings[instrument])
        .map(|of| Vector3::from(of.wind_m_s))
        .map(|of| of * of.transpose())
        .sum();
    let eigen = SymmetricEigen::new(moments);
    let most = eigen.eigenvalues.max();
    let mut order: Vec<usize> = (0..3).filter(|k| eigen.eigenvalues[*k] > NO_COMPONENT * NO_COMPONENT * most).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    order.into_iter().map(|k| eigen.eigenvectors.column(k).into_owned().into()).collect()
}

/// Refuses winds that leave a part of the directions out.
fn spread(space: WindSpace, towards: &[[f64; 3]]) -> Result<(), CombineError> {
    let nearest_deg = |of: [f64; 3]| towards.iter().map(|known| angle_deg(*known, of)).fold(180.0, f64::min);
    let all = space.even_directions(SOUGHT).into_iter().map(|of| (nearest_deg(of), of));
    let (off_deg, worst) = all.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default();
    if off_deg <= WIDEST_DEG {
        return Ok(());
    }
    // Without a minus before a zero.
    let [x, y, z] = worst.map(|x| (10.0 * x).round() / 10.0 + 0.0);
    let where_from = if space == WindSpace::Everywhere { "from everywhere" } else { "all around their plane" };
    Err(CombineError(format!(
        "the known wind next to one that goes to ({x}, {y}, {z}) is {off_deg:.0}° off, and {WIDEST_DEG}° are the most: winds {where_from} \
         are needed"
    )))
}

/// Least squares by functions of one degree.
struct DirectionFit {
    degree: usize,
    /// Function by component.
    coefficients: DMatrix<f64>,
    /// What is left of each wind where it is left out, by component.
    left: DMatrix<f64>,
}

impl DirectionFit {
    fn of(space: WindSpace, towards: &[[f64; 3]], shares: &DMatrix<f64>, degree: usize) -> Option<Self> {
        let rows: Vec<Vec<f64>> = towards.iter().map(|of| space.functions(*of, degree)).collect();
        let design = DMatrix::from_fn(rows.len(), space.count(degree), |row, k| rows[row][k]);
        let inverse = (design.transpose() * &design).cholesky()?.inverse();
        let coefficients = &inverse * design.transpose() * shares;
        let mut left = shares - &design * &coefficients;
        for row in 0..rows.len() {
            let own = (design.row(row) * &inverse * design.row(row).transpose())[0];
            left.row_mut(row).scale_mut(1.0 / (1.0 - own).max(f64::EPSILON));
        }
        Some(Self { degree, coefficients, left })
    }
}
