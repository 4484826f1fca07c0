//! Forced convection from the two hemispheres of a sphere, for any wind vector.
//!
//! ```text
//! ⟨P_n⟩ = h_n P_n(z)          h_n = ∫₀¹ P_n(x) dx:  1, ½, 0, −⅛, 0, 1/16
//! G_i   = Nu_i k π d / 2      conductance of hemisphere i to the gas, W/K
//! ```
//!
//! with z = n·w, n the axis of the hemisphere and w the direction that the wind comes *from*. A
//! hemisphere is symmetric about its axis, so the addition theorem leaves nothing but this.
//!
//! Limits: those of the [`stream`](super::sphere_stream).

use std::f64::consts::PI;

use super::flow::dot;
use super::sphere_stream::{ORDERS, SphereStream, legendre};
use crate::sensor::error::SensorError;
use anemometry::gas::IdealGas;

/// Surfaces of the sphere.
pub const HEMISPHERES: usize = 2;

/// Outward unit axes.
pub const AXES: [[f64; 3]; HEMISPHERES] = [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]];

/// Means of P_n over a hemisphere about its own axis, h_n of the head of this file.
pub const HEMISPHERE_MEAN: [f64; ORDERS] = [1.0, 0.5, 0.0, -0.125, 0.0, 0.0625];

/// Convection of one sphere in one gas.
#[derive(Clone, Debug)]
pub struct Hemispheres {
    stream: SphereStream,
    conductance_per_nusselt_w_k: f64,
}

impl Hemispheres {
    /// Refuses a gas so thin that it is no continuum around the sphere.
    pub fn new(gas: &IdealGas, diameter_m: f64) -> Result<Hemispheres, SensorError> {
        Ok(Hemispheres {
            stream: SphereStream::new(gas, diameter_m)?,
            conductance_per_nusselt_w_k: conductance_per_nusselt_w_k(gas, diameter_m),
        })
    }

    /// The same in another gas.
    pub fn follow(&mut self, gas: &IdealGas) {
        self.stream.follow(gas);
        self.conductance_per_nusselt_w_k = conductance_per_nusselt_w_k(gas, self.stream.diameter_m());
    }

    /// The stream around the sphere.
    pub fn stream(&self) -> &SphereStream {
        &self.stream
    }

    /// Mean Nusselt number of either hemisphere.
    pub fn nusselt(&self, wind_m_s: [f64; 3]) -> [f64; HEMISPHERES] {
        let (a, from) = self.stream.around(wind_m_s);
        let Some(from) = from else { return [a[0]; HEMISPHERES] };
        AXES.map(|axis| {
            let p = legendre(dot(from, axis));
            (0..ORDERS).map(|n| a[n] * HEMISPHERE_MEAN[n] * p[n]).sum()
        })
    }

    /// Conductance of either hemisphere to the gas, W/K.
    pub fn conductance_w_k(&self, wind_m_s: [f64; 3]) -> [f64; HEMISPHERES] {
        self.nusselt(wind_m_s).map(|nusselt| nusselt * self.conductance_per_nusselt_w_k)
    }
}

fn conductance_per_nusselt_w_k(gas: &IdealGas, diameter_m: f64) -> f64 {
    gas.conductivity_w_m_k * PI * diameter_m / HEMISPHERES as f64
}

#[cfg(test)]
mod tests {
    use super::super::sphere_stream::tests::{directions, mars};
    use super::*;

    fn hemispheres() -> Hemispheres {
        Hemispheres::new(&mars(), 0.01).unwrap()
    }

    #[test]
    fn nusselt_of_a_hemisphere_is_the_integral_of_the_local_one() {
        let convection = hemispheres();
        let points: Vec<[f64; 3]> = directions(200_000).collect();
        for (speed, direction) in [(3.0, [0.36, -0.48, 0.8]), (12.0, [-0.6, 0.0, 0.8]), (9.0, [-1.0, 0.0, 0.0])] {
            let wind = direction.map(|v: f64| v * speed);
            let a = convection.stream.coefficients(convection.stream.reynolds(wind));
            let (mut sums, mut counts) = ([0.0; HEMISPHERES], [0.0; HEMISPHERES]);
            for &p in &points {
                let owner = usize::from(p[0] < 0.0);
                let local = legendre(-dot(p, direction));
                sums[owner] += (0..ORDERS).map(|n| a[n] * local[n]).sum::<f64>();
                counts[owner] += 1.0;
            }
            let found = convection.nusselt(wind);
            for i in 0..HEMISPHERES {
                // The lattice resolves the edge between the two to about 3e-4 of the mean.
                assert!((found[i] / (sums[i] / counts[i]) - 1.0).abs() < 1e-3, "hemisphere {i} at {speed} m/s");
            }
        }
    }

    #[test]
    fn the_two_add_up_to_the_sphere_whatever_the_direction() {
        let convection = hemispheres();
        for direction in directions(200) {
            let wind = direction.map(|v| 7.0 * v);
            let sphere = convection.stream.coefficients(convection.stream.reynolds(wind))[0];
            let mean = 0.5 * convection.nusselt(wind).iter().sum::<f64>();
            assert!((mean / sphere - 1.0).abs() < 1e-13, "{mean} {sphere}");
        }
    }

    #[test]
    fn the_front_is_cooled_more_than_the_back_and_a_wind_from_the_side_cools_both_alike() {
        let convection = hemispheres();
        let [front, back] = convection.nusselt([-5.0, 0.0, 0.0]);
        // Re 76, between the printed rows of 50 and 100: a_1 4.87 and a_3 −0.47 make ½ · 4.87 + ⅛ ·
        // 0.47 = 2.49 either way.
        assert!((front - back - 4.98).abs() < 0.05, "{front} {back}");
        let [one, other] = convection.nusselt([0.0, 3.0, -4.0]);
        assert!((one / other - 1.0).abs() < 1e-12);
    }
}
