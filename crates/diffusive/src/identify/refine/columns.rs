//! The columns that a few free rates need, and normal equations in resistances and rates together.
//!
//! Next to each rate stand two others, a little slower and faster, so that a column's derivative is
//! a difference of columns and all algebra stays on the sums of one reading:
//!
//! ```text
//! ∂x/∂ln ξ ≈ (x(ξ e^d) − x(ξ e^−d)) / 2d
//! y ≈ Σ R_k x_k + Σ_k δ_k Σ_banks R_k ∂x_k/∂ln ξ_k,   δ = Δ ln ξ
//! ```
//!
//! Initial decays have the poles' rates, and their derivatives belong to δ_k as well.

use nalgebra::{DMatrix, DVector};

use super::super::candidates::terms;
use super::super::design::{BankDrive, RegressionDesign, RelaxationBank, Role};
use super::super::gram::Gram;
use super::super::normal_equations::{ModelTerm, NormalEquations, PenalisedSolution};
use super::super::options::InitialState;
use super::super::prior::{Prior, Scales};

/// d: the error of the difference is d²/6 of a third derivative, 2e-7; rounding of the sums,
/// 1e-16/d², is less.
const STEP: f64 = 1e-3;

/// What drives one bank.
#[derive(Debug, Clone, Copy)]
pub struct RefinedBank {
    /// Index into the model's pairs, and of the class.
    pub pair: usize,
    pub class: usize,
    pub drive: BankDrive,
    pub delay: usize,
    pub non_negative: bool,
}

/// The way of an input to an output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Path {
    /// Dead time in samples.
    pub delay: usize,
    pub feed_through: bool,
}

/// What stays while rates move.
#[derive(Clone)]
pub struct Setup {
    pub parts: Vec<RefinedBank>,
    /// Rows of later segments that are left out: the longest dead time that is tried.
    pub lead: usize,
    pub feed_through: bool,
    /// `None` until the first reading has shown which.
    pub initial_state: Option<InitialState>,
    /// Nothing heated before the record.
    pub from_rest: bool,
    /// Whether the design has initial decays.
    pub initial: bool,
    pub outputs: usize,
    pub output: usize,
    pub prior: Prior,
}

impl Setup {
    pub fn design(&self, rates_rad_s: &[f64]) -> RegressionDesign {
        let bank = |part: &RefinedBank| RelaxationBank {
            drive: part.drive,
            rates_rad_s: rates_rad_s.to_vec(),
            delay: part.delay,
            feed_through: self.feed_through,
        };
        let initial_rad_s = if self.initial { rates_rad_s.to_vec() } else { Vec::new() };
        let banks = self.parts.iter().map(bank).collect();
        RegressionDesign { banks, initial_rad_s, outputs: self.outputs, from_rest: self.from_rest }
    }

    /// All banks have the same path.
    pub fn path(&self) -> Path {
        Path { delay: self.parts.first().map_or(0, |part| part.delay), feed_through: self.feed_through }
    }

    pub fn with_path(&self, Path { delay, feed_through }: Path) -> Self {
        let parts = self.parts.iter().map(|part| RefinedBank { delay, ..*part }).collect();
        Self { parts, feed_through, ..self.clone() }
    }

    /// The design that is read: each rate between its two neighbours. A bank without rates leaves
    /// out the rows that the longest dead time does.
    pub fn tripled(&self, rates_rad_s: &[f64]) -> RegressionDesign {
        let mut design = self.design(&tripled(rates_rad_s));
        let drive = self.parts[0].drive;
        design.banks.push(RelaxationBank { drive, rates_rad_s: Vec::new(), delay: self.lead, feed_through: false });
        design
    }

    /// The parameters of a design with some initial state.
    pub fn terms(
        &self,
        design: &RegressionDesign,
        initial_state: InitialState,
        first_drives: &[f64],
    ) -> Vec<ModelTerm> {
        terms(&design.roles(), initial_state, self.feed_through, first_drives)
    }

    /// Which of the parameters may not be negative, if any.
    fn held(&self, terms: &[ModelTerm]) -> Option<Vec<bool>> {
        let of = |term: &ModelTerm| term.role.bank().is_some_and(|bank| self.parts[bank].non_negative);
        let held: Vec<bool> = terms.iter().map(of).collect();
        held.contains(&true).then_some(held)
    }

    /// The parameters of the rates themselves in the design that is read.
    pub fn centre(&self, rates_rad_s: &[f64], initial_state: InitialState, first_drives: &[f64]) -> Vec<ModelTerm> {
        let all = self.terms(&self.tripled(rates_rad_s), initial_state, first_drives);
        all.into_iter().filter(|term| place(term, rates_rad_s).is_none_or(|(_, side)| side == 1)).collect()
    }
}

fn tripled(rates_rad_s: &[f64]) -> Vec<f64> {
    rates_rad_s.iter().flat_map(|rate| [rate * libm::exp(-STEP), *rate, rate * libm::exp(STEP)]).collect()
}

