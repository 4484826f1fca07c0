//! What a simulated sensor is made of: one of the bodies that there are, by its name.

use super::body::ThermalBody;
use super::element::SensorElement;
use super::error::{SensorError, require};
use super::rems::{REMS, RemsConstruction};
use super::sphere::SphereConstruction;
use super::sphere_a::SPHERE_A;
use super::sphere_b::SPHERE_B;
use anemometry::gas::{IdealGas, ZERO_CELSIUS_K};

/// A body with all of its numbers. [`Construction::named`] gives the sensors of the project.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Construction {
    /// Surfaces of silver around two cores.
    Sphere(SphereConstruction),
    /// Twelve dice on three cards around a boom.
    Rems(RemsConstruction),
}

impl Construction {
    /// What a head file may call its `sensor`.
    pub const NAMES: [&str; 3] = ["sphere-a", "sphere-b", "rems"];

    /// A sensor of the project.
    pub fn named(name: &str) -> Option<Construction> {
        let all = [Construction::Sphere(SPHERE_A), Construction::Sphere(SPHERE_B), Construction::Rems(REMS)];
        all.into_iter().find(|known| known.name() == name)
    }

    /// The same with a reference beside it, where there can be one.
    pub fn with_reference(self) -> Option<Construction> {
        match self {
            Construction::Sphere(own) => Some(Construction::Sphere(SphereConstruction { reference: true, ..own })),
            Construction::Rems(_) => None,
        }
    }

    /// Its name in head files.
    pub fn name(&self) -> &'static str {
        match self {
            Construction::Sphere(own) => own.name,
            Construction::Rems(_) => "rems",
        }
    }

    /// Its elements, in the order of heater bits and codes.
    pub fn elements(&self) -> Vec<SensorElement> {
        match self {
            Construction::Sphere(own) => own.elements(),
            Construction::Rems(_) => super::rems::elements(),
        }
    }

    /// Where its convection ends, as in "the wind was beyond …".
    pub fn validity(&self) -> &'static str {
        match self {
            Construction::Sphere(_) => "the computed Nusselt numbers (Re 200)",
            Construction::Rems(_) => "the laminar boundary layer (Re 5e5 on a card)",
        }
    }

    /// The body in equilibrium with the gas, its stem or boom between gas and support.
    pub(super) fn body(&self, gas: &IdealGas, support_k: f64) -> Result<ThermalBody, SensorError> {
        let (possible, celsius) = (support_k.is_finite() && support_k > 0.0, support_k - ZERO_CELSIUS_K);
        require(possible, "support.temperature_c", celsius, "above -273.15")?;
        match self {
            Construction::Sphere(own) => own.body(gas, support_k),
            Construction::Rems(own) => own.body(gas, support_k),
        }
    }
}

impl Default for Construction {
    fn default() -> Construction {
        Construction::Sphere(SPHERE_B)
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
