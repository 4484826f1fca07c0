//! A few poles in place of the grid, where one input heats an output that answers with R_k ≥ 0 only.
//!
//! ```text
//! S = min over ξ, R ≥ 0 of |y − offset − Σ R_k x_k(ξ_k)|²,    K of least n ln S + (2K + 1) ln n
//! ```
//!
//! A chain of masses has as many poles as masses, and its ladder follows from them; a smooth spectrum
//! on a grid smears its layers. Non-negative least squares on a fine grid leaves few rates above zero
//! and so the start; Gauss-Newton steps on ln ξ move them; the least known pole goes, or the closest
//! two become one, until none is left. (G. Schwarz, *Annals of Statistics* 6 (1978) 461.)

use nalgebra::{DMatrix, DVector};

use super::WeighedModel;
use super::columns::{OutputTable, factor_of};
use super::factor::TriangularFactor;
use crate::identify::candidates::terms;
use crate::identify::design::{BankDrive, RegressionDesign, RelaxationBank, Role};
use crate::identify::nonnegative;
use crate::identify::normal_equations::ModelTerm;
use crate::identify::options::InitialState;
use dr_core::model::mesh;

/// Rates a decade of the start.
const START: f64 = 12.0;
/// Half the step of ln ξ over which columns are differentiated.
const HALF_STEP: f64 = 1e-3;
/// Ridge on squares of unit columns: neighbours on a fine grid are nearly dependent.
const HELD: f64 = 1e-13;
/// Steps of one search at most, the longest in ln ξ, and the relative gain that ends it.
const MOST_STEPS: usize = 25;
const LONGEST: f64 = 0.5;
const SETTLED: f64 = 1e-7;
/// Poles closer than this in ln ξ are one.
const CLOSEST: f64 = 0.1;
/// Nats below the best at which no fewer poles are tried.
const FAR: f64 = 30.0;

/// One input's transient.
pub struct Transient<'a> {
    pub table: &'a OutputTable,
    pub initial_state: InitialState,
    /// ln of the slowest and of the fastest rate.
    bounds: (f64, f64),
}

/// Poles that a record tells apart.
pub struct Poles {
    pub model: WeighedModel,
    pub noise_variance: f64,
    /// ln of the evidence by Schwarz, but for what all hypotheses have in common.
    pub ln_evidence: f64,
}

/// Poles with the columns there.
#[derive(Debug, Clone)]
struct Point {
    ln_rates: Vec<f64>,
    r_k_per_w: Vec<f64>,
    offset: f64,
    squares: f64,
    counted: usize,
    /// R_k's columns, the offset's, those of ln ξ_k, and what is left of the output.
    joint: DMatrix<f64>,
}

impl<'a> Transient<'a> {
    /// The transient of a record that begins at rest or settled.
    pub fn of(table: &'a OutputTable, initial_state: InitialState) -> Self {
        let duration_s = table.duration_s(table.rows());
        let bounds = (0.2 * std::f64::consts::PI / duration_s, 3.0 * std::f64::consts::PI / table.period_s);
        Self { table, initial_state, bounds: (libm::log(bounds.0), libm::log(bounds.1)) }
    }

    fn design(&self, rates_rad_s: Vec<f64>) -> RegressionDesign {
        let initial_rad_s = if self.initial_state == InitialState::Settled { rates_rad_s.clone() } else { Vec::new() };
        let bank = RelaxationBank { drive: BankDrive::Input(0), rates_rad_s, delay: 0, feed_through: false };
        RegressionDesign { banks: vec![bank], initial_rad_s, outputs: 1, from_rest: false }
    }

    fn terms(&self, design: &RegressionDesign) -> Vec<ModelTerm> {
        terms(&design.roles(), self.initial_state, false, &[self.table.blocks[0].inputs[0][0]])
    }

    /// Columns of relaxations at some rates, of the offset and of the output, and how many rows they
    /// stand for.
    fn columns(&self, rates_rad_s: Vec<f64>) -> (DMatrix<f64>, usize) {
        let design = self.design(rates_rad_s);
        let (factor, counted, _) = factor_of(self.table, &design, 0, self.table.rows());
        let terms = self.terms(&design);
        let width = factor.width();
        let output = vec![(width - 1, 1.0)];
        let of: Vec<&Vec<(usize, f64)>> = terms.iter().map(|term| &term.of).chain([&output]).collect();
        let sum = |row: usize, at: usize| of[at].iter().map(|&(column, weight)| weight * factor.at(row, column)).sum();
        (DMatrix::from_fn(width, of.len(), sum), counted)
    }

