//! Laws of convection by name, with the sizes that they need. Their equations, sources and ranges
//! stand with the simulation's code for each.

use serde::Deserialize;

/// How a shape loses heat to a stream.
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
    /// Of any length.
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
    /// Of any length.
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
    /// Of a wind of 1 m/s, W/K.
    pub b_w_k: f64,
    /// n
    pub exponent: f64,
    /// Of any length; without it all directions are alike.
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
    /// Of one surface, m².
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

/// What the wind sees of a boom with cards.
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
