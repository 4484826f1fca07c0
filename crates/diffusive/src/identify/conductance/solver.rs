//! Gauss–Newton on resistances and winds at once, on the normal equations of one reading.

use dr_core::model::mesh;
use nalgebra::{DMatrix, DVector};

use super::super::design::Role;
use super::super::gram::Gram;
use super::super::normal_equations::{ModelTerm, NormalEquations};
use super::super::options::{InitialState, Signs};
use super::super::prior::{Prior, Scales};
use super::terms::{ClassConductances, ConductanceColumns};
use crate::optimise::DampingRule;

/// Steps at most, and the change of the logarithm of the error at which they end.
const STEPS: usize = 60;
const SETTLED: f64 = 1e-9;

/// A joint step: all outputs' parameters, and the winds that they share.
pub(super) struct JointStep {
    pub(super) thetas: Vec<DVector<f64>>,
    /// Changes of ΔG by element and class without the reference, then of the gas temperature if it
    /// is estimated.
    pub(super) change: DVector<f64>,
    /// Of the winds, with noise variances taken from the residuals.
    pub(super) covariance: DMatrix<f64>,
    /// By output, of its own parameters within the joint solution.
    pub(super) own: Vec<DMatrix<f64>>,
}

pub(super) struct Solver<'a> {
    pub(super) places: ConductanceColumns<'a>,
    pub(super) scales: Scales,
    pub(super) prior: Prior,
    pub(super) initial_state: InitialState,
    pub(super) sample_period_s: f64,
    pub(super) signs: &'a Signs,
}

