//! Marginal likelihood of one hypothesis, and what it says of the gains.
//!
//! ```text
//! y = Aθ + offset + e,    θ = B w,    w ~ N(0, r σ²),    e ~ N(0, σ²)
//! ln p(y | r) = −n/2 ln(S/n) − ½ ln det(1 + r BᵀAᵀAB) + …,    S = min (|y − Aθ|² + |w|²/r)
//! ```
//!
//! The noise's variance is integrated out, the offset is flat. One bidiagonal form of A B serves all
//! r (L. Eldén, *BIT* 17 (1977) 134); squares of A B would lose the digits that small noise needs.

use nalgebra::linalg::Bidiagonal;
use nalgebra::{DMatrix, DVector};

use super::columns::{Columns, OutputTable, extremes};
use super::factor::TriangularFactor;
use super::grid::{Grid, Shape};
use crate::identify::drift::NoiseFilter;
use crate::identify::options::InitialState;

/// ln of the prior's standard deviation of gain times range of power, in units of the noise.
const SCALES: [f64; 21] = {
    let mut scales = [0.0; 21];
    let mut at = 0;
    while at < scales.len() {
        scales[at] = -1.0 + 0.75 * at as f64;
        at += 1;
    }
    scales
};

/// One relaxation hardly rises by more than so many ranges of the output.
const HIGHEST: f64 = 3.0;
/// Least part of the output's sum of squares that f64 resolves.
const RESOLVED: f64 = 1e-14;

/// Units of a record: ranges of its inputs, spread and range of its output.
#[derive(Debug, Clone)]
pub struct Units {
    ranges: Vec<f64>,
    /// Each input's effect beside that of the others.
    pub relative: Vec<f64>,
    spread: f64,
    range: f64,
}

impl Units {
    pub fn of(table: &OutputTable, rows: usize) -> Self {
        let range = |input| {
            let values = table.input(input, rows);
            let (least, greatest) = extremes(&values);
            spread(&values).max(0.3 * (greatest.max(0.0) - least.min(0.0))) + 1e-300
        };
        let output = table.output(rows);
        let (least, greatest) = extremes(&output);
        Self {
            ranges: (0..table.inputs()).map(range).collect(),
            relative: vec![1.0; table.inputs()],
            spread: spread(&output).max(1e-12),
            range: (greatest - least).max(1e-12),
        }
    }
}

fn spread(values: &[f64]) -> f64 {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt()
}

/// Mean and variance of a sum of parameters.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Moments {
    pub mean: f64,
    pub variance: f64,
}

/// Gain of one input under a hypothesis.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Effect {
    pub gain: Moments,
    /// The part of the gain at rates below 2π/T.
    pub slow: Moments,
    /// The mean of the part at rates below 4π/T.
    pub verge: f64,
}

/// A hypothesis with one scale of its prior.
#[derive(Debug, Clone)]
pub struct Scaled {
    /// ln of the marginal likelihood, but for what all have in common.
    pub ln: f64,
    /// r
    pub scale: f64,
    pub noise_variance: f64,
    pub effects: Vec<Effect>,
}

/// Parameters and their covariance, in the order of the terms; the offset last.
#[derive(Debug, Clone)]
pub struct Posterior {
    pub theta: DVector<f64>,
    pub covariance: DMatrix<f64>,
}

/// A record's problem under one drift and initial state, with the offset taken out.
pub struct Problem<'a> {
    grid: &'a Grid,
    units: &'a Units,
    columns: &'a Columns,
    /// Upper triangular, and what is left of the output in its rows and behind them.
    a: DMatrix<f64>,
    z: DVector<f64>,
    rest: f64,
    /// Sum of squares of the offset's column, and products with it over that sum.
    offset_squares: f64,
    onto_offset: DVector<f64>,
}

