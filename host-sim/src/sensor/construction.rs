//! What a simulated sensor is made of: one of the bodies that there are, by its name.

use super::body::ThermalBody;
use super::element::SensorElement;
use super::error::SensorError;
use super::reference::Reference;
use super::{rems, sphere_a, sphere_b};
use anemometry::gas::{IdealGas, ZERO_CELSIUS_K};

/// A body with all of its numbers. [`Construction::named`] gives the sensors of the project.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Construction {
    /// Two hemispheres and two cores.
    SphereA(sphere_a::SphereAConstruction),
    /// Four sectors and two cores.
    SphereB(sphere_b::SphereBConstruction),
    /// Twelve dice on three cards around a boom.
    Rems(rems::RemsConstruction),
}

impl Construction {
    /// What a head file may call its `sensor`.
    pub const NAMES: [&str; 3] = ["sphere-a", "sphere-b", "rems"];

    /// A sensor of the project.
    pub fn named(name: &str) -> Option<Construction> {
        match name {
            "sphere-a" => Some(Construction::SphereA(sphere_a::SphereAConstruction::default())),
            "sphere-b" => Some(Construction::SphereB(sphere_b::SphereBConstruction::default())),
            "rems" => Some(Construction::Rems(rems::RemsConstruction::default())),
            _ => None,
        }
    }

    /// The same with a reference beside it, where there can be one.
    pub fn with_reference(self) -> Option<Construction> {
        let reference = Some(Reference::default());
        match self {
            Construction::SphereA(own) => {
                Some(Construction::SphereA(sphere_a::SphereAConstruction { reference, ..own }))
            }
            Construction::SphereB(own) => {
                Some(Construction::SphereB(sphere_b::SphereBConstruction { reference, ..own }))
            }
            Construction::Rems(_) => None,
        }
    }

    /// Its name in head files.
    pub fn name(&self) -> &'static str {
        match self {
            Construction::SphereA(_) => "sphere-a",
            Construction::SphereB(_) => "sphere-b",
            Construction::Rems(_) => "rems",
        }
    }

    /// Its elements, in the order of heater bits and codes.
    pub fn elements(&self) -> Vec<SensorElement> {
        match self {
            Construction::SphereA(own) => sphere_a::elements(own),
            Construction::SphereB(own) => sphere_b::elements(own),
            Construction::Rems(_) => rems::elements(),
        }
    }

    /// Where its convection ends, as in "the wind was beyond …".
    pub fn validity(&self) -> &'static str {
        match self {
            Construction::SphereA(_) | Construction::SphereB(_) => "the computed Nusselt numbers (Re 200)",
            Construction::Rems(_) => "the laminar boundary layer (Re 5e5 on a card)",
        }
    }

    /// The body in equilibrium with the gas, its stem or boom between gas and support.
    pub(super) fn body(&self, gas: &IdealGas, support_k: f64) -> Result<ThermalBody, SensorError> {
        if !(support_k.is_finite() && support_k > 0.0) {
            let celsius = support_k - ZERO_CELSIUS_K;
            return Err(SensorError::out_of_range("support.temperature_c", celsius, "above -273.15"));
        }
        match self {
            Construction::SphereA(construction) => construction.body(gas, support_k),
            Construction::SphereB(construction) => construction.body(gas, support_k),
            Construction::Rems(construction) => construction.body(gas, support_k),
        }
    }
}

impl Default for Construction {
    fn default() -> Construction {
        Construction::SphereB(sphere_b::SphereBConstruction::default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sensor_has_the_name_that_it_is_asked_for_by() {
        for name in Construction::NAMES {
            let construction = Construction::named(name).unwrap();
            assert_eq!(construction.name(), name);
            let parts = construction.elements();
            for normal in parts.iter().filter_map(|part| part.normal) {
                assert!((normal.iter().map(|v| v * v).sum::<f64>() - 1.0).abs() < 1e-12);
            }
        }
        assert_eq!(Construction::named("sphere-c"), None);
        let count = |name| Construction::named(name).unwrap().elements().len();
        assert_eq!(["sphere-a", "sphere-b", "rems"].map(count), [4, 6, 13]);
        let beside = |name| {
            let parts = Construction::named(name).unwrap().with_reference()?.elements();
            Some((parts.len(), parts.last().unwrap().name.clone()))
        };
        let last = |count| Some((count, "reference".to_owned()));
        assert_eq!(["sphere-a", "sphere-b", "rems"].map(beside), [last(5), last(7), None]);
    }
}
