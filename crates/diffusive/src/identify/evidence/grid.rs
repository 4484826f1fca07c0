//! Rates on which all hypotheses of a record stand, and the prior over them.

use std::f64::consts::{PI, TAU};

use dr_core::model::mesh;
use nalgebra::{Cholesky, DMatrix};

use super::columns::OutputTable;

/// Rates a decade on which a spectrum is weighed, and on which paths are compared.
pub const FINE: f64 = 7.0;
pub const COARSE: f64 = 3.5;
/// Poles of filters a decade.
const POLES: f64 = 2.5;
/// The slowest rate, in units of 2π/T.
const LOWEST: f64 = 0.05;
/// The rate that stands for heat which arrives within a sample, times the sample period: e^−36 is
/// nothing in f64.
const AT_ONCE: f64 = 36.0;
/// Power by which a spectrum falls below its slowest rate.
const STEEPNESS: f64 = 2.0;
/// Rates at most: thirteen decades.
const MOST_RATES: usize = 96;

/// Rates, poles of filters, and the times they belong to.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// Geometric; behind them one infinitely fast.
    pub rates_rad_s: Vec<f64>,
    pub poles_rad_s: Vec<f64>,
    pub duration_s: f64,
    pub period_s: f64,
    per_decade: f64,
}

/// Shape of a prior: correlation length in decades, slowest rate of the body in 2π/T, and the power
/// by which it falls towards fast rates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shape {
    pub correlation: f64,
    pub corner: f64,
    pub tilt: f64,
}

impl Shape {
    /// The shape by which paths are compared.
    pub const PLAIN: Self = Self { correlation: 0.15, corner: 1.0, tilt: 0.5 };

    /// All shapes, each as likely as another.
    pub fn all() -> Vec<Self> {
        let mut shapes = Vec::new();
        for correlation in [0.15, 0.5] {
            for corner in [0.1, 0.2, 0.45, 1.0, 2.2, 4.5, 10.0] {
                shapes.extend([0.0, 0.5].map(|tilt| Self { correlation, corner, tilt }));
            }
        }
        shapes
    }
}

impl Grid {
    /// The grid of the first `rows` rows of a record.
    pub fn of(table: &OutputTable, rows: usize, per_decade: f64) -> Self {
        let (duration_s, period_s) = (table.duration_s(rows), table.period_s);
        let (low, high) = (LOWEST * TAU / duration_s, PI / period_s);
        let decades = libm::log10(high / low);
        let order = ((decades * per_decade).round() as usize + 1).clamp(4, MOST_RATES);
        let mut rates_rad_s: Vec<f64> = (0..order).map(|k| mesh::rate_rad_s(low, high, k, order)).collect();
        let middles: Vec<f64> = rates_rad_s.windows(2).map(|two| (two[0] * two[1]).sqrt()).collect();
        let step = (((order - 1) as f64 / decades / POLES).round() as usize).max(1);
        let mut poles_rad_s: Vec<f64> = middles.into_iter().rev().step_by(step).collect();
        poles_rad_s.reverse();
        poles_rad_s.retain(|pole| *pole > 3.0 / duration_s && !table.is_uneven());
        rates_rad_s.push(AT_ONCE / period_s);
        Self { rates_rad_s, poles_rad_s, duration_s, period_s, per_decade }
    }

    /// A factor of the prior covariance of one spectrum, which has unit variance at its highest.
    pub fn prior(&self, shape: Shape) -> DMatrix<f64> {
        let finite = &self.rates_rad_s[..self.rates_rad_s.len() - 1];
        let fastest = finite[finite.len() - 1] * libm::pow(10.0, 1.0 / self.per_decade);
        let decades: Vec<f64> = finite.iter().chain([&fastest]).map(|rate| libm::log10(*rate)).collect();
        let corner = shape.corner * TAU / self.duration_s;
        let size = |decade: &f64| {
            let above = libm::pow(10.0, *decade) / corner;
            libm::pow(above.min(1.0), STEEPNESS) * libm::pow(above.max(1.0), -shape.tilt)
        };
        let sizes: Vec<f64> = decades.iter().map(size).collect();
        let count = decades.len();
        let correlations = DMatrix::from_fn(count, count, |i, j| {
            let own = if i == j { 1e-9 } else { 0.0 };
            libm::exp(-(decades[i] - decades[j]).abs() / shape.correlation) + own
        });
        let factor = Cholesky::new(correlations).map_or_else(|| DMatrix::identity(count, count), Cholesky::unpack);
        DMatrix::from_fn(count, count, |i, j| sizes[i] * factor[(i, j)])
    }
}
