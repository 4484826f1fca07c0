//! The parameters for given winds: columns of w from the columns of inputs, gated outputs and
//! gates.

use super::super::design::Role;
use super::super::normal_equations::ModelTerm;
use super::super::options::InitialState;

/// The wind that a step starts from.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ClassConductances {
    /// ΔG by element and class, W/K; 0 for the reference.
    pub(super) conductance: Vec<Vec<f64>>,
    /// What is added to the gas temperature that the banks were driven with.
    pub(super) gas_c: f64,
}

/// Where things stand in the design.
pub(super) struct ConductanceColumns<'a> {
    pub(super) roles: &'a [Role],
    pub(super) elements: usize,
    pub(super) classes: usize,
    pub(super) reference: usize,
    /// Whether gates have banks, for a gas temperature that is estimated.
    pub(super) gates: bool,
    /// Whether outputs follow the gas, which then has a bank.
    pub(super) follows: bool,
}

impl ConductanceColumns<'_> {
    /// Banks of losses stand behind the inputs', one an element; the reference's are left out.
    pub(super) fn loss_bank(&self, element: usize, class: usize) -> usize {
        self.elements + element * (self.classes - 1) + self.slot(class)
    }

    pub(super) fn gate_bank(&self, class: usize) -> usize {
        self.elements * self.classes + self.slot(class)
    }

    /// In the place of the gates: no gas is both estimated and measured.
    pub(super) fn gas_bank(&self) -> usize {
        self.elements * self.classes
    }

    pub(super) fn slot(&self, class: usize) -> usize {
        if class > self.reference { class - 1 } else { class }
    }

    pub(super) fn winds(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.classes).filter(|&class| class != self.reference)
    }

    pub(super) fn column(&self, bank: usize, k: usize) -> usize {
        let wanted =
            |role: &Role| matches!(role, Role::Relaxation { bank: own, k: at, .. } if *own == bank && *at == k);
        self.roles.iter().position(wanted).expect("every bank has the same rates")
    }

    /// The loss of an element in a class, rate k, as columns: what one W/K of conductance takes.
    pub(super) fn loss(&self, element: usize, class: usize, k: usize, gas_c: f64) -> Vec<(usize, f64)> {
        let mut of = vec![(self.column(self.loss_bank(element, class), k), 1.0)];
        if self.gates && gas_c != 0.0 {
            of.push((self.column(self.gate_bank(class), k), -gas_c));
        }
        of
    }

    /// Parameters of one output for given winds: the relaxations of w.
    pub(super) fn terms(&self, initial_state: InitialState, winds: &ClassConductances) -> Vec<ModelTerm> {
        let mut terms = Vec::new();
        for (column, &role) in self.roles.iter().enumerate() {
            match role {
                Role::Relaxation { bank, k, .. } if bank < self.elements => {
                    let mut of = vec![(column, 1.0)];
                    for class in self.winds() {
                        let taken = winds.conductance[bank][class];
                        of.extend(
                            self.loss(bank, class, k, winds.gas_c).iter().map(|&(at, weight)| (at, -taken * weight)),
                        );
                    }
                    terms.push(ModelTerm { of, role });
                }
                Role::Relaxation { bank, .. } if self.follows && bank == self.gas_bank() => {
                    terms.push(ModelTerm { of: vec![(column, 1.0)], role });
                }
                Role::Initial { .. } if initial_state == InitialState::Free => {
                    terms.push(ModelTerm { of: vec![(column, 1.0)], role })
                }
                Role::Offset => terms.push(ModelTerm { of: vec![(column, 1.0)], role }),
                Role::Relaxation { .. } | Role::FeedThrough { .. } | Role::Initial { .. } | Role::DriftStart { .. } => {
                }
            }
        }
        terms
    }
}
