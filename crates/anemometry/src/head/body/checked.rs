//! A body with every name resolved and every number found possible, those included that nobody has
//! published. Refusals name the key and line of the head file.

use std::collections::VecDeque;

use recording::toml_file::{FileError, TomlSource};
use toml::Value;

use super::super::element::HeadElement;
use super::parts::{BodyLink, BodyNode, BodySurface, Convection, neighbours, ways};
use super::reader::BodyReader;
use super::table::{BodyGas, BodyTable, Tolerances, UnknownNumber};

use crate::gas::{IdealGas, ZERO_CELSIUS_K};

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
    /// Surfaces that the wind sees.
    pub convection: Vec<Convection>,
    /// The gas that the head is meant for.
    pub gas: Option<BodyGas>,
    /// Difference of a specimen.
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
        let group = |(i, group)| body.convection(&format!("body.convection[{i}]"), group, &nodes_of, &links);
        let convection = table.convection.iter().enumerate().map(group).collect::<Result<_, _>>()?;
        let checked = Self {
            nodes: body.nodes,
            links,
            elements: nodes_of,
            convection,
            gas: table.gas,
            tolerances: table.tolerances,
            unknown: unknown_numbers(source, table.unknown.clone())?,
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

/// Every entry with the value that the file has.
///
/// # Errors
/// If nothing or no number stands there, or it is beyond its range.
fn unknown_numbers(source: &TomlSource, mut all: Vec<UnknownNumber>) -> Result<Vec<UnknownNumber>, FileError> {
    let mut document: Value = source.parse()?;
    for (i, UnknownNumber { of, value, least, most }) in all.iter_mut().enumerate() {
        let key = format!("body.unknown[{i}]");
        let stands =
            place(&mut document, of).and_then(|stands| stands.as_float().or(stands.as_integer().map(|n| n as f64)));
        *value = stands.ok_or_else(|| source.refuse(&key, format!("names `{of}`, where no number stands")))?;
        if !(*least > 0.0 && most.is_finite() && least < most && (*least..=*most).contains(value)) {
            let sentence = format!("has `{of}` between {least} and {most}: above 0, and around its {value}");
            return Err(source.refuse(&key, sentence));
        }
    }
    Ok(all)
}

/// Value at a dotted key, with `[n]` for the n-th of an array.
pub fn place<'a>(document: &'a mut Value, of: &str) -> Option<&'a mut Value> {
    let mut value = document;
    for step in of.split('.') {
        let (name, indices) = step.split_at(step.find('[').unwrap_or(step.len()));
        value = value.get_mut(name)?;
        for index in indices.split(['[', ']']).filter(|index| !index.is_empty()) {
            value = value.get_mut(index.parse::<usize>().ok()?)?;
        }
    }
    Some(value)
}
