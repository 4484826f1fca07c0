//! A body with every name resolved and every number found possible. Refusals name the key and line
//! of the head file.

use std::collections::VecDeque;

use super::parts::{BodyLink, BodyNode, BodySurface, Convection, UnknownNumber};
use super::reader::BodyReader;
use super::table::{BodyGas, BodyTable, Tolerances};
use super::unknown;
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
    /// Numbers that nobody has published.
    pub unknown: Vec<UnknownNumber>,
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
            unknown: unknown::found(source, &table.unknown)?,
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
