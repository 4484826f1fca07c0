//! The reference: a small platinum film on its own in the stream near a sphere, that measures the
//! gas.
//!
//! ```text
//! C dT/dt = P + G (T_gas − T) + ε σ A (T_surroundings⁴ − T⁴)          lag C / G
//! ```
//!
//! | part | value | origin |
//! |---|---|---|
//! | film | 4 × 2.5 mm | assumed: platinum between two foils of polyimide, 75 µm together |
//! | capacity | 1.0 mJ/K | derived: 1.07 mg at 1420 kg/m³ and 0.9 J/(g·K) at 230 K; platinum, glue and pads the rest |
//! | to the gas | 0.43 mW/K in 5 m/s of CO₂ at 1000 Pa and 220 K | derived: by its [correlation](super::convection::film); 0.15 mW/K without wind |
//! | emissivity | 0.03 | assumed: gilded, as the spheres: bare polyimide would read 8 % of the way from the gas to the surroundings |
//!
//! It lags by 2.3 s in 5 m/s, 6.4 s without wind. Element and surface are both called `reference`;
//! the element is the last of its head.
//!
//! Limits: no heat through its wires; it neither warms the sphere's gas nor stands in the sphere's
//! wake; one temperature all over.

use super::body::Surface;
use super::convection::BodyConvection;
use super::convection::film::Film;
use super::element::SensorElement;
use super::error::SensorError;
use super::network::ThermalNetwork;
use anemometry::gas::IdealGas;
use recording::REFERENCE;

const LENGTH_M: f64 = 4e-3;
const WIDTH_M: f64 = 2.5e-3;
const CAPACITY_J_K: f64 = 1e-3;
const EMISSIVITY: f64 = 0.03;

/// Puts it beside a body, as its last element and its last surface; returns the convection of both.
pub(super) fn beside(
    network: &mut ThermalNetwork,
    elements: &mut Vec<usize>,
    surfaces: &mut Vec<Surface>,
    convection: BodyConvection,
    gas: &IdealGas,
) -> Result<BodyConvection, SensorError> {
    let film = Film::new(gas, LENGTH_M, WIDTH_M)?;
    let node = network.add_node(CAPACITY_J_K, gas.temperature_k);
    surfaces.push(Surface {
        name: REFERENCE.to_owned(),
        node,
        emissivity: EMISSIVITY,
        area_m2: 2.0 * LENGTH_M * WIDTH_M,
        carries: Vec::new(),
        element: Some(elements.len()),
    });
    elements.push(node);
    Ok(BodyConvection::Beside(Box::new(convection), film))
}

/// The element.
pub(super) fn element() -> SensorElement {
    SensorElement { name: REFERENCE.to_owned(), normal: None }
}
