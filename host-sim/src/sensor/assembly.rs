//! From the `[body]` of a head file to a body that takes heat and loses it.
//!
//! A rod leads from a sensor to its support: the stem of a sphere, the boom of REMS, the prong of a
//! wire. Its cells have equal lengths, with whole conductances between them and half a cell (so twice
//! the conductance) at either end.

use anemometry::gas::IdealGas;
use anemometry::head::body::{Body, BodyLink};

use super::body::{BodyParts, GasGap, Surface, ThermalBody};
use super::convection::BodyConvection;
use super::error::SensorError;
use super::network::ThermalNetwork;

/// The body of all tables together, in equilibrium with the gas, its rods between gas and support.
///
/// # Errors
/// If the gas is too thin for a law of convection.
pub fn assemble(bodies: &[Body], gas: &IdealGas, support_k: f64) -> Result<ThermalBody, SensorError> {
    let (mut network, mut parts) = (ThermalNetwork::default(), BodyParts::default());
    for body in bodies {
        let base = network.len();
        add_nodes(&mut network, body, [gas.temperature_k, support_k]);
        for link in &body.links {
            add_link(&mut network, &mut parts, link, base, gas, support_k);
        }
        let heated = parts.elements.len();
        parts.elements.extend(body.elements.iter().map(|node| base + node));
        for group in &body.convection {
            let law = BodyConvection::new(group, gas)?;
            let first = parts.surfaces.len();
            for (i, of) in group.surfaces.iter().enumerate() {
                let shape_m2 = law.area_m2(i);
                let given = of.area_m2.filter(|_| shape_m2 > 0.0).map_or(1.0, |area_m2| area_m2 / shape_m2);
                let factor = given * of.area_factor;
                parts.surfaces.push(Surface {
                    name: of.name.clone(),
                    node: base + of.node,
                    emissivity: of.emissivity,
                    area_m2: of.area_m2.unwrap_or(shape_m2) * of.area_factor,
                    factor,
                    carries: of.carries.iter().map(|node| base + node).collect(),
                    element: of.element.map(|element| heated + element),
                });
            }
            parts.convection.push((law, first..parts.surfaces.len()));
        }
    }
    Ok(ThermalBody::new(network, parts, gas))
}

/// Nodes at the gas's temperature, cells of a rod between it and the support's.
fn add_nodes(network: &mut ThermalNetwork, body: &Body, [gas_k, support_k]: [f64; 2]) {
    let cell = |node: usize| {
        body.links.iter().find_map(|link| match link {
            BodyLink::Rod { to: None, cells, .. } if cells.contains(&node) => {
                Some(cell_k(node - cells.start, cells.len(), [gas_k, support_k]))
            }
            _ => None,
        })
    };
    for (number, node) in body.nodes.iter().enumerate() {
        network.add_node(node.capacity_j_k, cell(number).unwrap_or(gas_k));
        network.slope_last_capacity(node.capacity_slope_per_k);
    }
}

fn add_link(
    network: &mut ThermalNetwork,
    parts: &mut BodyParts,
    link: &BodyLink,
    base: usize,
    gas: &IdealGas,
    support_k: f64,
) {
    match link {
        BodyLink::Solid { from, to: Some(to), conductance_w_k } => {
            network.link(base + from, base + to, *conductance_w_k);
        }
        BodyLink::Solid { from, to: None, conductance_w_k } => {
            parts.supports.push(network.link_to_fixed(base + from, *conductance_w_k, support_k));
        }
        BodyLink::Gap { from, to, area_over_width_m } => {
            let ends = [base + from, base + to];
            let link = network.link(ends[0], ends[1], area_over_width_m * gas.conductivity_w_m_k);
            parts.gaps.push(GasGap { link, ends, area_over_width_m: *area_over_width_m });
        }
        BodyLink::Rod { from, to, cells, conductance_w_k } => {
            let (near, cells) = (from.iter().map(|node| base + node), base + cells.start..base + cells.end);
            let cell_w_k = conductance_w_k * cells.len() as f64;
            // The nodes share its near end; without any it is free there.
            for node in near {
                network.link(node, cells.start, 2.0 * cell_w_k / from.len() as f64);
            }
            for cell in cells.clone().skip(1) {
                network.link(cell - 1, cell, cell_w_k);
            }
            let last = cells.end - 1;
            match to {
                Some(node) => drop(network.link(last, base + node, 2.0 * cell_w_k)),
                None => {
                    parts.supports.push(network.link_to_fixed(last, 2.0 * cell_w_k, support_k));
                    parts.stem_ends.push(cells.start);
                }
            }
        }
    }
}

/// Temperature of cell `k` of `count` between the ends, K.
fn cell_k(k: usize, count: usize, [near_k, far_k]: [f64; 2]) -> f64 {
    let position = (k as f64 + 0.5) / count as f64;
    near_k + position * (far_k - near_k)
}
