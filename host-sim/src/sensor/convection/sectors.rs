//! Forced convection from the four sectors of a sphere, for any wind vector.
//!
//! ```text
//! G_i   = Nu_i k π d / 4                conductance of sector i to the gas, W/K
//! ```
//!
//! **Sector means.** With z = n·w (n the sector's axis, w the direction the wind comes *from*), the
//! addition theorem of the spherical harmonics gives the mean of P_n(cos θ) over a sector with
//! threefold symmetry as a short sum; the terms m = 1, 2, 4, 5 vanish:
//!
//! ```text
//! ⟨P_n⟩ = c_n P_n(z) + d_n P_n'''(z) (x³ − 3 x y²)        n ≤ 5
//! ```
//!
//! with x, y the components of w across the axis, x towards a corner of the sector. c_n P_n(z)
//! alone is the axisymmetric part that an inverse on a small processor may use; it misses up to 1 %
//! of a sector's Nu at Re 200, and the mean of the four sectors then varies with direction from
//! −1.1 to +0.6 %, which the full sum does not. Orders above 5 are left out: under 0.1 % of the
//! mean.
//!
//! Limits: those of the [`stream`](super::sphere_stream).

use std::f64::consts::PI;

use super::flow::dot;
use super::sphere_stream::{Coefficients, ORDERS, SphereStream, legendre};
use crate::sensor::error::SensorError;
use anemometry::gas::IdealGas;

/// Surfaces of the sphere.
pub const SECTORS: usize = 4;

/// Means of P_n over a tetrahedral sector about its own axis (c_n of the head of this file).
pub const SECTOR_MEAN: [f64; ORDERS] = [
    1.0,
    0.744_857_311_317_053,
    0.367_552_596_947_861_4,
    0.045_537_736_392_593_9,
    -0.108_904_473_169_736_9,
    -0.100_742_322_214_788_6,
];

/// Threefold parts of the sector means, d_n of the head of this file, for n = 3, 4, 5.
pub const SECTOR_THREEFOLD: [f64; 3] =
    [0.002_683_336_850_257_382, 0.001_283_451_524_664_488_5, 0.000_364_693_038_667_524];

/// Outward axes of the sectors, not normalised (each has length √3).
const AXES: [[f64; 3]; SECTORS] = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];

/// Orthonormal frame of a sector: its axis, the direction across it towards a corner, and the
/// third.
#[derive(Clone, Copy, Debug)]
struct SectorFrame {
    axis: [f64; 3],
    corner: [f64; 3],
    third: [f64; 3],
}

/// Convection of one sphere in one gas.
#[derive(Clone, Debug)]
pub struct Sectors {
    stream: SphereStream,
    conductance_per_nusselt_w_k: f64,
    frames: [SectorFrame; SECTORS],
}