impl<'a> Problem<'a> {
    pub fn of(
        columns: &'a Columns,
        grid: &'a Grid,
        units: &'a Units,
        initial_state: InitialState,
        filter: Option<&NoiseFilter>,
    ) -> Self {
        let terms = columns.terms(grid, initial_state);
        let factor = &columns.factor;
        let width = factor.width();
        let filtered = |of: &[(usize, f64)]| match filter {
            Some(filter) => columns.poles().innovations(of, filter),
            None => of.to_vec(),
        };
        let column = |of: &[(usize, f64)]| {
            let mut sum = DVector::zeros(width);
            for (column, weight) in filtered(of) {
                (0..=column).for_each(|row| sum[row] += weight * factor.at(row, column));
            }
            sum
        };
        let count = terms.len() - 1;
        let offset = column(&terms[count].of);
        let offset_squares = offset.norm_squared();
        let mut onto_offset = DVector::zeros(count + 1);
        let mut rest = DMatrix::zeros(width, count + 1);
        let output = [(columns.output(), 1.0)];
        let all = terms[..count].iter().map(|term| &term.of[..]).chain([&output[..]]);
        for (at, of) in all.enumerate() {
            let own = column(of);
            onto_offset[at] = offset.dot(&own) / offset_squares;
            rest.set_column(at, &(own - &offset * onto_offset[at]));
        }
        let small = TriangularFactor::of(&rest);
        Self {
            grid,
            units,
            columns,
            a: DMatrix::from_fn(count, count, |i, j| small.at(i, j)),
            z: DVector::from_fn(count, |i, _| small.at(i, count)),
            rest: small.at(count, count).powi(2),
            offset_squares,
            onto_offset,
        }
    }

    fn inputs(&self) -> usize {
        self.columns.key.delays.len()
    }

    /// Where the parameters of every input stand, and those of decays behind them, with the factor
    /// of their prior.
    fn blocks(&self, shape: Shape) -> Vec<(usize, DMatrix<f64>)> {
        let prior = self.grid.prior(shape);
        let order = prior.nrows();
        let of = |input: usize| (input * order, &prior * (self.units.relative[input] / self.units.ranges[input]));
        let mut blocks: Vec<_> = (0..self.inputs()).map(of).collect();
        let start = self.inputs() * order;
        if self.a.nrows() > start {
            // Stored heat is as much as inputs may have left; it counts from the first row that is read.
            let skipped_s = self.columns.key.skipped as f64 * self.grid.period_s;
            let mut decays = prior.view((0, 0), (order - 1, order - 1)).into_owned();
            for (mut row, rate) in decays.row_iter_mut().zip(&self.grid.rates_rad_s) {
                row *= libm::exp(rate * skipped_s);
            }
            blocks.push((start, decays));
        }
        blocks
    }

    /// A B, and B.
    fn scaled(&self, blocks: &[(usize, DMatrix<f64>)]) -> DMatrix<f64> {
        let mut product = DMatrix::zeros(self.a.nrows(), self.a.ncols());
        for (first, block) in blocks {
            let of = self.a.columns(*first, block.nrows()) * block;
            product.columns_mut(*first, block.ncols()).copy_from(&of);
        }
        product
    }

    /// All scales of a prior's shape.
    pub fn evidence(&self, shape: Shape) -> Vec<Scaled> {
        let blocks = self.blocks(shape);
        let (u, form, v) = Bidiagonal::new(self.scaled(&blocks)).unpack();
        let right = u.tr_mul(&self.z);
        // Weights of every sum of parameters in the bidiagonal form.
        let sums: Vec<[DVector<f64>; 3]> = blocks[..self.inputs()]
            .iter()
            .map(|(first, block)| {
                let below = |edge: f64| {
                    let limit = edge * std::f64::consts::PI / self.grid.duration_s;
                    let order = self.grid.rates_rad_s.iter().filter(|rate| **rate < limit).count();
                    let weights = block.rows(0, order).row_sum().transpose();
                    v.columns(*first, block.ncols()) * weights
                };
                [below(f64::INFINITY), below(2.0), below(4.0)]
            })
            .collect();
        let rows = (self.columns.counted as f64 - 1.0).max(2.0);
        let skipped = self.columns.key.skipped as f64 * libm::log(self.units.spread);
        let of_scale = |ln_scale: &f64| {
            let scale = libm::exp(2.0 * ln_scale);
            let solved = Regularised::of(&form, &right, scale.sqrt());
            let squares = (self.rest + solved.squares).max(RESOLVED * self.z.norm_squared() + 1e-300);
            let noise_variance = squares / rows;
            let ln = -0.5 * rows * libm::log(noise_variance)
                - solved.ln_determinant()
                - 0.5 * libm::log(self.offset_squares)
                - skipped
                - 0.5 * scale * noise_variance / (HIGHEST * self.units.range).powi(2);
            let moments = |weights: &DVector<f64>| Moments {
                mean: scale.sqrt() * weights.dot(&solved.x),
                variance: noise_variance * scale * solved.inverse_square(weights),
            };
            let effect = |[gain, slow, verge]: &[DVector<f64>; 3]| Effect {
                gain: moments(gain),
                slow: moments(slow),
                verge: scale.sqrt() * verge.dot(&solved.x),
            };
            Scaled { ln, scale, noise_variance, effects: sums.iter().map(effect).collect() }
        };
        SCALES.iter().map(of_scale).collect()
    }

