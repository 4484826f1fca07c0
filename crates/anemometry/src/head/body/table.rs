//! The table `[body]` as it is written: every key that there is, before anything is checked.
//!
//! Laws of convection stand here by name, with the sizes that they need. Their equations, sources
//! and ranges stand with the simulation's code for each.

use std::collections::BTreeMap;

use serde::Deserialize;

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
    /// Surfaces that the wind sees.
    #[serde(default)]
    pub convection: Vec<ConvectionTable>,
    /// The gas that the head is meant for.
    pub gas: Option<BodyGas>,
    /// Difference of a specimen from the file.
    pub tolerances: Option<Tolerances>,
    /// Numbers that nobody has published.
    #[serde(default)]
    pub unknown: Vec<UnknownNumber>,
}

/// An entry of `nodes`
#[derive(Deserialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct NodeTable {
    /// One name, or several.
    pub name: String,
    /// Heat capacity at 0 °C, J/K.
    pub capacity_j_k: f64,
    /// Share that it gains with each kelvin, 1/K.
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
    /// Area of a contact or a gap, m².
    pub area_m2: Option<f64>,
    /// Conductance of a contact, W/(m²·K).
    pub contact_w_m2_k: Option<f64>,
    /// Width of a gap filled with the gas, m.
    pub gap_m: Option<f64>,
    /// Name of a rod's cells: a rod: what its cells are called, from `from` on.
    pub rod: Option<String>,
    /// Heat capacity of a rod, J/K.
    pub capacity_j_k: Option<f64>,
    /// Number of cells of a rod.
    pub cells: Option<usize>,
}

/// `[[body.convection]]`
#[derive(Deserialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct ConvectionTable {
    /// By what law.
    pub correlation: Correlation,
    /// Surfaces that lose heat by it.
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
    /// Gas.
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
    /// Spread of every heat capacity, %.
    pub capacity_percent: f64,
    /// Spread of every conductance between nodes, %.
    pub conductance_percent: f64,
    /// Spread of every surface's area, %.
    pub area_percent: f64,
    /// Spread of the direction in which a surface looks, about either axis across it, °.
    pub normal_deg: f64,
}

/// An entry of `unknown`: a number that nobody has published.
#[derive(Deserialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct UnknownNumber {
    /// Where it stands in the file: dotted, with `[n]` for the n-th of an array.
    pub of: String,
    /// Value in the file.
    #[serde(skip)]
    pub value: f64,
    /// Least that it can be.
    pub least: f64,
    /// Most that it can be.
    pub most: f64,
}

/// Law by which a shape loses heat to a stream.
#[derive(Deserialize, Clone, Debug, PartialEq)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Correlation {
    /// A sphere, whose surfaces are the points nearest to each normal: local Nusselt numbers
    /// computed for Re 1 … 200.
    Sphere {
        /// m
        diameter_m: f64,
    },
    /// A cylinder in crossflow: one surface without normal has the mean by Churchill and Bernstein,
    /// several are sectors around the axis.
    Cylinder(CylinderShape),
    /// A flat plate along whatever wind there is: Pohlhausen's laminar layer on a disc's
    /// conduction.
    Plate(PlateShape),
    /// A fine wire.
    Wire(WireShape),
    /// King's law.
    King(KingLaw),
    /// A measured or computed table.
    Table(NusseltGrid),
    /// Dice on three cards around a boom, as REMS has them: twelve dice, three cards, the head, and
    /// the cells of the shank.
    Boom(BoomShape),
}

/// A cylinder in crossflow.
#[derive(Deserialize, Clone, Copy, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct CylinderShape {
    /// m
    pub diameter_m: f64,
    /// m
    pub length_m: f64,
    /// Axis of any length.
    #[serde(default = "upright")]
    pub axis: [f64; 3],
    /// Share of the speed along the axis that counts.
    #[serde(default)]
    pub yaw_factor: f64,
    /// With it free convection joins in, m/s².
    pub gravity_m_s2: Option<f64>,
}

/// A plate or film on its own.
#[derive(Deserialize, Clone, Copy, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct PlateShape {
    /// Across the stream, m.
    pub length_m: f64,
    /// Along the stream, m.
    pub width_m: f64,
    /// Sides that the gas meets: 1 or 2.
    #[serde(default = "both")]
    pub faces: u8,
    /// With it free convection joins in, m/s².
    pub gravity_m_s2: Option<f64>,
}

/// A fine wire.
#[derive(Deserialize, Clone, Copy, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct WireShape {
    /// m
    pub diameter_m: f64,
    /// m
    pub length_m: f64,
    /// Axis of any length.
    #[serde(default = "upright")]
    pub axis: [f64; 3],
    /// Share of the speed along the wire that counts.
    #[serde(default)]
    pub yaw_factor: f64,
    /// Whose.
    pub law: WireLaw,
}

/// Whose law of a fine wire.
#[derive(Deserialize, Clone, Copy, Debug, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum WireLaw {
    /// Kramers 1946.
    Kramers,
    /// Collis and Williams 1959.
    CollisWilliams,
}

/// King's law, G = a + b Uⁿ, in whatever gas.
#[derive(Deserialize, Clone, Copy, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct KingLaw {
    /// W/K
    pub a_w_k: f64,
    /// Conductance of a wind of 1 m/s, W/K.
    pub b_w_k: f64,
    /// n
    pub exponent: f64,
    /// Axis of any length; without it all directions are alike.
    pub axis: Option<[f64; 3]>,
    /// Share of the speed along the axis that counts.
    #[serde(default)]
    pub yaw_factor: f64,
}

/// A Nusselt number by Reynolds number and the angle between normal and the direction that the wind
/// comes from.
#[derive(Deserialize, Clone, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct NusseltGrid {
    /// For Reynolds and Nusselt number, m.
    pub length_m: f64,
    /// Area of one surface, m².
    pub area_m2: f64,
    /// Ascending.
    pub reynolds: Vec<f64>,
    /// Ascending within 0 … 180; one alone is for all.
    pub angles_deg: Vec<f64>,
    /// A row for every Reynolds number, a number in it for every angle.
    pub nusselt: Vec<Vec<f64>>,
    /// In quiescent gas.
    pub nusselt_at_rest: f64,
}

/// Shape of a boom with cards.
#[derive(Deserialize, Clone, Copy, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct BoomShape {
    /// Side of a square die, m.
    pub die_side_m: f64,
    /// Thickness of a die, m.
    pub die_thickness_m: f64,
    /// Length of a card along the boom, m.
    pub card_length_m: f64,
    /// Width of a card, m.
    pub card_width_m: f64,
    /// Diameter of the boom's head, m.
    pub head_diameter_m: f64,
    /// Length of the boom's head, m.
    pub head_length_m: f64,
    /// Diameter of the boom's shank, m.
    pub shank_diameter_m: f64,
    /// Length of the boom's shank, m.
    pub shank_length_m: f64,
    /// Share of the speed that is left where the wind comes from behind, over what carries the
    /// boom.
    pub shade: f64,
    /// By how much more than the mean a die loses that lies upstream.
    pub front_to_rear: f64,
}

fn upright() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

fn both() -> u8 {
    2
}
