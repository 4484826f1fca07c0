//! Forced convection: from the wind vector to the conductance of every surface of a body.
//!
//! | file | what |
//! |---|---|
//! | [`sphere`] | local Nusselt number of a sphere in a stream, as Legendre coefficients |
//! | [`sectors`] | its means over the four sectors of a tetrahedral sphere |
//! | [`hemispheres`] | its means over two hemispheres |
//! | [`boom`] | small dice on cards around a cylindrical boom, by correlations |
//! | [`film`] | a small film on its own, by a correlation |
//!
//! A wind vector says where the air goes *to*. All of them know forced convection only, in a continuum. Each is made in one gas, and can
//! [follow](Convection::follow) that gas to another temperature without being made anew.

pub mod boom;
pub mod film;
pub mod hemispheres;
pub mod sectors;
pub mod sphere;

use boom::Boom;
use film::Film;
use hemispheres::Hemispheres;
use sectors::Sectors;

use super::SensorError;
use super::gas::Gas;

/// Convection of one body in one gas.
#[derive(Clone, Debug)]
pub enum Convection {
    Sectors(Box<Sectors>),
    Hemispheres(Hemispheres),
    Boom(Boom),
    /// A body with a film beside it, whose surface is the last.
    Beside(Box<Convection>, Film),
}

impl Convection {
    /// Conductance of every surface to the gas, W/K, in the order of the body's surfaces.
    pub fn conductance_w_k(&self, wind_m_s: [f64; 3], conductance_w_k: &mut [f64]) {
        match self {
            Convection::Sectors(sectors) => conductance_w_k.copy_from_slice(&sectors.conductance_w_k(wind_m_s)),
            Convection::Hemispheres(both) => conductance_w_k.copy_from_slice(&both.conductance_w_k(wind_m_s)),
            Convection::Boom(boom) => boom.conductance_w_k(wind_m_s, conductance_w_k),
            Convection::Beside(body, film) => {
                if let Some((last, others)) = conductance_w_k.split_last_mut() {
                    body.conductance_w_k(wind_m_s, others);
                    *last = film.conductance_w_k(wind_m_s);
                }
            }
        }
    }

    /// From now on in this gas.
    pub fn follow(&mut self, gas: &Gas) {
        match self {
            Convection::Sectors(sectors) => sectors.follow(gas),
            Convection::Hemispheres(both) => both.follow(gas),
            Convection::Boom(boom) => boom.follow(gas),
            Convection::Beside(body, film) => {
                body.follow(gas);
                film.follow(gas);
            }
        }
    }

    /// Refuses a gas that it could not follow to: one so thin that it is no continuum.
    pub fn check(&self, gas: &Gas) -> Result<(), SensorError> {
        match self {
            Convection::Sectors(sectors) => continuum(gas, sectors.stream().diameter_m()),
            Convection::Hemispheres(both) => continuum(gas, both.stream().diameter_m()),
            Convection::Boom(boom) => continuum(gas, boom.die_side_m()),
            Convection::Beside(body, film) => body.check(gas).and_then(|()| continuum(gas, film.width_m())),
        }
    }

    /// Whether this wind lies beyond what is computed or known.
    pub fn extrapolated(&self, wind_m_s: [f64; 3]) -> bool {
        match self {
            Convection::Sectors(sectors) => sectors.stream().extrapolated(wind_m_s),
            Convection::Hemispheres(both) => both.stream().extrapolated(wind_m_s),
            Convection::Boom(boom) => boom.extrapolated(wind_m_s),
            Convection::Beside(body, _) => body.extrapolated(wind_m_s),
        }
    }
}

const HIGHEST_KNUDSEN: f64 = 0.01;

/// Refuses a gas so thin that it is no continuum around a body of `length_m`.
fn continuum(gas: &Gas, length_m: f64) -> Result<(), SensorError> {
    let knudsen = gas.knudsen(length_m);
    if knudsen > HIGHEST_KNUDSEN {
        return Err(SensorError::NotAContinuum {
            knudsen,
            pressure_pa: gas.pressure_pa,
            lowest_pressure_pa: gas.pressure_pa * knudsen / HIGHEST_KNUDSEN,
        });
    }
    Ok(())
}

/// Mean Nusselt number of a plate in a laminar layer (Pohlhausen): 0.664 Re^½ Pr^⅓.
fn plate_nusselt(reynolds: f64, prandtl_third: f64) -> f64 {
    0.664 * reynolds.sqrt() * prandtl_third
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
