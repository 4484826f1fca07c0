//! The convection of the surfaces of one shape, whichever it is.

use anemometry::gas::IdealGas;
use anemometry::head::body::{Convection, Correlation, KingLaw};

use super::boom::Boom;
use super::cylinder::Cylinder;
use super::king;
use super::nusselt_table::TableConvection;
use super::plate::Plate;
use super::sphere_surfaces::SphereSurfaces;
use super::wire::Wire;
use crate::sensor::error::SensorError;

/// Convection of one shape in one gas.
#[derive(Clone, Debug)]
pub enum BodyConvection {
    /// A sphere.
    Sphere(SphereSurfaces),
    /// Dice on cards around a boom.
    Boom(Boom),
    /// A plate on its own.
    Plate(Plate),
    /// A cylinder, whole or in sectors.
    Cylinder(Box<Cylinder>),
    /// A fine wire.
    Wire(Wire),
    /// King's law.
    King(KingLaw),
    /// By a table.
    Table(TableConvection),
}

impl BodyConvection {
    /// The law of a head file.
    ///
    /// # Errors
    /// If the gas is too thin for it.
    pub fn new(of: &Convection, gas: &IdealGas) -> Result<Self, SensorError> {
        let normals: Vec<[f64; 3]> = of.surfaces.iter().filter_map(|surface| surface.normal).collect();
        Ok(match &of.correlation {
            Correlation::Sphere { diameter_m } => Self::Sphere(SphereSurfaces::new(gas, *diameter_m, &normals)?),
            Correlation::Cylinder(shape) => Self::Cylinder(Box::new(Cylinder::new(gas, shape, &normals)?)),
            Correlation::Plate(shape) => Self::Plate(Plate::new(gas, shape)?),
            Correlation::Wire(shape) => Self::Wire(Wire::new(gas, shape)?),
            Correlation::King(law) => Self::King(*law),
            Correlation::Table(grid) => {
                let normals = of.surfaces.iter().map(|surface| surface.normal).collect();
                Self::Table(TableConvection::new(gas, grid.clone(), normals)?)
            }
            Correlation::Boom(shape) => Self::Boom(Boom::new(gas, shape)?),
        })
    }

    /// Conductance of every surface to the gas, W/K, in the order of the shape's surfaces, at their
    /// temperatures.
    pub fn conductance_w_k(&self, wind_m_s: [f64; 3], surface_k: &[f64], conductance_w_k: &mut [f64]) {
        let surfaces = conductance_w_k.iter_mut().zip(surface_k);
        match self {
            Self::Sphere(sphere) if sphere.takes_film() => {
                sphere.film_conductance_w_k(wind_m_s, surface_k, conductance_w_k);
            }
            Self::Sphere(sphere) => sphere.conductance_w_k(wind_m_s, conductance_w_k),
            Self::Boom(boom) => boom.conductance_w_k(wind_m_s, conductance_w_k),
            Self::Cylinder(cylinder) => cylinder.conductance_w_k(wind_m_s, surface_k, conductance_w_k),
            Self::Plate(plate) => surfaces.for_each(|(g, &surface_k)| *g = plate.conductance_w_k(wind_m_s, surface_k)),
            Self::Wire(wire) => surfaces.for_each(|(g, &surface_k)| *g = wire.conductance_w_k(wind_m_s, surface_k)),
            Self::King(law) => conductance_w_k.fill(king::conductance_w_k(law, wind_m_s)),
            Self::Table(table) => table.conductance_w_k(wind_m_s, conductance_w_k),
        }
    }

    /// The sphere, if it is one.
    pub fn sphere(&self) -> Option<&SphereSurfaces> {
        if let Self::Sphere(sphere) = self { Some(sphere) } else { None }
    }

    /// The same, to be changed.
    pub fn sphere_mut(&mut self) -> Option<&mut SphereSurfaces> {
        if let Self::Sphere(sphere) = self { Some(sphere) } else { None }
    }

    /// From now on in this gas.
    pub fn follow(&mut self, gas: &IdealGas) {
        match self {
            Self::Sphere(sphere) => sphere.follow(gas),
            Self::Boom(boom) => boom.follow(gas),
            Self::Plate(plate) => plate.follow(gas),
            Self::Cylinder(cylinder) => cylinder.follow(gas),
            Self::Wire(wire) => wire.follow(gas),
            Self::King(_) => {}
            Self::Table(table) => table.follow(gas),
        }
    }

    /// Tells whether the temperature of a surface counts, beside the gas and the wind.
    pub fn follows_surface(&self) -> bool {
        match self {
            Self::Sphere(sphere) => sphere.takes_film(),
            Self::Boom(_) | Self::King(_) | Self::Table(_) => false,
            Self::Wire(_) => true,
            Self::Plate(plate) => plate.is_free(),
            Self::Cylinder(cylinder) => cylinder.is_free(),
        }
    }

    /// Area of a surface, m²: what its emissivity counts for.
    pub fn area_m2(&self, surface: usize) -> f64 {
        match self {
            Self::Sphere(sphere) => sphere.area_m2(surface),
            Self::Boom(boom) => boom.area_m2(surface),
            Self::Plate(plate) => plate.area_m2(),
            Self::Cylinder(cylinder) => cylinder.area_m2(surface),
            Self::Wire(wire) => wire.area_m2(),
            Self::King(_) => 0.0,
            Self::Table(table) => table.area_m2(),
        }
    }

    /// Tells whether this wind lies beyond what is computed or known.
    pub fn extrapolated(&self, wind_m_s: [f64; 3], surface_k: &[f64]) -> bool {
        match self {
            Self::Sphere(sphere) => sphere.extrapolated(wind_m_s, surface_k),
            Self::Boom(boom) => boom.extrapolated(wind_m_s),
            Self::Plate(plate) => plate.extrapolated(wind_m_s),
            Self::Cylinder(cylinder) => cylinder.extrapolated(wind_m_s),
            Self::Wire(wire) => surface_k.iter().any(|&surface_k| wire.extrapolated(wind_m_s, surface_k)),
            Self::King(_) => false,
            Self::Table(table) => table.extrapolated(wind_m_s),
        }
    }
}

/// Where a law ends, as in "the wind was beyond …".
pub fn validity(correlation: &Correlation) -> &'static str {
    match correlation {
        Correlation::Sphere { .. } => "the computed Nusselt numbers (Re 200)",
        Correlation::Boom(_) => "the laminar boundary layer (Re 5e5 on a card)",
        Correlation::Plate(_) => "the laminar boundary layer (Re 5e5)",
        Correlation::Cylinder(_) => "the laminar boundary layer of a cylinder (Re 1e5)",
        Correlation::Wire(_) => "the measurements behind the law of the wire",
        Correlation::King(_) => "King's law",
        Correlation::Table(_) => "the last Reynolds number of the table",
    }
}
