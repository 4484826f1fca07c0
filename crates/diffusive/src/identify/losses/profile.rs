//! One output's regression as a function of the losses: everything but g is linear, so that the
//! sums of one reading have the answer for any g.
//!
//! ```text
//! x(w_i) = x(u_i) − Σ g x((T_o − T_0)²)
//! ```
//!
//! As ΔG does in structure `conductance`, g weighs columns beside those of the inputs. Mesh, prior,
//! initial state and signs are those of a model that was identified before.

use nalgebra::{DMatrix, DVector};

use super::super::candidates::terms;
use super::super::design::{BankDrive, RegressionDesign, RelaxationBank, Role};
use super::super::folds::{FoldedEquations, Score};
use super::super::gram::Gram;
use super::super::normal_equations::{ModelTerm, NormalEquations};
use super::super::options::InitialState;
use super::super::pass::Facts;
use super::super::prior::{Prior, Scales};
use super::source::SearchedLoss;
use crate::model::Model;

/// The banks of one output's own candidate: those of its pairs, of the losses beside them, and of
/// measured surroundings.
pub struct ProfileDesign {
    pub design: RegressionDesign,
    /// By bank of a loss: which loss, and the bank of the input that it takes heat from.
    losses: Vec<(usize, usize)>,
    /// By bank of an input: whether its resistances are held at or above zero.
    positive: Vec<bool>,
    /// By bank of an input: which input.
    inputs: Vec<usize>,
}

impl ProfileDesign {
    pub fn of(model: &Model, output: usize, losses: &[SearchedLoss]) -> Self {
        let gated = model.classes.len() > 1;
        let mut found = Self {
            design: RegressionDesign {
                banks: Vec::new(),
                initial_rad_s: Vec::new(),
                outputs: model.outputs.len(),
                from_rest: initial_state(model) == InitialState::Rest,
            },
            losses: Vec::new(),
            positive: Vec::new(),
            inputs: Vec::new(),
        };
        let mut beside = Vec::new();
        for (input, name) in model.inputs.iter().enumerate() {
            let Some(pair) = model.pair(name, &model.outputs[output].name) else { continue };
            if found.design.initial_rad_s.is_empty() || input == output {
                found.design.initial_rad_s.clone_from(&pair.mesh_rad_s);
            }
            for class in 0..if gated { model.classes.len() } else { 1 } {
                let bank = |input| RelaxationBank {
                    drive: if gated { BankDrive::Gated { input, class } } else { BankDrive::Input(input) },
                    rates_rad_s: pair.mesh_rad_s.clone(),
                    delay: pair.dead_time_samples,
                    feed_through: false,
                };
                let own = losses.iter().enumerate().filter(|(_, loss)| loss.placed.input == input);
                for (at, _) in own {
                    beside.push((at, found.design.banks.len(), bank(model.inputs.len() + at)));
                }
                found.design.banks.push(bank(input));
                found.positive.push(pair.non_negative);
                found.inputs.push(input);
            }
        }
        for (at, from, bank) in beside {
            found.design.banks.push(bank);
            found.losses.push((at, from));
        }
        let ambient = model.ambient.as_ref().map(|ambient| RelaxationBank {
            drive: BankDrive::Gas,
            rates_rad_s: ambient.following.mesh_rad_s.clone(),
            delay: 0,
            feed_through: false,
        });
        found.design.banks.extend(ambient);
        found
    }

    /// The bank of an input in the first class.
    pub fn bank_of(&self, input: usize) -> usize {
        self.inputs.iter().position(|of| *of == input).unwrap_or(0)
    }
}

/// One output's sums.
pub struct Profile {
    output: usize,
    outputs: usize,
    folds: Vec<Gram>,
    total: Gram,
    /// Without losses.
    plain: Vec<ModelTerm>,
    /// Which term each loss's term belongs to, of which loss.
    losses: Vec<(usize, usize, ModelTerm)>,
    positive: Option<Vec<bool>>,
    prior: Prior,
    scales: Scales,
}

/// The best for given losses.
pub struct ProfilePoint {
    pub terms: Vec<ModelTerm>,
    pub theta: DVector<f64>,
    /// Residual sum of squares, with the prior's part.
    pub cost: f64,
    penalty: DMatrix<f64>,
}

