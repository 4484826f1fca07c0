//! Answers of several instruments to winds from everywhere, fitted to known winds.

use nalgebra::{DMatrix, DVector, Matrix3, SymmetricEigen, Vector3};
use recording::text;
use serde::{Deserialize, Serialize};

use super::instrument::{InstrumentKind, InstrumentReading, variance};
use super::readings::KnownWind;
use super::space::{DirectionFit, KnownDirections, WindSpace};

use crate::vector::{dot, length, unit};

/// A component whose size is a smaller share of the greatest is none.
const NO_COMPONENT: f64 = 1e-3;
/// Least uncertainty of a component, of the speed.
const LEAST_SHARE: f64 = 1e-3;
/// Residuals count for a direction by e^(κ (cos − 1)): those within 25°.
const CONCENTRATION: f64 = 10.0;
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
    /// Degree of the functions of the direction.
    pub degree: usize,
    /// Least and greatest speed of the winds, m/s.
    pub speeds_m_s: [f64; 2],
    /// One an instrument, in the order of the files.
    pub instruments: Vec<InstrumentAnswer>,
    /// 99th percentile of χ² in winds that were left out, over that of chance; 1 at least.
    pub chi_square_ratio: f64,
    /// Residuals of known winds that were left out.
    pub left: Vec<LeftOver>,
}

/// Answers of an instrument.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InstrumentAnswer {
    /// Name of its file, without the ending.
    pub name: String,
    /// Description of it, as its file says; empty if it does not.
    pub what: String,
    /// Kind of its knowledge.
    pub kind: InstrumentKind,
    /// Directions in its frame in which it has estimates, one to three.
    pub axes: Vec<[f64; 3]>,
    /// By axis: c.
    pub coefficients: Vec<Vec<f64>>,
}

/// Residual of one wind.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LeftOver {
    /// v/|v|
    pub towards: [f64; 3],
    /// By component of all instruments, of the speed.
    pub shares: Vec<f64>,
    /// Variance of single rows about their mean, beyond what the instrument states, likewise.
    pub scatter: Vec<f64>,
}

impl Combination {
    /// Fits instruments to known winds.
    ///
    /// # Errors
    /// If there are too few winds, they are not from everywhere or all around a plane, or the
    /// instruments do not see enough of them.
    pub fn fit(names: &[String], whats: &[String], known: &[KnownWind]) -> Result<Self, CombineError> {
        if known.is_empty() {
            let why = "the first file has no true winds in rows that count, or --winds not its labels";
            return Err(CombineError(format!("no wind is known: {why}")));
        }
        let whole: Vec<&KnownWind> = known.iter().filter(|of| of.readings.iter().all(Option::is_some)).collect();
        let directions = KnownDirections::new(whole.iter().map(|of| unit(of.wind_m_s)).collect());
        let space = directions.space;
        if !directions.are_enough(1) {
            let seen_by = |i: usize| known.iter().filter(|of| of.readings[i].is_some()).count();
            let least = (0..names.len()).map(|i| (seen_by(i), &names[i])).min();
            let least = least.map_or_else(String::new, |(seen, name)| format!(" ({name}: {seen})"));
            let (known, seen) = (text::count(known.len(), "known wind"), text::count(directions.count, "direction"));
            let have = format!("{} of {known} have estimates of all instruments{least}, in {seen}", whole.len());
            let needed = format!("{} directions are the least", directions.least());
            let sentence = format!("{have}; {needed}, and 100 winds from everywhere or all around a plane do well");
            return Err(CombineError(sentence));
        }
        spread(&directions)?;
        let axes: Vec<Vec<[f64; 3]>> = (0..names.len()).map(|i| axes(&whole, i)).collect();
        let components: usize = axes.iter().map(Vec::len).sum();
        if components < space.dimensions() {
            let (own, winds) = (text::count(components, "component"), space.dimensions());
            return Err(CombineError(format!("all instruments together have {own}, and these winds have {winds}")));
        }
        let shares: Vec<Vec<f64>> = whole.iter().map(|of| shares_of(of, &axes)).collect();
        let shares = DMatrix::from_fn(whole.len(), components, |row, k| shares[row][k]);
        let fits = (1..=space.most_degree()).filter(|degree| directions.are_enough(*degree));
        let fits = fits.filter_map(|degree| DirectionFit::of(&directions, &shares, degree));
        let best = fits.min_by(|a, b| a.left.norm_squared().total_cmp(&b.left.norm_squared()));
        let best =
            best.ok_or_else(|| CombineError("the winds do not determine how the instruments answer".to_owned()))?;
        let mut columns = best.coefficients.column_iter().map(|of| of.iter().copied().collect());
        let answer = |((i, axes), reading): ((usize, Vec<[f64; 3]>), &Option<InstrumentReading>)| InstrumentAnswer {
            name: names[i].clone(),
            what: whats[i].clone(),
            kind: reading.map_or(InstrumentKind::Vector, |of| of.kind),
            coefficients: columns.by_ref().take(axes.len()).collect(),
            axes,
        };
        let instruments: Vec<_> = axes.into_iter().enumerate().zip(&whole[0].readings).map(answer).collect();
        if instruments.iter().all(|of| of.kind == InstrumentKind::Direction) {
            return Err(CombineError("no instrument knows a speed".to_owned()));
        }
        let speeds = whole.iter().map(|of| length(of.wind_m_s));
        let left = directions.towards.iter().zip(best.left.row_iter()).zip(&whole);
        let left = left.map(|((towards, row), of)| LeftOver {
            towards: *towards,
            shares: row.iter().copied().collect(),
            scatter: scatter_of(of, &instruments),
        });
        let left = left.collect();
        Ok(Self {
            made_from: String::new(),
            space,
            degree: best.degree,
            speeds_m_s: [speeds.clone().fold(f64::INFINITY, f64::min), speeds.fold(0.0, f64::max)],
            instruments,
            chi_square_ratio: 1.0,
            left,
        })
    }

