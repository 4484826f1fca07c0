//! Parts of a checked body by number: nodes, links with the nodes that they join, surfaces.

use std::collections::{BTreeMap, VecDeque};
use std::ops::Range;

use super::table::Correlation;

/// A lump of one temperature.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyNode {
    /// Its name.
    pub name: String,
    /// Heat capacity at 0 °C, J/K.
    pub capacity_j_k: f64,
    /// Share that it gains with each kelvin, 1/K.
    pub capacity_slope_per_k: f64,
}

/// An element as the body knows it.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyElement {
    /// Name in the head file.
    pub name: String,
    /// Outward unit vector of what the wind sees of it; none inside, nor where all winds see the
    /// same.
    pub normal: Option<[f64; 3]>,
}

/// A way between nodes; `to` is none where it leads to the support.
#[derive(Clone, Debug, PartialEq)]
pub enum BodyLink {
    /// Law of a conductance that stays.
    Solid {
        /// A node.
        from: usize,
        /// Another, or the support.
        to: Option<usize>,
        /// W/K
        conductance_w_k: f64,
    },
    /// Filled with the gas, by whose conductivity at the temperature between its ends it conducts.
    Gap {
        /// A node.
        from: usize,
        /// Another.
        to: usize,
        /// Area over width, m.
        area_over_width_m: f64,
    },
    /// A rod, whose near end several nodes may share.
    Rod {
        /// Nodes at its near end.
        from: Vec<usize>,
        /// Node at its far end, or the support.
        to: Option<usize>,
        /// Nodes of its cells, from the near end on.
        cells: Range<usize>,
        /// From end to end, W/K.
        conductance_w_k: f64,
    },
}

/// A law, and what loses heat by it.
#[derive(Clone, Debug, PartialEq)]
pub struct Convection {
    /// The law.
    pub correlation: Correlation,
    /// The surfaces, in the order of the file.
    pub surfaces: Vec<BodySurface>,
}

/// A surface in the wind.
#[derive(Clone, Debug, PartialEq)]
pub struct BodySurface {
    /// Its name.
    pub name: String,
    /// Its node.
    pub node: usize,
    /// The element that heats it, by its number.
    pub element: Option<usize>,
    /// Outward unit vector, where the law needs one.
    pub normal: Option<[f64; 3]>,
    /// In place of that of the law's shape, m².
    pub area_m2: Option<f64>,
    /// Its area over what the file has: 1, but in a specimen.
    pub area_factor: f64,
    /// 0 radiates nothing.
    pub emissivity: f64,
    /// Nodes on the way from it to its element, which count as its own: their heat is stored in it.
    pub carries: Vec<usize>,
}

/// Ends of every link.
pub(super) fn ways(links: &[BodyLink]) -> impl Iterator<Item = (usize, Option<usize>)> + '_ {
    links.iter().flat_map(|link| match link {
        BodyLink::Solid { from, to, .. } => vec![(*from, *to)],
        BodyLink::Gap { from, to, .. } => vec![(*from, Some(*to))],
        BodyLink::Rod { from, to, cells, .. } => {
            let near = from.iter().map(|&node| (node, Some(cells.start)));
            let along = cells.clone().skip(1).map(|cell| (cell - 1, Some(cell)));
            near.chain(along).chain([(cells.end - 1, *to)]).collect()
        }
    })
}

pub(super) fn neighbours(links: &[BodyLink], node: usize) -> impl Iterator<Item = usize> + '_ {
    ways(links).filter_map(move |(from, to)| match to? {
        to if from == node => Some(to),
        to if to == node => Some(from),
        _ => None,
    })
}

/// Nodes on the shortest way from one node to another, the last one included.
pub(super) fn way(links: &[BodyLink], from: usize, to: usize) -> Vec<usize> {
    let mut before: BTreeMap<usize, usize> = BTreeMap::from([(from, from)]);
    let mut reached = VecDeque::from([from]);
    while let Some(node) = reached.pop_front().filter(|node| *node != to) {
        for next in neighbours(links, node) {
            before.entry(next).or_insert_with(|| {
                reached.push_back(next);
                node
            });
        }
    }
    let mut way = Vec::new();
    let mut node = to;
    while let Some(&previous) = before.get(&node).filter(|_| node != from) {
        way.push(node);
        node = previous;
    }
    way.reverse();
    way
}
