//! The table `[body]` as it is written: every key that there is, before anything is checked.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::correlation::Correlation;
use crate::gas::Species;

/// `[body]`
#[derive(Deserialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct BodyTable {
    /// Lumps of one temperature.
    pub nodes: Vec<NodeTable>,
    /// Ways between them.
    #[serde(default)]
    pub links: Vec<LinkTable>,
    /// Node of an element, by its name; by default the node that is called as the element is.
    #[serde(default)]
    pub elements: BTreeMap<String, String>,
    /// What the wind sees.
    #[serde(default)]
    pub convection: Vec<ConvectionTable>,
    /// The gas that the head is meant for.
    pub gas: Option<BodyGas>,
    /// How much a specimen differs from the file.
    pub tolerances: Option<Tolerances>,
    /// Numbers that nobody has published.
    #[serde(default)]
    pub unknown: Vec<UnknownTable>,
}

/// An entry of `nodes`
#[derive(Deserialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct NodeTable {
    /// One name, or several.
    pub name: String,
    /// Heat capacity at 0 °C, J/K.
    pub capacity_j_k: f64,
    /// How much of that it gains with each kelvin, 1/K.
    #[serde(default)]
    pub capacity_slope_per_k: f64,
}

/// An entry of `links`
#[derive(Deserialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct LinkTable {
    /// One end.
    pub from: Option<String>,
    /// The other: as many as `from`, one node, or `support`.
    pub to: Option<String>,
    /// In place of `from` and `to`: every two of these.
    pub among: Option<String>,
    /// From end to end, W/K.
    pub conductance_w_k: Option<f64>,
    /// Of a contact or a gap, m².
    pub area_m2: Option<f64>,
    /// Conductance of a contact, W/(m²·K).
    pub contact_w_m2_k: Option<f64>,
    /// Width of a gap filled with the gas, m.
    pub gap_m: Option<f64>,
    /// Of a rod: what its cells are called, from `from` on.
    pub rod: Option<String>,
    /// Of a rod, J/K.
    pub capacity_j_k: Option<f64>,
    /// Of a rod.
    pub cells: Option<usize>,
}

/// `[[body.convection]]`
#[derive(Deserialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct ConvectionTable {
    /// By what law.
    pub correlation: Correlation,
    /// What loses heat by it.
    pub surfaces: Vec<BodySurfaceTable>,
}

/// An entry of `surfaces`
#[derive(Deserialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct BodySurfaceTable {
    /// One name, or several.
    pub name: String,
    /// Its node; by default the one of that name.
    pub node: Option<String>,
    /// The element that heats it; by default the one of that name, if there is one.
    pub element: Option<String>,
    /// Outward; by default that of its element.
    pub normal: Option<[f64; 3]>,
    /// By default that of the correlation's shape, m².
    pub area_m2: Option<f64>,
    /// 0 (the default) radiates nothing.
    #[serde(default)]
    pub emissivity: f64,
}

/// `[body.gas]`
#[derive(Deserialize, Clone, Copy, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct BodyGas {
    /// Which gas.
    pub species: Species,
    /// Its pressure, Pa.
    pub pressure_pa: f64,
    /// Its temperature, °C.
    pub temperature_c: f64,
}

/// `[body.tolerances]`: standard deviations between specimens; a run's seed draws one of them.
#[derive(Deserialize, Clone, Copy, Debug, Default, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub struct Tolerances {
    /// Of every heat capacity, %.
    pub capacity_percent: f64,
    /// Of every conductance between nodes, %.
    pub conductance_percent: f64,
    /// Of every surface's area, %.
    pub area_percent: f64,
    /// Of the direction in which a surface looks, about either axis across it, °.
    pub normal_deg: f64,
}

/// An entry of `unknown`
#[derive(Deserialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct UnknownTable {
    /// Where it stands in the file: dotted, with `[n]` for the n-th of an array.
    pub of: String,
    /// Least that it can be.
    pub least: f64,
    /// Most that it can be.
    pub most: f64,
}
