//! A sphere as a thermal network: silver surfaces with an element each, two core heaters, a stem.
//! The prototypes are in [`sphere_a`](super::sphere_a) and [`sphere_b`](super::sphere_b).
//!
//! ```text
//!   gas ── surface 1 ── layers … ── element 1     and the same with the others; every surface
//!            │   ╲                                touches each other one, and radiates to
//!            │    surface 2 …                     surroundings at gas temperature
//!          core 1 ══ core 2                       the first half of the surfaces faces core 1
//!               ╲    ╱
//!            stem ── support at a fixed temperature
//! ```
//!
//! Limits: surfaces without gradient; what they carry loses nothing to the gas inside, the stem
//! nothing to the wind; no temperature dependence of the parts.

use std::f64::consts::PI;

use super::body::{Surface, ThermalBody};
use super::convection::BodyConvection;
use super::convection::sphere_surfaces::{SphereDivision, SphereSurfaces};
use super::element::SensorElement;
use super::error::SensorError;
use super::network::ThermalNetwork;
use super::reference;
use super::rod::SupportRod;
use anemometry::gas::IdealGas;

const CORES: usize = 2;

/// What a sphere is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereConstruction {
    /// In head files.
    pub name: &'static str,
    pub diameter_m: f64,
    pub division: SphereDivision,
    pub surface_capacity_j_k: f64,
    /// What every surface carries, from the silver to the element, which is the last.
    pub layers: &'static [CarriedLayer],
    pub surface_to_core_w_k: f64,
    pub surface_to_surface_w_k: f64,
    pub core_capacity_j_k: f64,
    pub core_to_core_w_k: f64,
    pub stem: SupportRod,
    pub emissivity: f64,
    /// Whether there is an element of its own in the stream.
    pub reference: bool,
}

/// A layer on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CarriedLayer {
    pub capacity_j_k: f64,
    /// To the layer before it, or the surface.
    pub contact_w_k: f64,
}

impl SphereConstruction {
    pub(super) fn body(&self, gas: &IdealGas, support_k: f64) -> Result<ThermalBody, SensorError> {
        let mut network = ThermalNetwork::default();
        let gas_k = gas.temperature_k;
        let count = self.division.axes().len();
        let mut nodes = |count: usize, capacity_j_k: f64| -> Vec<usize> {
            (0..count).map(|_| network.add_node(capacity_j_k, gas_k)).collect()
        };
        // The silver and what it carries, layer by layer.
        let mut shells = vec![nodes(count, self.surface_capacity_j_k)];
        shells.extend(self.layers.iter().map(|layer| nodes(count, layer.capacity_j_k)));
        let cores = nodes(CORES, self.core_capacity_j_k);
        let silver = &shells[0];
        for i in 0..count {
            for (pair, layer) in shells.windows(2).zip(self.layers).rev() {
                network.link(pair[1][i], pair[0][i], layer.contact_w_k);
            }
            network.link(silver[i], cores[i * CORES / count], self.surface_to_core_w_k);
            for j in 0..i {
                network.link(silver[i], silver[j], self.surface_to_surface_w_k);
            }
        }
        network.link(cores[0], cores[1], self.core_to_core_w_k);
        let (_, support) = self.stem.add(&mut network, &cores, gas_k, support_k);

        let surface = |i: usize| Surface {
            name: format!("{}{}", self.division.name(), i + 1),
            node: silver[i],
            emissivity: self.emissivity,
            area_m2: PI * self.diameter_m * self.diameter_m / count as f64,
            carries: shells[1..].iter().map(|layer| layer[i]).collect(),
            element: Some(i),
        };
        let mut surfaces: Vec<Surface> = (0..count).map(surface).collect();
        let mut elements: Vec<usize> = shells.last().into_iter().flatten().chain(&cores).copied().collect();
        let mut convection = BodyConvection::Sphere(SphereSurfaces::new(gas, self.diameter_m, self.division)?);
        if self.reference {
            convection = reference::beside(&mut network, &mut elements, &mut surfaces, convection, gas)?;
        }
        Ok(ThermalBody::new(network, elements, surfaces, support, convection, gas))
    }

    /// Its elements: on the surfaces, in the cores, and the reference, if there is one.
    pub(super) fn elements(&self) -> Vec<SensorElement> {
        let named = |name: &str, i: usize, normal| SensorElement { name: format!("{name}{}", i + 1), normal };
        let axes = self.division.axes();
        let surfaces = axes.iter().enumerate().map(|(i, &axis)| named(self.division.name(), i, Some(axis)));
        let cores = (0..CORES).map(|i| named("core", i, None));
        surfaces.chain(cores).chain(self.reference.then(reference::element)).collect()
    }
}