    fn point(&self, ln_rates: Vec<f64>) -> Point {
        let count = ln_rates.len();
        let beside = ln_rates.iter().flat_map(|ln| [libm::exp(ln - HALF_STEP), libm::exp(ln + HALF_STEP)]);
        let (read, counted) = self.columns(beside.collect());
        let mut linear = DMatrix::zeros(read.nrows(), count + 1);
        for k in 0..count {
            linear.set_column(k, &((read.column(2 * k) + read.column(2 * k + 1)) * 0.5));
        }
        linear.set_column(count, &read.column(2 * count));
        let output = read.column(2 * count + 1);
        let theta = non_negative(&linear, &output.into_owned());
        let left = output - &linear * &theta;
        let mut joint = DMatrix::zeros(read.nrows(), 2 * count + 2);
        joint.columns_mut(0, count + 1).copy_from(&linear);
        for k in 0..count {
            let slope = (read.column(2 * k + 1) - read.column(2 * k)) * (theta[k] / (2.0 * HALF_STEP));
            joint.set_column(count + 1 + k, &slope);
        }
        joint.set_column(2 * count + 1, &left);
        let r_k_per_w = theta.as_slice()[..count].to_vec();
        Point { ln_rates, r_k_per_w, offset: theta[count], squares: left.norm_squared(), counted, joint }
    }

    /// Rates above zero of the whole range, neighbours as one.
    fn start(&self) -> Vec<f64> {
        let (low, high) = self.bounds;
        let order = ((high - low) / std::f64::consts::LN_10 * START).ceil() as usize + 1;
        let rates: Vec<f64> = (0..order).map(|k| mesh::rate_rad_s(libm::exp(low), libm::exp(high), k, order)).collect();
        let (read, _) = self.columns(rates.clone());
        let theta = non_negative(&read.columns(0, order + 1).into_owned(), &read.column(order + 1).into_owned());
        let mut start: Vec<f64> = Vec::new();
        for group in (0..order).collect::<Vec<_>>().chunk_by(|a, b| (theta[*a] > 0.0) == (theta[*b] > 0.0)) {
            let whole: f64 = group.iter().map(|&k| theta[k]).sum();
            if whole > 0.0 {
                start.push(group.iter().map(|&k| theta[k] * libm::log(rates[k])).sum::<f64>() / whole);
            }
        }
        start
    }

    /// Moves rates until they settle.
    fn settled(&self, start: Vec<f64>) -> Point {
        let mut best = self.point(start);
        let mut damping = 1e-3;
        for _ in 0..MOST_STEPS {
            if best.r_k_per_w.contains(&0.0) && best.r_k_per_w.iter().any(|r| *r > 0.0) {
                let left = best.ln_rates.iter().zip(&best.r_k_per_w).filter(|(_, r)| **r > 0.0);
                best = self.point(left.map(|(ln, _)| *ln).collect());
            }
            let Some(step) = best.step(damping) else { break };
            let (low, high) = self.bounds;
            let moved = best.ln_rates.iter().zip(&step);
            let mut moved: Vec<f64> =
                moved.map(|(ln, step)| (ln + step.clamp(-LONGEST, LONGEST)).clamp(low, high)).collect();
            moved.sort_by(f64::total_cmp);
            let groups = moved.chunk_by(|a, b| b - a < CLOSEST);
            let next = self.point(groups.map(|group| group.iter().sum::<f64>() / group.len() as f64).collect());
            if next.squares.total_cmp(&best.squares).is_gt() {
                damping *= 8.0;
                if damping > 1e6 {
                    break;
                }
                continue;
            }
            let gain = best.squares - next.squares;
            damping = (0.1 * damping).max(1e-12);
            best = next;
            if gain <= SETTLED * best.squares {
                break;
            }
        }
        best
    }

    /// Finds the poles that the record tells apart; none if it shows none.
    pub fn model(&self) -> Option<Poles> {
        let start = self.start();
        if start.is_empty() {
            return None;
        }
        let mut current = self.settled(start);
        let mut best = current.clone();
        while current.ln_rates.len() > 1 && current.ln_evidence() > best.ln_evidence() - FAR {
            let fewer = [current.without_least_known(), current.with_closest_joined()].into_iter().flatten();
            let tried = fewer.map(|start| self.settled(start)).min_by(|a, b| a.squares.total_cmp(&b.squares));
            current = tried?;
            if current.ln_evidence() > best.ln_evidence() {
                best = current.clone();
            }
        }
        let design = self.design(best.ln_rates.iter().map(|ln| libm::exp(*ln)).collect());
        let count = best.ln_rates.len();
        let mut terms = self.terms(&design);
        terms.resize(2 * count + 1, ModelTerm { of: Vec::new(), role: Role::Offset });
        let noise_variance = best.noise_variance();
        let inverse = best.inverse()?;
        let values = best.r_k_per_w.iter().copied().chain([best.offset]);
        let model = WeighedModel {
            design,
            terms,
            theta: DVector::from_iterator(2 * count + 1, values.chain(std::iter::repeat_n(0.0, count))),
            covariance: &inverse * inverse.transpose() * noise_variance,
            shift: self.table.blocks[0].outputs[0][0],
            initial_state: self.initial_state,
            drift: None,
            free_rates: count,
            share_of_poles: 0.0,
        };
        Some(Poles { model, noise_variance, ln_evidence: best.ln_evidence() })
    }
}

