//! How several instruments answer to winds from everywhere, fitted to known winds.

use nalgebra::{DMatrix, Matrix3, SymmetricEigen, Vector3};
use serde::{Deserialize, Serialize};

use super::harmonics::{count, harmonics};
use super::readings::{InstrumentReading, KnownWind};
use crate::vector::{dot, length, unit};

/// Degrees that are tried.
const MOST_DEGREE: usize = 8;
/// Winds a coefficient, at least.
const WINDS_A_COEFFICIENT: f64 = 1.5;
/// A component whose size is a smaller share of the greatest is none.
const NO_COMPONENT: f64 = 1e-3;
/// What is never known better of a component, of the speed.
const LEAST_SHARE: f64 = 1e-3;
/// Residuals count for a direction by e^(κ (cos − 1)): those within 25°.
const CONCENTRATION: f64 = 10.0;

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
    /// Of the harmonics.
    pub degree: usize,
    /// Least and greatest speed of the winds, m/s.
    pub speeds_m_s: [f64; 2],
    /// One an instrument, in the order of the files.
    pub instruments: Vec<InstrumentAnswer>,
    /// What the harmonics leave of known winds that were left out.
    pub left: Vec<LeftOver>,
}

/// What an instrument answers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InstrumentAnswer {
    /// Name of its file, without the ending.
    pub name: String,
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
    /// If there are too few winds, or they are not from everywhere.
    pub fn fit(names: &[String], known: &[KnownWind]) -> Result<Self, CombineError> {
        let whole: Vec<&KnownWind> = known.iter().filter(|of| of.readings.iter().all(Option::is_some)).collect();
        let least = (WINDS_A_COEFFICIENT * count(1) as f64).ceil() as usize;
        if whole.len() < least {
            return Err(CombineError(format!(
                "{} known winds have estimates of all instruments, and at least {least} are needed, from everywhere; 100 do well",
                whole.len()
            )));
        }
        spread(&whole)?;
        let axes: Vec<Vec<[f64; 3]>> = (0..names.len()).map(|i| axes(&whole, i)).collect();
        if let Some(none) = axes.iter().position(Vec::is_empty) {
            return Err(CombineError(format!("{} estimates no wind at all", names[none])));
        }
        let components: usize = axes.iter().map(Vec::len).sum();
        if components < 3 {
            return Err(CombineError(format!(
                "all instruments together have {components} components of the wind, and a vector has 3"
            )));
        }
        let towards: Vec<[f64; 3]> = whole.iter().map(|of| unit(of.wind_m_s)).collect();
        let shares = DMatrix::from_fn(whole.len(), components, |row, column| {
            let (mut place, of) = (column, whole[row]);
            for (axes, reading) in axes.iter().zip(&of.readings) {
                match axes.get(place) {
                    Some(axis) => return along(reading, *axis) / length(of.wind_m_s),
                    None => place -= axes.len(),
                }
            }
            0.0
        });
        let tried = (1..=MOST_DEGREE)
            .filter(|degree| *degree == 1 || WINDS_A_COEFFICIENT * count(*degree) as f64 <= whole.len() as f64);
        let fits = tried.filter_map(|degree| HarmonicFit::of(&towards, &shares, degree));
        let best = fits.min_by(|a, b| a.left.norm_squared().total_cmp(&b.left.norm_squared()));
        let best =
            best.ok_or_else(|| CombineError("the winds do not determine how the instruments answer".to_owned()))?;
        let mut column = 0;
        let mut instruments = Vec::new();
        for (name, axes) in names.iter().zip(axes) {
            let coefficients =
                (column..column + axes.len()).map(|k| best.coefficients.column(k).iter().copied().collect());
            let coefficients: Vec<Vec<f64>> = coefficients.collect();
            column += axes.len();
            instruments.push(InstrumentAnswer { name: name.clone(), axes, coefficients });
        }
        let speeds = whole.iter().map(|of| length(of.wind_m_s));
        let left = towards
            .iter()
            .enumerate()
            .map(|(row, towards)| LeftOver { towards: *towards, shares: best.left.row(row).iter().copied().collect() });
        Ok(Self {
            made_from: String::new(),
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
        let values = harmonics(towards, self.degree);
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

/// A component of an instrument's estimate, m/s.
pub(super) fn along(reading: &Option<InstrumentReading>, axis: [f64; 3]) -> f64 {
    reading.map_or(f64::NAN, |of| dot(of.wind_m_s, axis))
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

/// Refuses winds that leave a part of the sphere out.
fn spread(winds: &[&KnownWind]) -> Result<(), CombineError> {
    const WIDEST_DEG: f64 = 60.0;
    let nearest = |direction: &[f64; 3]| {
        winds
            .iter()
            .map(|of| dot(unit(of.wind_m_s), *direction))
            .fold(-1.0, f64::max)
            .clamp(-1.0, 1.0)
            .acos()
            .to_degrees()
    };
    let worst = super::harmonics::even_directions(200).into_iter().map(|of| (nearest(&of), of));
    let (off, [x, y, z]) = worst.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default();
    if off <= WIDEST_DEG {
        return Ok(());
    }
    Err(CombineError(format!(
        "no known wind is within {off:.0}° of one that goes to ({x:.1}, {y:.1}, {z:.1}): winds from everywhere are needed"
    )))
}

/// Least squares by harmonics of one degree.
struct HarmonicFit {
    degree: usize,
    /// Harmonic by component.
    coefficients: DMatrix<f64>,
    /// What is left of each wind where it is left out, by component.
    left: DMatrix<f64>,
}

impl HarmonicFit {
    fn of(towards: &[[f64; 3]], shares: &DMatrix<f64>, degree: usize) -> Option<Self> {
        let rows: Vec<Vec<f64>> = towards.iter().map(|of| harmonics(*of, degree)).collect();
        let design = DMatrix::from_fn(rows.len(), count(degree), |row, k| rows[row][k]);
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
