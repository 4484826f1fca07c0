//! What a checked body consists of: nodes, links, surfaces, all by number.

use std::ops::Range;

use super::correlation::Correlation;

/// A lump of one temperature.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyNode {
    /// Its name.
    pub name: String,
    /// Heat capacity at 0 °C, J/K.
    pub capacity_j_k: f64,
    /// How much of that it gains with each kelvin, 1/K.
    pub capacity_slope_per_k: f64,
}

/// An element as the body knows it.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyElement {
    /// As the head file has it.
    pub name: String,
    /// Outward unit vector of what the wind sees of it; none inside, nor where all winds see the
    /// same.
    pub normal: Option<[f64; 3]>,
}

/// A way between nodes; `to` is none where it leads to the support.
#[derive(Clone, Debug, PartialEq)]
pub enum BodyLink {
    /// Of a conductance that stays.
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

/// A number that nobody has published.
#[derive(Clone, Debug, PartialEq)]
pub struct UnknownNumber {
    /// Where it stands in the file.
    pub of: String,
    /// What the file has.
    pub value: f64,
    /// Least that it can be.
    pub least: f64,
    /// Most that it can be.
    pub most: f64,
}