/// Pole and side (0 slower, 1 itself, 2 faster) of a parameter that has a rate.
fn place(term: &ModelTerm, rates_rad_s: &[f64]) -> Option<(usize, usize)> {
    match term.role {
        Role::Relaxation { k, .. } => Some((k / 3, k % 3)),
        Role::Initial { rate_rad_s } => {
            let k = tripled(rates_rad_s).iter().position(|rate| *rate == rate_rad_s)?;
            Some((k / 3, k % 3))
        }
        Role::FeedThrough { .. } | Role::Offset | Role::DriftStart { .. } => None,
    }
}

/// Rates, the best resistances for them, and the problem in both.
pub struct Point {
    pub rates_rad_s: Vec<f64>,
    /// Best resistances, initial decays and offset at these rates.
    pub theta: DVector<f64>,
    /// What is minimised: the residual sum of squares and the prior's share.
    pub cost: f64,
    pub rss: f64,
    /// In θ and, behind them, δ: fold by fold and in all.
    pub folds: Vec<NormalEquations>,
    pub total: NormalEquations,
    pub penalty: DMatrix<f64>,
    pub positive: Option<Vec<bool>>,
    /// δ = 0 solves the problem with the present rates; this is its full solution.
    pub joint: PenalisedSolution,
}

impl Point {
    pub fn of(setup: &Setup, rates_rad_s: &[f64], folds: &[Gram], scales: &Scales, first_drives: &[f64]) -> Self {
        let initial_state = setup.initial_state.unwrap_or(InitialState::Free);
        let all = setup.terms(&setup.tripled(rates_rad_s), initial_state, first_drives);
        let centre = setup.centre(rates_rad_s, initial_state, first_drives);
        let whole = Gram::total(folds);
        let linear = NormalEquations::of(&whole, &centre, setup.outputs, setup.output);
        let linear_penalty = scales.penalty(setup.prior, &centre, &linear);
        let held = setup.held(&centre);
        let theta = linear.estimate(&linear_penalty, held.as_deref());
        let rss = linear.squared_error(&theta);
        let cost = rss + theta.dot(&(&linear_penalty * &theta));

        let poles = rates_rad_s.len();
        // No prior on rates: an offset's role has none either.
        let mut joined = centre.clone();
        joined.extend((0..poles).map(|_| ModelTerm { of: Vec::new(), role: Role::Offset }));
        for (index, term) in centre.iter().enumerate() {
            let Some((pole, _)) = place(term, rates_rad_s) else { continue };
            for side in all.iter().filter(|side| same_bank(&side.role, &term.role)) {
                let sign = match place(side, rates_rad_s) {
                    Some((own, 0)) if own == pole => -1.0,
                    Some((own, 2)) if own == pole => 1.0,
                    _ => continue,
                };
                let weight = sign * theta[index] / (2.0 * STEP);
                joined[centre.len() + pole].of.extend(side.of.iter().map(|&(column, of)| (column, weight * of)));
            }
        }
        let problem = |gram: &Gram| NormalEquations::of(gram, &joined, setup.outputs, setup.output);
        let total = problem(&whole);
        let count = joined.len();
        let penalty = linear_penalty.resize(count, count, 0.0);
        let positive = held.map(|mut held| {
            held.resize(count, false);
            held
        });
        let joint = total.solve(&penalty, positive.as_deref());
        Self {
            rates_rad_s: rates_rad_s.to_vec(),
            folds: folds.iter().map(problem).collect(),
            theta,
            cost,
            rss,
            total,
            penalty,
            positive,
            joint,
        }
    }

    /// δ of Levenberg and Marquardt; poles in `pinned` stay.
    pub fn step(&self, damping: f64, pinned: &[bool]) -> Vec<f64> {
        let first = self.theta.len();
        let mut penalty = self.penalty.clone();
        for (pole, &pinned) in pinned.iter().enumerate() {
            let at = (first + pole, first + pole);
            penalty[at] += self.total.g[at] * if pinned { 1e12 } else { damping };
        }
        let joint = self.total.estimate(&penalty, self.positive.as_deref());
        (0..pinned.len()).map(|pole| joint[first + pole]).collect()
    }

    /// Covariance of ln ξ of two poles.
    pub fn covariance(&self, i: usize, j: usize) -> f64 {
        let first = self.theta.len();
        self.joint.covariance[(first + i, first + j)]
    }

    pub fn log_se(&self, pole: usize) -> f64 {
        self.covariance(pole, pole).max(0.0).sqrt()
    }

    /// Resistances at the present rates, with a covariance that knows that the rates were fitted
    /// too.
    pub fn solution(&self) -> PenalisedSolution {
        let noise_variance = self.rss / (self.total.rows - self.joint.degrees).max(1.0);
        PenalisedSolution {
            theta: self.theta.clone().resize_vertically(self.joint.theta.len(), 0.0),
            covariance: &self.joint.inverse * noise_variance + &self.joint.pulled,
            inverse: self.joint.inverse.clone(),
            pulled: self.joint.pulled.clone(),
            rss: self.rss,
            degrees: self.joint.degrees,
            noise_variance,
        }
    }
}

fn same_bank(a: &Role, b: &Role) -> bool {
    match (a, b) {
        (Role::Relaxation { bank: a, .. }, Role::Relaxation { bank: b, .. }) => a == b,
        (Role::Initial { .. }, Role::Initial { .. }) => true,
        _ => false,
    }
}
