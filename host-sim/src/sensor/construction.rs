//! What a simulated sensor is made of: the body of a head file, its own or that of one of the
//! project's heads.

use std::path::PathBuf;
use std::sync::Arc;

use super::assembly::assemble;
use super::body::ThermalBody;
use super::convection::validity;
use super::error::{SensorError, require};
use super::specimen;
use anemometry::gas::{IdealGas, ZERO_CELSIUS_K};
use anemometry::head::Head;
use anemometry::head::body::{Body, BodyElement};
use recording::REFERENCE;
use recording::toml_file::TomlSource;

/// The project's heads that a `sensor` may name.
const SPHERE_A: &str = include_str!("../../../heads/sphere-a.toml");
const SPHERE_B: &str = include_str!("../../../heads/sphere-b.toml");
const REMS: &str = include_str!("../../../heads/rems.toml");
/// A film in the stream beside a sphere.
const BESIDE: &str = include_str!("../../data/reference.toml");

/// A body with all of its numbers. [`Construction::named`] gives the sensors of the project.
#[derive(Clone, Debug, PartialEq)]
pub struct Construction {
    name: String,
    elements: Vec<BodyElement>,
    /// The body, and what is beside it.
    bodies: Arc<Vec<Body>>,
}

impl Construction {
    /// What a head file may call its `sensor`.
    pub const NAMES: [&str; 3] = ["sphere-a", "sphere-b", "rems"];

    /// A sensor of the project.
    pub fn named(name: &str) -> Option<Construction> {
        let texts = Self::NAMES.into_iter().zip([SPHERE_A, SPHERE_B, REMS]);
        let (_, text) = texts.into_iter().find(|(known, _)| *known == name)?;
        let mut construction = Self::of(&built_in(name, text))?;
        construction.name = name.to_owned();
        Some(construction)
    }

    /// The body of a head that has its own.
    pub fn of(head: &Head) -> Option<Construction> {
        let body = head.body.clone()?;
        let elements = head.elements.iter().map(|of| BodyElement { name: of.name.clone(), normal: of.normal });
        Some(Construction { name: head.name.clone(), elements: elements.collect(), bodies: Arc::new(vec![body]) })
    }

    /// The same with a reference beside it, where the project knows one.
    pub fn with_reference(&self) -> Option<Construction> {
        if !self.name.starts_with("sphere-") {
            return None;
        }
        let mut with = self.clone();
        Arc::make_mut(&mut with.bodies).extend(built_in(REFERENCE, BESIDE).body);
        with.elements.push(BodyElement { name: REFERENCE.to_owned(), normal: None });
        Some(with)
    }

    /// Its name in head files.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its elements, in the order of heater bits and codes.
    pub fn elements(&self) -> &[BodyElement] {
        &self.elements
    }

    /// What it is made of.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// Where its convection ends, as in "the wind was beyond …".
    pub fn validity(&self) -> &'static str {
        let first = self.bodies.iter().flat_map(|body| &body.convection).next();
        first.map_or("what is known of convection", |group| validity(&group.correlation))
    }

    /// The body in equilibrium with the gas, its rods between gas and support; the seed draws a
    /// specimen where there are tolerances.
    ///
    /// # Errors
    /// If the support has no temperature, or the gas is too thin.
    pub(super) fn body(&self, gas: &IdealGas, support_k: f64, seed: u64) -> Result<ThermalBody, SensorError> {
        possible(support_k)?;
        match specimen::drawn(&self.bodies, seed) {
            Some(drawn) => assemble(&drawn, gas, support_k),
            None => assemble(&self.bodies, gas, support_k),
        }
    }

    /// The same with the numbers of the file, whatever its tolerances.
    ///
    /// # Errors
    /// As [`body`](Self::body).
    pub(super) fn nominal_body(&self, gas: &IdealGas, support_k: f64) -> Result<ThermalBody, SensorError> {
        possible(support_k)?;
        assemble(&self.bodies, gas, support_k)
    }
}

fn possible(support_k: f64) -> Result<(), SensorError> {
    let is_possible = support_k.is_finite() && support_k > 0.0;
    require(is_possible, "support.temperature_c", support_k - ZERO_CELSIUS_K, "above -273.15")
}

/// A head file of the project; all of them are read by its tests.
fn built_in(name: &str, text: &str) -> Head {
    let path = PathBuf::from(format!("{name}.toml"));
    let head = Head::from_source(TomlSource { path, text: text.to_owned() });
    head.unwrap_or_else(|error| unreachable!("a head of the project: {error}"))
}

impl Default for Construction {
    fn default() -> Construction {
        Self::of(&built_in("sphere-b", SPHERE_B)).unwrap_or_else(|| unreachable!("sphere B has a body"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sensor_has_the_name_that_it_is_requested_by() {
        for name in Construction::NAMES {
            let construction = Construction::named(name).unwrap();
            assert_eq!(construction.name(), name);
            for normal in construction.elements().iter().filter_map(|part| part.normal) {
                assert!((normal.iter().map(|v| v * v).sum::<f64>() - 1.0).abs() < 1e-12);
            }
        }
        assert_eq!(Construction::named("sphere-c"), None);
        let count = |name| Construction::named(name).unwrap().elements().len();
        assert_eq!(["sphere-a", "sphere-b", "rems"].map(count), [4, 6, 13]);
        let beside = |name| {
            let with = Construction::named(name).unwrap().with_reference()?;
            Some((with.elements().len(), with.elements().last().unwrap().name.clone()))
        };
        let last = |count| Some((count, "reference".to_owned()));
        assert_eq!(["sphere-a", "sphere-b", "rems"].map(beside), [last(5), last(7), None]);
    }
}
