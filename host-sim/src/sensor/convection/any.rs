//! The convection of one body, whichever it is.

use anemometry::gas::IdealGas;

use super::boom::Boom;
use super::film::Film;
use super::sphere_surfaces::SphereSurfaces;

/// Convection of one body in one gas.
#[derive(Clone, Debug)]
pub enum BodyConvection {
    /// A sphere of sectors or hemispheres.
    Sphere(SphereSurfaces),
    /// Dice on cards around a boom.
    Boom(Boom),
    /// A body with a film beside it, whose surface is the last.
    Beside(Box<BodyConvection>, Film),
}

impl BodyConvection {
    /// Conductance of every surface to the gas, W/K, in the order of the body's surfaces.
    pub fn conductance_w_k(&self, wind_m_s: [f64; 3], conductance_w_k: &mut [f64]) {
        match self {
            BodyConvection::Sphere(surfaces) => surfaces.conductance_w_k(wind_m_s, conductance_w_k),
            BodyConvection::Boom(boom) => boom.conductance_w_k(wind_m_s, conductance_w_k),
            BodyConvection::Beside(body, film) => {
                if let Some((last, others)) = conductance_w_k.split_last_mut() {
                    body.conductance_w_k(wind_m_s, others);
                    *last = film.conductance_w_k(wind_m_s);
                }
            }
        }
    }

    /// From now on in this gas.
    pub fn follow(&mut self, gas: &IdealGas) {
        match self {
            BodyConvection::Sphere(surfaces) => surfaces.follow(gas),
            BodyConvection::Boom(boom) => boom.follow(gas),
            BodyConvection::Beside(body, film) => {
                body.follow(gas);
                film.follow(gas);
            }
        }
    }

    /// Whether this wind lies beyond what is computed or known.
    pub fn extrapolated(&self, wind_m_s: [f64; 3]) -> bool {
        match self {
            BodyConvection::Sphere(surfaces) => surfaces.stream().extrapolated(wind_m_s),
            BodyConvection::Boom(boom) => boom.extrapolated(wind_m_s),
            BodyConvection::Beside(body, _) => body.extrapolated(wind_m_s),
        }
    }
}
