//! A body with every name resolved and every number found possible. Refusals name the key and line
//! of the head file.

use std::collections::VecDeque;
use std::ops::Range;

use super::correlation::Correlation;
use super::reader::BodyReader;
use super::table::{BodyGas, BodyTable, Tolerances};
use super::ways::{neighbours, ways};
use crate::gas::{IdealGas, ZERO_CELSIUS_K};
use crate::head::element::HeadElement;
use recording::toml_file::{FileError, TomlSource};

/// A standard deviation, %.
const MOST_PERCENT: f64 = 30.0;

/// A checked body.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// All nodes; those of rods stand behind the others.
    pub nodes: Vec<BodyNode>,
    /// In the order of the file.
    pub links: Vec<BodyLink>,
    /// Node of every element of the head, in its order.
    pub elements: Vec<usize>,
    /// What the wind sees.
    pub convection: Vec<Convection>,
    /// The gas that the head is meant for.
    pub gas: Option<BodyGas>,
    /// How much a specimen differs.
    pub tolerances: Option<Tolerances>,
}

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

impl Body {
    /// The body of a table.
    ///
    /// # Errors
    /// The key and line of what is not known, stands twice or cannot be.
    pub fn from_table(source: &TomlSource, table: &BodyTable, elements: &[HeadElement]) -> Result<Self, FileError> {
        let mut body = BodyReader::new(source, elements);
        body.add_nodes(table)?;
        let links = body.links(&table.links)?;
        let nodes_of = body.elements(&table.elements)?;
        let mut convection = Vec::new();
        for (i, group) in table.convection.iter().enumerate() {
            convection.push(body.convection(&format!("body.convection[{i}]"), group, &nodes_of, &links)?);
        }
        let checked = Self {
            nodes: body.nodes,
            links,
            elements: nodes_of,
            convection,
            gas: table.gas,
            tolerances: table.tolerances,
        };
        checked.check(source)?;
        Ok(checked)
    }

    /// All surfaces, in the order in which a simulation counts them.
    pub fn surfaces(&self) -> impl Iterator<Item = &BodySurface> {
        self.convection.iter().flat_map(|group| &group.surfaces)
    }

    fn check(&self, source: &TomlSource) -> Result<(), FileError> {
        let mut names: Vec<&str> = Vec::new();
        let mut heated: Vec<usize> = Vec::new();
        for surface in self.surfaces() {
            if names.contains(&surface.name.as_str()) {
                let sentence = format!("names the surface `{}` twice", surface.name);
                return Err(source.refuse("body.convection", sentence));
            }
            if let Some(element) = surface.element.filter(|element| heated.contains(element)) {
                let sentence = format!("gives element {} two surfaces: one of them is heated by it", element + 1);
                return Err(source.refuse("body.convection", sentence));
            }
            names.push(&surface.name);
            heated.extend(surface.element);
        }
        if let Some(node) = self.insulated() {
            let sentence = format!(
                "leave `{}` without any way to the gas or the `support`: its temperature would rise for ever",
                self.nodes[node].name
            );
            return Err(source.refuse("body.links", sentence));
        }
        if let Some(gas) = self.gas {
            let known = IdealGas::new(gas.species, gas.pressure_pa, gas.temperature_c + ZERO_CELSIUS_K);
            known.map_err(|error| source.refuse("body.gas", format!("cannot be: {error}")))?;
        }
        if let Some(of) = self.tolerances {
            for (key, percent) in [
                ("capacity_percent", of.capacity_percent),
                ("conductance_percent", of.conductance_percent),
                ("area_percent", of.area_percent),
                ("normal_deg", of.normal_deg),
            ] {
                source.within(&format!("body.tolerances.{key}"), percent, 0.0..=MOST_PERCENT, "")?;
            }
        }
        Ok(())
    }

    /// Ends of every link: nodes, or none for the support.
    pub fn ways(&self) -> impl Iterator<Item = (usize, Option<usize>)> + '_ {
        ways(&self.links)
    }

    /// A node that no heat can leave.
    fn insulated(&self) -> Option<usize> {
        let mut open: Vec<bool> = vec![false; self.nodes.len()];
        let mut reached: VecDeque<usize> = self.surfaces().map(|surface| surface.node).collect();
        reached.extend(self.ways().filter(|(_, to)| to.is_none()).map(|(from, _)| from));
        while let Some(node) = reached.pop_front() {
            if !std::mem::replace(&mut open[node], true) {
                reached.extend(neighbours(&self.links, node));
            }
        }
        open.iter().position(|open| !open)
    }
}