/// Least squares with all but the last parameter at or above zero.
fn non_negative(columns: &DMatrix<f64>, output: &DVector<f64>) -> DVector<f64> {
    let norms: Vec<f64> = columns.column_iter().map(|column| column.norm().max(f64::MIN_POSITIVE)).collect();
    let mut unit = columns.clone();
    unit.column_iter_mut().zip(&norms).for_each(|(mut column, norm)| column /= *norm);
    let positive: Vec<bool> = (0..norms.len()).map(|at| at + 1 < norms.len()).collect();
    let squares = unit.tr_mul(&unit) + DMatrix::identity(norms.len(), norms.len()) * HELD;
    let mut theta = nonnegative::solve(&squares, &unit.tr_mul(output), &positive);
    theta.iter_mut().zip(&norms).for_each(|(value, norm)| *value /= norm);
    theta
}

impl Point {
    fn parameters(&self) -> f64 {
        (2 * self.ln_rates.len() + 1) as f64
    }

    fn noise_variance(&self) -> f64 {
        self.squares / (self.counted as f64 - self.parameters()).max(1.0)
    }

    /// Schwarz' criterion, as ln of the evidence.
    fn ln_evidence(&self) -> f64 {
        let rows = self.counted as f64 - 1.0;
        -0.5 * rows * libm::log(self.squares.max(1e-300) / rows) - 0.5 * self.parameters() * libm::log(rows)
    }

    /// Steps of ln ξ.
    fn step(&self, damping: f64) -> Option<Vec<f64>> {
        let (count, rows) = (self.ln_rates.len(), self.joint.nrows());
        let mut stacked = self.joint.clone().resize(rows + count, 2 * count + 2, 0.0);
        for k in 0..count {
            let own = count + 1 + k;
            stacked[(rows + k, own)] = (damping.sqrt() * self.joint.column(own).norm()).max(1e-150);
        }
        let factor = TriangularFactor::of(&stacked);
        let unknowns = 2 * count + 1;
        let right = DVector::from_fn(unknowns, |row, _| factor.at(row, unknowns));
        let upper = DMatrix::from_fn(unknowns, unknowns, |row, column| factor.at(row, column));
        let step = upper.solve_upper_triangular(&right)?;
        Some(step.as_slice()[count + 1..].to_vec()).filter(|step| step.iter().all(|step| step.is_finite()))
    }

    /// The inverse of the triangular factor of all parameters' columns.
    fn inverse(&self) -> Option<DMatrix<f64>> {
        let unknowns = self.joint.ncols() - 1;
        let factor = TriangularFactor::of(&self.joint);
        let upper = DMatrix::from_fn(unknowns, unknowns, |row, column| factor.at(row, column));
        upper.solve_upper_triangular(&DMatrix::identity(unknowns, unknowns))
    }

    /// Rates without the pole whose R is least known.
    fn without_least_known(&self) -> Option<Vec<f64>> {
        let inverse = self.inverse()?;
        let known = |k: usize| self.r_k_per_w[k] / inverse.row(k).norm();
        let least = (0..self.ln_rates.len()).min_by(|&a, &b| known(a).total_cmp(&known(b)))?;
        let mut rates = self.ln_rates.clone();
        rates.remove(least);
        Some(rates)
    }

    /// Rates with one in place of the two that are closest.
    fn with_closest_joined(&self) -> Option<Vec<f64>> {
        let (ln, r) = (&self.ln_rates, &self.r_k_per_w);
        let gap = |k: usize| ln[k + 1] - ln[k];
        let at = (0..ln.len() - 1).min_by(|&a, &b| gap(a).total_cmp(&gap(b)))?;
        let whole = (r[at] + r[at + 1]).max(f64::MIN_POSITIVE);
        let mut rates = ln.clone();
        rates[at] = (r[at] * ln[at] + r[at + 1] * ln[at + 1]) / whole;
        rates.remove(at + 1);
        Some(rates)
    }
}
