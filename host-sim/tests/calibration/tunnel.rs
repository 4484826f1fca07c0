//! A wind tunnel whose head is known: the simulated convection, gains, a crooked mounting, noise.

use diffusive::random::StandardNormal;
use dr_core::wind::HeadForm;
use dr_core::wind::sphere::{hemispheres, tetrahedral_sectors};
use nalgebra::{Rotation3, Unit, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::Distribution as _;

use anemometry::calibrate::{DrawnSurface, DrawnSurfaces, LossLaw, SoughtConvection, SteadyWind, SurfaceReading};
use anemometry::gas::{IdealGas, Species};
use anemometry::vector::unit;
use host_sim::sensor::convection::sphere_surfaces::SphereSurfaces;

pub const DIAMETER_M: f64 = 0.01;
const SURFACE_K: f64 = 250.0;
const PRESSURE_PA: f64 = 1000.0;

#[derive(Clone)]
pub struct Tunnel {
    pub sectors: bool,
    pub gas_k: f64,
    /// Conductance of the identification in quiescent gas.
    pub reference_k: f64,
    pub gains: Vec<f64>,
    /// From the tunnel's frame into the head's.
    pub rotation: Rotation3<f64>,
}

impl Tunnel {
    pub fn sectors() -> Self {
        let axis = Unit::new_normalize(Vector3::new(0.5, -0.3, 0.8));
        Self {
            sectors: true,
            gas_k: 220.0,
            reference_k: 217.0,
            gains: vec![1.02, 0.985, 0.98, 1.015],
            rotation: Rotation3::from_axis_angle(&axis, 7.0_f64.to_radians()),
        }
    }

    pub fn hemispheres() -> Self {
        // Across the head's axis, about which nothing can be known.
        let axis = Unit::new_normalize(Vector3::new(0.0, -0.6, 0.8));
        let rotation = Rotation3::from_axis_angle(&axis, 7.0_f64.to_radians());
        Self { sectors: false, gains: vec![1.02, 0.98], rotation, ..Self::sectors() }
    }

    pub fn head(&self) -> DrawnSurfaces {
        let named = |prefix: &str, configs: &[dr_core::wind::SurfaceConfig]| {
            let surface =
                |(i, config): (usize, &_)| DrawnSurface { name: format!("{prefix}{}", i + 1), config: *config };
            configs.iter().enumerate().map(surface).collect()
        };
        let d = DIAMETER_M as f32;
        let surfaces = match self.sectors {
            true => named("sector", &tetrahedral_sectors(d)),
            false => named("hemisphere", &hemispheres(d)),
        };
        DrawnSurfaces {
            form: HeadForm::Sphere,
            law: LossLaw::Spline,
            diameter_m: DIAMETER_M,
            surfaces,
            convection: SoughtConvection::default(),
        }
    }

    fn conductance_w_k(&self, gas_k: f64, wind_m_s: Vector3<f64>) -> Vec<f64> {
        let gas = IdealGas::new(Species::CarbonDioxide, PRESSURE_PA, gas_k).unwrap();
        let axes: &[[f64; 3]] = match self.sectors {
            true => &[[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]],
            false => &[[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]],
        };
        let axes: Vec<[f64; 3]> = axes.iter().map(|&axis| unit(axis)).collect();
        let convection = SphereSurfaces::new(&gas, DIAMETER_M, &axes).unwrap();
        let mut conductances = vec![0.0; self.gains.len()];
        convection.conductance_w_k((self.rotation * wind_m_s).into(), &mut conductances);
        conductances
    }

    /// G0 as the identification in quiescent gas would find it: gas of the reference at rest.
    pub fn quiescent_w_k(&self) -> Vec<f64> {
        self.conductance_w_k(self.reference_k, Vector3::zeros())
    }

    pub fn reading(&self, label: String, wind_m_s: [f64; 3], noise: f64, random: &mut ChaCha8Rng) -> SteadyWind {
        let gas = IdealGas::new(Species::CarbonDioxide, PRESSURE_PA, self.gas_k).unwrap();
        let (overheat_k, above_reference_k) = (SURFACE_K - self.gas_k, SURFACE_K - self.reference_k);
        let surfaces = self.conductance_w_k(self.gas_k, wind_m_s.into()).into_iter().zip(self.quiescent_w_k());
        let surfaces = surfaces.zip(&self.gains).map(|((conductance, still), gain)| {
            let power = conductance * overheat_k / gain;
            let error: f64 = StandardNormal.sample(random);
            SurfaceReading {
                power_w: power - still * above_reference_k + noise * power * error,
                overheat_k,
                above_reference_k,
                variance_w2: (noise * power).powi(2),
            }
        });
        SteadyWind { label, wind_m_s, gas, surfaces: surfaces.collect() }
    }

    /// Every speed from each of so many directions, and one reading of quiescent gas. `noise` is
    /// relative to the convective power.
    pub fn readings(&self, speeds_m_s: &[f64], count: usize, noise: f64, seed: u64) -> Vec<SteadyWind> {
        let directions: Vec<[f64; 3]> = directions(count).collect();
        self.in_winds(speeds_m_s, &directions, noise, seed)
    }

    pub fn in_winds(&self, speeds_m_s: &[f64], directions: &[[f64; 3]], noise: f64, seed: u64) -> Vec<SteadyWind> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut readings = vec![self.reading("still".into(), [0.0; 3], noise, &mut random)];
        for speed in speeds_m_s {
            for (j, direction) in directions.iter().enumerate() {
                let size = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
                let wind = direction.map(|x| x / size * speed);
                readings.push(self.reading(format!("{speed:.2} m/s, {j}"), wind, noise, &mut random));
            }
        }
        readings
    }
}

/// In geometric progression.
pub fn speeds(least: f64, most: f64, count: usize) -> Vec<f64> {
    (0..count).map(|j| least * libm::pow(most / least, j as f64 / (count - 1) as f64)).collect()
}

/// Spread evenly over the sphere (Fibonacci lattice).
pub fn directions(count: usize) -> impl Iterator<Item = [f64; 3]> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    (0..count).map(move |k| {
        let z = 1.0 - (2.0 * k as f64 + 1.0) / count as f64;
        let r = (1.0 - z * z).sqrt();
        [r * libm::cos(golden * k as f64), r * libm::sin(golden * k as f64), z]
    })
}