    /// Posterior of all parameters with one scale.
    pub fn posterior(&self, shape: Shape, scaled: &Scaled) -> Posterior {
        let blocks = self.blocks(shape);
        let count = self.a.ncols();
        let root = scaled.scale.sqrt();
        let mut stacked = DMatrix::zeros(2 * count, count + 1);
        stacked.view_mut((0, 0), (count, count)).copy_from(&(self.scaled(&blocks) * root));
        stacked.view_mut((0, count), (count, 1)).copy_from(&self.z);
        (0..count).for_each(|at| stacked[(count + at, at)] = 1.0);
        let factor = TriangularFactor::of(&stacked);
        let r = DMatrix::from_fn(count, count, |i, j| factor.at(i, j));
        let right = DVector::from_fn(count, |i, _| factor.at(i, count));
        let mut prior = DMatrix::zeros(count, count);
        for (first, block) in &blocks {
            prior.view_mut((*first, *first), block.shape()).copy_from(block);
        }
        // R has at least the identity's rows: its diagonal is not 0.
        let inverse = r.solve_upper_triangular(&DMatrix::identity(count, count)).unwrap_or_default();
        let spread = &prior * &inverse * (root * scaled.noise_variance.sqrt());
        let own = &prior * (&inverse * right * root);
        let covariance = &spread * spread.transpose();
        // offset = (o·y − o·A θ)/o·o
        let onto = self.onto_offset.rows(0, count);
        let offset = self.onto_offset[count] - onto.dot(&own);
        let across = -(&covariance * onto);
        let variance = scaled.noise_variance / self.offset_squares - onto.dot(&across);
        let mut all = covariance.resize(count + 1, count + 1, 0.0);
        all.view_mut((0, count), (count, 1)).copy_from(&across);
        all.view_mut((count, 0), (1, count)).copy_from(&across.transpose());
        all[(count, count)] = variance;
        Posterior { theta: own.push(offset), covariance: all }
    }
}

/// The least squares problem [√r F; 1] x = [right; 0], F upper bidiagonal, reduced to an upper
/// bidiagonal factor R by rotations.
struct Regularised {
    diagonal: Vec<f64>,
    beside: Vec<f64>,
    x: DVector<f64>,
    /// Least sum of squares.
    squares: f64,
}

impl Regularised {
    fn of(form: &DMatrix<f64>, right: &DVector<f64>, root: f64) -> Self {
        let count = right.len();
        let (mut diagonal, mut beside) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let (mut x, mut squares) = (right.clone(), 0.0);
        // The row of the identity that is being rotated out: its element and its right side.
        let (mut own, mut side) = (1.0, 0.0);
        for at in 0..count {
            let next = if at + 1 < count { root * form[(at, at + 1)] } else { 0.0 };
            let of_form = root * form[(at, at)];
            let length = libm::hypot(of_form, own);
            let (cos, sin) = (of_form / length, own / length);
            diagonal.push(length);
            beside.push(cos * next);
            let left = cos * side - sin * x[at];
            x[at] = cos * x[at] + sin * side;
            let filled = -sin * next;
            own = libm::hypot(1.0, filled);
            side = filled / own * left;
            squares += (left / own).powi(2);
        }
        for at in (0..count).rev() {
            let known = if at + 1 < count { beside[at] * x[at + 1] } else { 0.0 };
            x[at] = (x[at] - known) / diagonal[at];
        }
        Self { diagonal, beside, x, squares }
    }

    /// ½ ln det(1 + r FᵀF)
    fn ln_determinant(&self) -> f64 {
        self.diagonal.iter().map(|own| libm::log(*own)).sum()
    }

    /// wᵀ (1 + r FᵀF)⁻¹ w = |R⁻ᵀ w|²
    fn inverse_square(&self, weights: &DVector<f64>) -> f64 {
        let (mut sum, mut last) = (0.0, 0.0);
        for at in 0..weights.len() {
            let known = if at > 0 { self.beside[at - 1] * last } else { 0.0 };
            last = (weights[at] - known) / self.diagonal[at];
            sum += last * last;
        }
        sum
    }
}