    /// Content of its file that no combination can have, as a sentence.
    pub fn problem(&self) -> Option<String> {
        let components = self.components();
        let functions = match self.degree {
            0 => 0,
            degree if degree > self.space.most_degree() => 0,
            degree => self.space.count(degree),
        };
        if functions == 0 {
            return Some(format!("has functions of degree {}", self.degree));
        }
        let fits = |of: &InstrumentAnswer| {
            (1..=3).contains(&of.axes.len())
                && of.coefficients.len() == of.axes.len()
                && of.coefficients.iter().all(|of| of.len() == functions)
        };
        if let Some(of) = self.instruments.iter().find(|of| !fits(of)) {
            return Some(format!("has not {functions} coefficients for each of one to three axes of `{}`", of.name));
        }
        if self.left.is_empty()
            || self.left.iter().any(|of| [&of.shares, &of.scatter].iter().any(|of| of.len() != components))
        {
            return Some(format!("has not {components} shares and scatters for each of its known winds"));
        }
        let is_unit = |of: &[f64; 3]| (length(*of) - 1.0).abs() < 1e-6;
        let normal = match self.space {
            WindSpace::Everywhere => None,
            WindSpace::Across(normal) => Some(normal),
        };
        if !self.instruments.iter().flat_map(|of| &of.axes).chain(&normal).all(is_unit) {
            return Some("has an axis or a normal whose length is not 1".to_owned());
        }
        let [slowest, fastest] = self.speeds_m_s;
        (slowest > fastest).then(|| format!("has known winds of {slowest} to {fastest} m/s"))
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

    /// Variances that answers leave of winds from about there, of the speed: by component its
    /// variance, and that of rows beyond what is stated.
    pub fn variances(&self, towards: [f64; 3]) -> Vec<[f64; 2]> {
        let (mut sums, mut weights) = (vec![[0.0; 2]; self.components()], 0.0);
        for of in &self.left {
            let weight = libm::exp(CONCENTRATION * (dot(towards, of.towards) - 1.0));
            weights += weight;
            for (sum, (share, scatter)) in sums.iter_mut().zip(of.shares.iter().zip(&of.scatter)) {
                *sum = [sum[0] + weight * share * share, sum[1] + weight * scatter];
            }
        }
        sums.into_iter()
            .map(|[left, scatter]| [left / weights, scatter / weights + LEAST_SHARE * LEAST_SHARE])
            .collect()
    }

    /// Correlation of what is left of the components: what the known winds did to several
    /// instruments alike, as a boom does that follows slowly. Drawn to none by as many winds as
    /// there are components.
    pub fn correlation(&self) -> DMatrix<f64> {
        let components = self.components();
        let mut sums = DMatrix::zeros(components, components);
        for of in &self.left {
            let variances = self.variances(of.towards);
            let units = variances.iter().zip(&of.shares).map(|([left, _], share)| share / left.sqrt().max(LEAST_SHARE));
            let units = DVector::from_iterator(components, units);
            sums += &units * units.transpose();
        }
        let known = self.left.len() as f64 / (self.left.len() + components) as f64;
        DMatrix::from_fn(components, components, |i, j| match i == j {
            true => 1.0,
            false => known * sums[(i, j)] / (sums[(i, i)] * sums[(j, j)]).sqrt().max(f64::MIN_POSITIVE),
        })
    }
}

/// Components of what instruments say in a known wind, of its speed.
fn shares_of(of: &KnownWind, axes: &[Vec<[f64; 3]>]) -> Vec<f64> {
    let share = |reading: &InstrumentReading, axis: &[f64; 3]| {
        dot(reading.wind_m_s, *axis) / reading.kind.scale(length(of.wind_m_s))
    };
    let each = of.readings.iter().flatten().zip(axes);
    each.flat_map(|(reading, axes)| axes.iter().map(move |axis| share(reading, axis))).collect()
}

/// Variances of the components' rows about their means, beyond what is stated, of the speed.
fn scatter_of(of: &KnownWind, instruments: &[InstrumentAnswer]) -> Vec<f64> {
    let each = of.readings.iter().flatten().zip(&of.scatter).zip(instruments);
    let beyond = |reading: &InstrumentReading, scatter: &Matrix3<f64>, axis: [f64; 3]| {
        (variance(scatter, axis) - reading.variance(axis)).max(0.0) / reading.kind.scale(length(of.wind_m_s)).powi(2)
    };
    let all = each.flat_map(|((reading, scatter), of)| of.axes.iter().map(move |axis| beyond(reading, scatter, *axis)));
    all.collect()
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
fn spread(directions: &KnownDirections) -> Result<(), CombineError> {
    let (off_deg, worst) = directions.widest;
    if off_deg <= WIDEST_DEG {
        return Ok(());
    }
    // Without a minus before a zero.
    let [x, y, z] = worst.map(|x| (10.0 * x).round() / 10.0 + 0.0);
    let where_from =
        if directions.space == WindSpace::Everywhere { "from everywhere" } else { "all around their plane" };
    Err(CombineError(format!(
        "the known wind next to one that goes to ({x}, {y}, {z}) is {off_deg:.0}° off, and {WIDEST_DEG}° are the most: winds {where_from} \
         are needed"
    )))
}
