//! The ends of stems at the head, from which the wind takes heat.

use super::field::Stem;
use super::network::{BoundaryId, ThermalNetwork};

/// The ends of all stems: their way to the gas, and their nodes.
#[derive(Clone, Debug)]
pub struct CooledStem {
    of: Stem,
    ends: Vec<(BoundaryId, usize)>,
}

impl CooledStem {
    /// Of these nodes in a gas at rest; none without nodes.
    pub fn new(of: Stem, network: &mut ThermalNetwork, nodes: &[usize], gas_k: f64) -> Option<Self> {
        let conductance_w_k = of.loss_w_k(0.0) / nodes.len() as f64;
        let ends = nodes.iter().map(|&node| (network.link_to_fixed(node, conductance_w_k, gas_k), node)).collect();
        (!nodes.is_empty()).then_some(Self { of, ends })
    }

    pub fn set_gas_k(&self, network: &mut ThermalNetwork, gas_k: f64) {
        self.ends.iter().for_each(|&(link, _)| network.boundary_mut(link).temperature_k = gas_k);
    }

    /// Sets the wind, and returns what it adds to the fastest rate, 1/s.
    pub fn set_speed(&self, network: &mut ThermalNetwork, speed_m_s: f64) -> f64 {
        let conductance_w_k = self.of.loss_w_k(speed_m_s) / self.ends.len() as f64;
        let mut rate_per_s = 0.0_f64;
        for &(link, node) in &self.ends {
            network.boundary_mut(link).conductance_w_k = conductance_w_k;
            rate_per_s = rate_per_s.max(conductance_w_k / network.capacity_j_k(node));
        }
        rate_per_s
    }

    /// Heat that has left from stems to the gas, J.
    pub fn heat_j(&self, network: &ThermalNetwork) -> f64 {
        self.ends.iter().map(|&(link, _)| network.boundary_heat_j(link)).sum()
    }
}
