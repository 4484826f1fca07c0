//! A rod between a sensor and its support: the stem of a sphere, the boom of REMS, the prong of a
//! wire.
//!
//! Cells of equal length: whole conductances between them, half a cell (so twice the conductance)
//! at either end.

use std::ops::Range;

use super::network::{BoundaryId, ThermalNetwork};

/// Where a rod ends.
pub enum FarEnd {
    Node(usize),
    /// Of this temperature, K.
    Support(f64),
}

/// Joins the cells of a rod. The nodes of `near` share its near end; without any it is free there.
/// Returns the way into the support, if it leads there.
pub fn join(
    network: &mut ThermalNetwork,
    near: &[usize],
    cells: Range<usize>,
    far: &FarEnd,
    conductance_w_k: f64,
) -> Option<BoundaryId> {
    let cell_w_k = conductance_w_k * cells.len() as f64;
    for &node in near {
        network.link(node, cells.start, 2.0 * cell_w_k / near.len() as f64);
    }
    for cell in cells.clone().skip(1) {
        network.link(cell - 1, cell, cell_w_k);
    }
    let last = cells.end - 1;
    match far {
        FarEnd::Node(node) => {
            network.link(last, *node, 2.0 * cell_w_k);
            None
        }
        FarEnd::Support(support_k) => Some(network.link_to_fixed(last, 2.0 * cell_w_k, *support_k)),
    }
}

/// Temperature of cell `k` of `count` between the ends, K.
pub fn cell_k(k: usize, count: usize, [near_k, far_k]: [f64; 2]) -> f64 {
    let position = (k as f64 + 0.5) / count as f64;
    near_k + position * (far_k - near_k)
}
