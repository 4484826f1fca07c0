//! A rod between a sensor and its support: the stem of a sphere, the boom of REMS.
//!
//! Cells of equal length: whole conductances between them, half a cell (so twice the conductance)
//! at either end.

use super::network::{BoundaryId, ThermalNetwork};

/// A rod as a whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SupportRod {
    /// From one end to the other.
    pub conductance_w_k: f64,
    pub capacity_j_k: f64,
    pub cells: usize,
}

impl SupportRod {
    /// Adds it, at temperatures between `near_k` and that of the support. The nodes of `near` share
    /// its near end; without any it is free there. Returns the cells from there to the support, and
    /// the way into the support.
    pub fn add(
        &self,
        network: &mut ThermalNetwork,
        near: &[usize],
        near_k: f64,
        support_k: f64,
    ) -> (Vec<usize>, BoundaryId) {
        let count = self.cells;
        let cell_w_k = self.conductance_w_k * count as f64;
        let cells: Vec<usize> = (0..count)
            .map(|k| {
                let position = (k as f64 + 0.5) / count as f64;
                network.add_node(self.capacity_j_k / count as f64, near_k + position * (support_k - near_k))
            })
            .collect();
        for &node in near {
            network.link(node, cells[0], 2.0 * cell_w_k / near.len() as f64);
        }
        for pair in cells.windows(2) {
            network.link(pair[0], pair[1], cell_w_k);
        }
        let support = network.link_to_fixed(cells[count - 1], 2.0 * cell_w_k, support_k);
        (cells, support)
    }
}