impl Solver<'_> {
    pub(super) fn penalty(&self, terms: &[ModelTerm], problem: &NormalEquations) -> DMatrix<f64> {
        self.scales.penalty(self.prior, terms, problem)
    }

    /// Which parameters of an output may not be negative; `None` where all may.
    pub(super) fn positive(&self, terms: &[ModelTerm], output: usize) -> Option<Vec<bool>> {
        let is_held = |bank: usize| bank < self.places.elements && self.signs.asks(bank, output);
        let of = |term: &ModelTerm| term.role.bank().is_some_and(is_held);
        let positive: Vec<bool> = terms.iter().map(of).collect();
        positive.contains(&true).then_some(positive)
    }

    /// Resistances for given winds, output by output.
    pub(super) fn linear(
        &self,
        gram: &Gram,
        winds: &ClassConductances,
    ) -> (Vec<ModelTerm>, Vec<DVector<f64>>, Vec<f64>) {
        let terms = self.places.terms(self.initial_state, winds);
        let (mut thetas, mut errors) = (Vec::new(), Vec::new());
        for output in 0..self.places.elements {
            let problem = NormalEquations::of(gram, &terms, self.places.elements, output);
            let penalty = self.penalty(&terms, &problem);
            let theta = problem.estimate(&penalty, self.positive(&terms, output).as_deref());
            errors.push(problem.squared_error(&theta) + theta.dot(&(&penalty * &theta)));
            thetas.push(theta);
        }
        (terms, thetas, errors)
    }

    /// The derivative of an output by the winds, as columns.
    pub(super) fn slopes(
        &self,
        terms: &[ModelTerm],
        theta: &DVector<f64>,
        winds: &ClassConductances,
    ) -> Vec<ModelTerm> {
        let places = &self.places;
        let mut slopes = Vec::new();
        let relaxations = |element: usize| {
            terms.iter().zip(theta.iter()).filter_map(move |(term, theta)| match term.role {
                Role::Relaxation { bank, k, .. } if bank == element => Some((k, *theta)),
                _ => None,
            })
        };
        for element in 0..places.elements {
            for class in places.winds() {
                let of = relaxations(element).flat_map(|(k, theta)| {
                    let loss = places.loss(element, class, k, winds.gas_c);
                    loss.into_iter().map(move |(at, weight)| (at, -theta * weight))
                });
                slopes.push(ModelTerm { of: of.collect(), role: Role::Offset });
            }
        }
        if places.gates {
            let mut of = Vec::new();
            for element in 0..places.elements {
                for class in places.winds() {
                    let taken = winds.conductance[element][class];
                    of.extend(
                        relaxations(element)
                            .map(|(k, theta)| (places.column(places.gate_bank(class), k), taken * theta)),
                    );
                }
            }
            slopes.push(ModelTerm { of, role: Role::Offset });
        }
        slopes
    }

    /// One Gauss–Newton step from `winds`, at whose resistances the slopes are taken.
    pub(super) fn step(&self, gram: &Gram, winds: &ClassConductances) -> JointStep {
        let (terms, thetas, _) = self.linear(gram, winds);
        let own = terms.len();
        let shared = self.slopes(&terms, &thetas[0], winds).len();
        let mut normal = DMatrix::<f64>::zeros(shared, shared);
        let mut right = DVector::<f64>::zeros(shared);
        let mut parts = Vec::new();
        for (output, theta) in thetas.iter().enumerate() {
            let all: Vec<ModelTerm> = terms.iter().cloned().chain(self.slopes(&terms, theta, winds)).collect();
            let problem = NormalEquations::of(gram, &all, self.places.elements, output);
            let plain = NormalEquations::of(gram, &terms, self.places.elements, output);
            let penalty = self.penalty(&terms, &plain);
            let positive = self.positive(&terms, output);
            let solution = plain.solve(&penalty, positive.as_deref());
            // The winds with the resistances projected out: the Schur complement. Those that are
            // held at zero do not move.
            let cross = problem.g.view((0, own), (own, shared)).into_owned();
            let projected = match &positive {
                None => &solution.inverse * &cross,
                Some(positive) => {
                    let is_free = |at: &usize| !positive[*at] || solution.theta[*at] != 0.0;
                    inverse_of(&plain, &penalty, &(0..own).filter(is_free).collect::<Vec<_>>()) * &cross
                }
            };
            let schur = problem.g.view((own, own), (shared, shared)) - cross.tr_mul(&projected);
            let gradient = problem.b.rows(own, shared) - cross.tr_mul(&solution.theta);
            let weight = 1.0 / solution.noise_variance.max(f64::MIN_POSITIVE);
            normal += schur * weight;
            right += gradient * weight;
            parts.push((projected, solution));
        }
        let scale = normal.diagonal().map(|entry| if entry > 0.0 { 1.0 / entry.sqrt() } else { 0.0 });
        let scaled = DMatrix::from_fn(shared, shared, |i, j| {
            normal[(i, j)] * scale[i] * scale[j] + if i == j { 1e-13 } else { 0.0 }
        });
        let inverse = scaled.clone().cholesky().map_or_else(
            || scaled.pseudo_inverse(1e-12).unwrap_or_else(|_| DMatrix::zeros(shared, shared)),
            |factor| factor.inverse(),
        );
        let covariance = DMatrix::from_fn(shared, shared, |i, j| inverse[(i, j)] * scale[i] * scale[j]);
        let change = &covariance * right;
        let own = parts
            .iter()
            .map(|(projected, solution)| &solution.covariance + projected * &covariance * projected.transpose())
            .collect();
        JointStep { thetas: parts.into_iter().map(|(_, solution)| solution.theta).collect(), change, covariance, own }
    }

    /// ClassConductances after a share of a step.
    pub(super) fn moved(&self, winds: &ClassConductances, change: &DVector<f64>, share: f64) -> ClassConductances {
        let mut moved = winds.clone();
        let mut at = 0;
        for element in 0..self.places.elements {
            for class in self.places.winds() {
                moved.conductance[element][class] += share * change[at];
                at += 1;
            }
        }
        if self.places.gates {
            moved.gas_c += share * change[at];
        }
        moved
    }

    /// The least penalised error, summed over outputs by their logarithms.
    ///
    /// Infinite where a kelvin would take more than a kelvin by the next row: a loss that is held
    /// so long no longer stands for one that goes with the temperature.
    pub(super) fn cost(&self, gram: &Gram, winds: &ClassConductances) -> f64 {
        let (terms, thetas, errors) = self.linear(gram, winds);
        let is_held =
            |(element, theta): (usize, &DVector<f64>)| self.held_loop_gain(element, &terms, theta, winds) < 1.0;
        if !thetas.iter().enumerate().all(is_held) {
            return f64::INFINITY;
        }
        errors.iter().map(|error| libm::log(error.max(f64::MIN_POSITIVE))).sum()
    }

    /// Σ_k R_k g_k · max |ΔG|: what a kelvin of an element takes from it by the next row.
    pub(super) fn held_loop_gain(
        &self,
        element: usize,
        terms: &[ModelTerm],
        theta: &DVector<f64>,
        winds: &ClassConductances,
    ) -> f64 {
        let own = terms.iter().zip(theta.iter()).filter_map(|(term, resistance)| match term.role {
            Role::Relaxation { bank, rate_rad_s, .. } if bank == element => {
                Some(resistance * mesh::gain(rate_rad_s, self.sample_period_s))
            }
            _ => None,
        });
        let greatest = winds.conductance[element].iter().fold(0.0_f64, |most, taken| most.max(taken.abs()));
        own.sum::<f64>().abs() * greatest
    }

    /// The winds of the least cost next to a start: full steps, halved until one pays.
    pub(super) fn solve(&self, gram: &Gram, start: ClassConductances) -> ClassConductances {
        let mut cost = self.cost(gram, &start);
        let mut winds = start;
        let mut damping = HALVED.start;
        for _ in 0..STEPS {
            let change = self.step(gram, &winds).change;
            let moved = |damping: f64| {
                let moved = self.moved(&winds, &change, 1.0 / damping);
                let new = self.cost(gram, &moved);
                (new.is_finite() && new <= cost).then_some((moved, new))
            };
            let Some((moved, new)) = HALVED.first_that_pays(&mut damping, moved) else { break };
            let is_settled = cost - new < SETTLED;
            (winds, cost) = (moved, new);
            if is_settled {
                break;
            }
        }
        winds
    }
}

/// Damping by which steps are divided.
const HALVED: DampingRule = DampingRule { start: 1.0, eased: |_| 1.0, raised: |damping| 2.0 * damping, most: 1e6 };

/// (G + P)⁻¹ of the free parameters, and zero for the others.
fn inverse_of(problem: &NormalEquations, penalty: &DMatrix<f64>, free: &[usize]) -> DMatrix<f64> {
    let (rows, penalised) = (problem.g.select_rows(free), penalty.select_rows(free));
    let part = NormalEquations {
        g: rows.select_columns(free),
        b: problem.b.select_rows(free),
        yy: problem.yy,
        rows: problem.rows,
    };
    let inverse = part.solve(&penalised.select_columns(free), None).inverse;
    let mut all = DMatrix::zeros(problem.b.len(), problem.b.len());
    for (i, &row) in free.iter().enumerate() {
        for (j, &column) in free.iter().enumerate() {
            all[(row, column)] = inverse[(i, j)];
        }
    }
    all
}