impl Sectors {
    /// Refuses a gas so thin that it is no continuum around the sphere.
    pub fn new(gas: &IdealGas, diameter_m: f64) -> Result<Sectors, SensorError> {
        Ok(Sectors {
            stream: SphereStream::new(gas, diameter_m)?,
            conductance_per_nusselt_w_k: conductance_per_nusselt_w_k(gas, diameter_m),
            frames: std::array::from_fn(frame),
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

    /// Mean Nusselt number of every sector; the wind vector points where the air goes *to*.
    pub fn nusselt(&self, wind_m_s: [f64; 3]) -> [f64; SECTORS] {
        match self.stream.around(wind_m_s) {
            (a, Some(from)) => std::array::from_fn(|i| sector_mean(&a, &self.frames[i], from)),
            (a, None) => [a[0]; SECTORS],
        }
    }

    /// Conductance of every sector to the gas, W/K.
    pub fn conductance_w_k(&self, wind_m_s: [f64; 3]) -> [f64; SECTORS] {
        self.nusselt(wind_m_s).map(|nusselt| nusselt * self.conductance_per_nusselt_w_k)
    }
}

/// Outward unit axis of sector `i`.
pub fn sector_axis(i: usize) -> [f64; 3] {
    AXES[i].map(|v| v / 3.0_f64.sqrt())
}

fn frame(i: usize) -> SectorFrame {
    let axis = sector_axis(i);
    // A corner of a sector is opposite to the axis of another sector.
    let opposite = sector_axis((i + 1) % SECTORS).map(|v| -v);
    let along = dot(opposite, axis);
    let across: [f64; 3] = std::array::from_fn(|k| opposite[k] - along * axis[k]);
    let length = dot(across, across).sqrt();
    let corner = across.map(|v| v / length);
    let third = [
        axis[1] * corner[2] - axis[2] * corner[1],
        axis[2] * corner[0] - axis[0] * corner[2],
        axis[0] * corner[1] - axis[1] * corner[0],
    ];
    SectorFrame { axis, corner, third }
}

/// Mean of Σ a_n P_n(cos θ) over a sector; `from` is the unit vector towards the front stagnation
/// point.
fn sector_mean(a: &Coefficients, frame: &SectorFrame, from: [f64; 3]) -> f64 {
    let z = dot(from, frame.axis);
    let x = dot(from, frame.corner);
    let y = dot(from, frame.third);
    let legendre = legendre(z);
    let axisymmetric: f64 = (0..ORDERS).map(|n| a[n] * SECTOR_MEAN[n] * legendre[n]).sum();
    let third_derivative = [15.0, 105.0 * z, 472.5 * (z * z) - 52.5];
    let threefold: f64 = (0..3).map(|j| a[j + 3] * SECTOR_THREEFOLD[j] * third_derivative[j]).sum();
    axisymmetric + threefold * x * (x * x - 3.0 * y * y)
}

fn conductance_per_nusselt_w_k(gas: &IdealGas, diameter_m: f64) -> f64 {
    gas.conductivity_w_m_k * PI * diameter_m / SECTORS as f64
}

#[cfg(test)]
mod tests {
    use super::super::sphere_stream::tests::{directions, gas_of_table_prandtl, mars};
    use super::*;

    fn order(n: usize, z: f64) -> f64 {
        let (mut previous, mut current) = (1.0, z);
        if n == 0 {
            return 1.0;
        }
        for k in 1..n {
            (previous, current) = (current, ((2 * k + 1) as f64 * z * current - k as f64 * previous) / (k + 1) as f64);
        }
        current
    }

    #[test]
    fn a_ten_millimetre_sphere_on_mars_loses_what_the_literature_says() {
        let convection = Sectors::new(&mars(), 0.01).unwrap();
        // Speed, Re, Nu, G in mW/K, power at 30 K in mW. These rows come from the correlations, so
        // 2.5 % on Nu, G and power (and half a digit of the smallest printed value); Re to its
        // printed digits.
        for (speed, re, nu, g, power) in [
            (0.1, 1.5, 2.34, 0.80, 24.0),
            (1.0, 15.0, 3.76, 1.28, 38.0),
            (5.0, 76.0, 6.46, 2.20, 66.0),
            (10.0, 152.0, 8.44, 2.87, 86.0),
            (13.0, 198.0, 9.39, 3.20, 96.0),
        ] {
            let wind = [speed, 0.0, 0.0];
            let found_re = convection.stream.reynolds(wind);
            assert!((found_re - re).abs() < 0.5, "Re {found_re}");
            let found_nu = convection.stream.coefficients(found_re)[0];
            assert!((found_nu / nu - 1.0).abs() < 0.025, "Nu {found_nu} at {speed} m/s");
            let found_g: f64 = convection.conductance_w_k(wind).iter().sum::<f64>() * 1e3;
            assert!((found_g / g - 1.0).abs() < 0.025, "G {found_g} at {speed} m/s");
            assert!((found_g * 30.0 / power - 1.0).abs() < 0.03, "{} mW at {speed} m/s", found_g * 30.0);
        }
    }

    #[test]
    fn sector_means_agree_with_integration_over_the_sector() {
        // Half a million directions; a lattice resolves the sector's edge to about 1e-4.
        let axis = sector_axis(0);
        let (mut sums, mut count) = ([0.0; ORDERS], 0.0);
        for p in directions(500_000) {
            if (1..SECTORS).all(|i| dot(p, sector_axis(i)) < dot(p, axis)) {
                let z = dot(p, axis);
                (0..ORDERS).for_each(|n| sums[n] += order(n, z));
                count += 1.0;
            }
        }
        for n in 0..ORDERS {
            assert!((sums[n] / count - SECTOR_MEAN[n]).abs() < 2e-4, "c{n}: {}", sums[n] / count);
        }
        // The values quoted in the literature of the sensor.
        for (n, quoted) in [(1, 0.7449), (2, 0.3676), (3, 0.0455), (4, -0.1089)] {
            assert!((SECTOR_MEAN[n] - quoted).abs() < 0.5e-4);
        }
    }

    #[test]
    fn sector_nusselt_is_the_integral_of_the_local_one() {
        let convection = Sectors::new(&gas_of_table_prandtl(), 0.01).unwrap();
        let points: Vec<[f64; 3]> = directions(200_000).collect();
        for (speed, direction) in [(3.0, [0.36, -0.48, 0.8]), (13.1, [-0.6, 0.0, 0.8])] {
            let wind = direction.map(|v: f64| v * speed);
            let a = convection.stream.coefficients(convection.stream.reynolds(wind));
            let (mut sums, mut counts) = ([0.0; SECTORS], [0.0; SECTORS]);
            for &p in &points {
                let owner =
                    (0..SECTORS).max_by(|&i, &j| dot(p, sector_axis(i)).total_cmp(&dot(p, sector_axis(j)))).unwrap();
                let cos = -dot(p, direction);
                sums[owner] += (0..ORDERS).map(|n| a[n] * order(n, cos)).sum::<f64>();
                counts[owner] += 1.0;
            }
            let found = convection.nusselt(wind);
            for i in 0..SECTORS {
                // The lattice resolves the edges of the sectors to about 3e-4 of the mean.
                assert!((found[i] / (sums[i] / counts[i]) - 1.0).abs() < 1e-3, "sector {i}");
            }
        }
    }

    #[test]
    fn a_wind_turning_through_all_directions_keeps_the_mean() {
        let convection = Sectors::new(&gas_of_table_prandtl(), 0.01).unwrap();
        for speed in [0.01, 1.0, 6.0, 13.0, 40.0] {
            for direction in directions(500) {
                let wind = direction.map(|v| v * speed);
                let mean = convection.nusselt(wind).iter().sum::<f64>() / 4.0;
                let expected = convection.stream.coefficients(convection.stream.reynolds(wind))[0];
                // Rounding of the constants of the sector means, of which P_n''' makes up to 400
                // times as much.
                assert!((mean / expected - 1.0).abs() < 1e-13, "{mean} {expected}");
            }
        }
    }

    #[test]
    fn a_linear_inverse_errs_by_the_published_angle() {
        // Σ Nu_i n_i points against the wind within 0.5° at Re 50, 1.8° at Re 100, 6.6° at Re 200.
        let convection = Sectors::new(&gas_of_table_prandtl(), 0.01).unwrap();
        for (re, degrees) in [(50.0, 0.5), (100.0, 1.8), (200.0, 6.6)] {
            let speed = re / convection.stream.reynolds([1.0, 0.0, 0.0]);
            let worst = directions(4000)
                .map(|direction| {
                    let nusselt = convection.nusselt(direction.map(|v| v * speed));
                    let sum: [f64; 3] = std::array::from_fn(|k| (0..4).map(|i| nusselt[i] * sector_axis(i)[k]).sum());
                    (-dot(sum, direction) / dot(sum, sum).sqrt()).min(1.0).acos().to_degrees()
                })
                .fold(0.0, f64::max);
            assert!((worst - degrees).abs() < 0.06, "Re {re}: {worst}°");
        }
    }

    #[test]
    fn the_wind_cools_the_sector_that_faces_it_most() {
        let convection = Sectors::new(&mars(), 0.01).unwrap();
        for i in 0..SECTORS {
            let nusselt = convection.nusselt(sector_axis(i).map(|v| -5.0 * v));
            assert!((0..SECTORS).all(|j| j == i || nusselt[j] < 0.8 * nusselt[i]), "{nusselt:?}");
        }
    }

    #[test]
    fn still_gas_conducts_with_nusselt_two() {
        let convection = Sectors::new(&mars(), 0.01).unwrap();
        assert_eq!(convection.nusselt([0.0; 3]), [2.0; 4]);
    }
}
