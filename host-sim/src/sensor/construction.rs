//! What a simulated sensor is made of: one of the bodies that there are, by its name.

use super::body::Body;
use super::gas::{Gas, ZERO_CELSIUS_K};
use super::reference::Reference;
use super::{SensorError, rems, sphere_a, sphere_b};

/// A body with all of its numbers. [`Construction::named`] gives the sensors of the project.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Construction {
    SphereA(sphere_a::Construction),
    SphereB(sphere_b::Construction),
    Rems(rems::Construction),
}

/// An element as the body knows it.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    pub name: String,
    /// Outward unit vector of what the wind sees of it; none inside, nor where all winds see the same.
    pub normal: Option<[f64; 3]>,
}

impl Construction {
    /// What a head file may call its `sensor`.
    pub const NAMES: [&str; 3] = ["sphere-a", "sphere-b", "rems"];

    /// A sensor of the project.
    pub fn named(name: &str) -> Option<Construction> {
        match name {
            "sphere-a" => Some(Construction::SphereA(sphere_a::Construction::default())),
            "sphere-b" => Some(Construction::SphereB(sphere_b::Construction::default())),
            "rems" => Some(Construction::Rems(rems::Construction::default())),
            _ => None,
        }
    }

    /// The same with a [`reference`](super::reference) beside it, where there can be one.
    pub fn with_reference(self) -> Option<Construction> {
        let reference = Some(Reference::default());
        match self {
            Construction::SphereA(own) => Some(Construction::SphereA(sphere_a::Construction { reference, ..own })),
            Construction::SphereB(own) => Some(Construction::SphereB(sphere_b::Construction { reference, ..own })),
            Construction::Rems(_) => None,
        }
    }

    pub fn name(&self) -> &'static str {
        match self {
            Construction::SphereA(_) => "sphere-a",
            Construction::SphereB(_) => "sphere-b",
            Construction::Rems(_) => "rems",
        }
    }

    /// Its elements, in the order of heater bits and codes.
    pub fn parts(&self) -> Vec<Part> {
        match self {
            Construction::SphereA(own) => sphere_a::parts(own),
            Construction::SphereB(own) => sphere_b::parts(own),
            Construction::Rems(_) => rems::parts(),
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
    pub(super) fn body(&self, gas: &Gas, support_k: f64) -> Result<Body, SensorError> {
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
        Construction::SphereB(sphere_b::Construction::default())
    }
}

impl Part {
    pub(super) fn inside(name: String) -> Part {
        Part { name, normal: None }
    }

    pub(super) fn facing(name: String, normal: [f64; 3]) -> Part {
        Part { name, normal: Some(normal) }
    }
}

/// Refuses a number of a construction that is not above zero, and an emissivity that is none.
pub(super) fn check(positive: &[(&str, f64)], emissivities: &[(&str, f64)]) -> Result<(), SensorError> {
    for &(name, value) in positive {
        if !(value.is_finite() && value > 0.0) {
            return Err(SensorError::out_of_range(name, value, "more than 0"));
        }
    }
    for &(name, value) in emissivities {
        if !(0.0..=1.0).contains(&value) {
            return Err(SensorError::out_of_range(name, value, "0 to 1"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sensor_has_the_name_that_it_is_asked_for_by() {
        for name in Construction::NAMES {
            let construction = Construction::named(name).unwrap();
            assert_eq!(construction.name(), name);
            let parts = construction.parts();
            for normal in parts.iter().filter_map(|part| part.normal) {
                assert!((normal.iter().map(|v| v * v).sum::<f64>() - 1.0).abs() < 1e-12);
            }
        }
        assert_eq!(Construction::named("sphere-c"), None);
        let count = |name| Construction::named(name).unwrap().parts().len();
        assert_eq!(["sphere-a", "sphere-b", "rems"].map(count), [4, 6, 13]);
        let beside = |name| {
            let parts = Construction::named(name).unwrap().with_reference()?.parts();
            Some((parts.len(), parts.last().unwrap().name.clone()))
        };
        let last = |count| Some((count, "reference".to_owned()));
        assert_eq!(["sphere-a", "sphere-b", "rems"].map(beside), [last(5), last(7), None]);
    }
}