impl Profile {
    pub fn of(
        model: &Model,
        output: usize,
        design: &ProfileDesign,
        folds: Vec<Gram>,
        facts: &Facts,
        thesis_rad_s: f64,
    ) -> Self {
        let of_losses = design.positive.len()..design.positive.len() + design.losses.len();
        let first_drives = facts.first_drives(&design.design);
        let initial_state = initial_state(model);
        let (mut plain, mut beside) = (Vec::new(), Vec::new());
        for term in terms(&design.design.roles(), initial_state, false, &first_drives) {
            match term.role.bank().filter(|bank| of_losses.contains(bank)) {
                Some(bank) => beside.push((bank - of_losses.start, term)),
                None => plain.push(term),
            }
        }
        let place = |role: Role, of: usize| {
            plain.iter().position(|term: &ModelTerm| match (term.role, role) {
                (Role::Relaxation { bank, k, .. }, Role::Relaxation { k: own, .. }) => bank == of && k == own,
                _ => false,
            })
        };
        let losses = beside.into_iter().filter_map(|(bank, term)| {
            let (loss, from) = design.losses[bank];
            Some((place(term.role, from)?, loss, term))
        });
        let losses = losses.collect();
        let is_held = |term: &ModelTerm| term.role.bank().is_some_and(|bank| design.positive.get(bank) == Some(&true));
        let positive: Vec<bool> = plain.iter().map(is_held).collect();
        Self {
            output,
            outputs: model.outputs.len(),
            total: Gram::total(&folds),
            folds,
            losses,
            positive: positive.contains(&true).then_some(positive),
            prior: prior(model),
            scales: Scales::of(&design.design, facts, thesis_rad_s),
            plain,
        }
    }

    fn terms(&self, g_w_per_k2: &[f64]) -> Vec<ModelTerm> {
        let mut terms = self.plain.clone();
        for (at, loss, term) in &self.losses {
            terms[*at].of.extend(term.of.iter().map(|(column, factor)| (*column, -g_w_per_k2[*loss] * factor)));
        }
        terms
    }

    pub fn at(&self, g_w_per_k2: &[f64]) -> ProfilePoint {
        let terms = self.terms(g_w_per_k2);
        let equations = NormalEquations::of(&self.total, &terms, self.outputs, self.output);
        let penalty = self.scales.penalty(self.prior, &terms, &equations);
        let theta = equations.estimate(&penalty, self.positive.as_deref());
        let cost = equations.squared_error(&theta) + theta.dot(&(&penalty * &theta));
        ProfilePoint { terms, theta, cost, penalty }
    }

    /// σ² of the residuals, which are taken for white.
    pub fn noise_variance(&self, point: &ProfilePoint) -> f64 {
        let equations = NormalEquations::of(&self.total, &point.terms, self.outputs, self.output);
        equations.solve(&point.penalty, self.positive.as_deref()).noise_variance
    }

    /// Cross-validates the candidate with given losses.
    pub fn score(&self, g_w_per_k2: &[f64]) -> Score {
        let equations = FoldedEquations::of(&self.folds, self.terms(g_w_per_k2), self.outputs, self.output);
        equations.score(&equations.penalty(&self.scales, self.prior), self.positive.as_deref())
    }
}

impl ProfilePoint {
    /// The offset, over what was subtracted from the output, K.
    pub fn offset_k(&self) -> f64 {
        self.sum(|role| role == Role::Offset)
    }

    /// Σ R of a bank, K/W.
    pub fn gain_k_per_w(&self, bank: usize) -> f64 {
        self.sum(|role| role.bank() == Some(bank))
    }

    fn sum(&self, is_its: impl Fn(Role) -> bool) -> f64 {
        let own = self.terms.iter().zip(self.theta.iter()).filter(|(term, _)| is_its(term.role));
        own.map(|(_, theta)| theta).sum()
    }
}

/// The first output's, as all outputs began together.
fn initial_state(model: &Model) -> InitialState {
    let states = [InitialState::Rest, InitialState::Settled, InitialState::Free];
    states.into_iter().find(|state| state.name() == model.chosen.initial_state).unwrap_or(InitialState::Free)
}

fn prior(model: &Model) -> Prior {
    let weight = model.chosen.ridge;
    [Prior::Columns(weight), Prior::Tapered(weight), Prior::Smooth(weight)]
        .into_iter()
        .find(|prior| prior.name() == model.chosen.prior)
        .unwrap_or(Prior::Tapered(weight))
}
