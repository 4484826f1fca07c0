//! The truth of the tests, in f64: a sphere of 10 mm in a stream, by its published table.
//!
//! Table: `data/sphere_nusselt_legendre_pr0772.json` of the simulated sensors (axisymmetric
//! Navier–Stokes and energy equations, Pr 0.772, Re 1 … 200), six digits. Between its rows natural
//! cubic splines in ln Re; below Re 1 linear to conduction; above Re 200 everything as Re^0.42,
//! which is another law than the core's.

extern crate std;

use crate::wind::nusselt::{NusseltConfig, ORDERS, POINTS};
use crate::wind::{GasState, SurfaceConfig};
use std::vec::Vec;

#[rustfmt::skip]
const TABLE: [(f64, [f64; ORDERS]); 19] = [
    (1.0, [2.26651, 0.23535, -0.00301084, -7.427e-05, -0.000413668, -5.300e-05]),
    (2.0, [2.45754, 0.41748, -0.00729001, -0.000400391, -0.000398608, -9.670e-05]),
    (5.0, [2.88227, 0.836525, -0.0183188, -0.00356475, 0.000298017, -0.000291435]),
    (10.0, [3.3896, 1.35508, -0.0275415, -0.0151704, 0.00398707, -0.00124115]),
    (15.0, [3.785, 1.77239, -0.0292558, -0.0325469, 0.0104736, -0.00322121]),
    (20.0, [4.11883, 2.13395, -0.0265022, -0.054061, 0.0192749, -0.0062363]),
    (30.0, [4.67626, 2.75679, -0.0127598, -0.106041, 0.0426018, -0.0151606]),
    (40.0, [5.14183, 3.29494, 0.00866345, -0.167209, 0.0725224, -0.027742]),
    (50.0, [5.54805, 3.77664, 0.0366932, -0.236363, 0.10865, -0.0440227]),
    (60.0, [5.91215, 4.21612, 0.071733, -0.313601, 0.151252, -0.0643185]),
    (75.0, [6.4016, 4.81234, 0.140288, -0.446767, 0.228979, -0.103432]),
    (90.0, [6.8426, 5.34401, 0.233717, -0.605318, 0.326407, -0.15453]),
    (100.0, [7.11723, 5.66558, 0.313109, -0.727657, 0.403654, -0.195498]),
    (115.0, [7.50786, 6.10154, 0.46089, -0.937638, 0.537524, -0.265365]),
    (130.0, [7.87893, 6.48628, 0.642508, -1.17667, 0.688364, -0.339915]),
    (150.0, [8.34988, 6.93141, 0.928482, -1.52794, 0.901529, -0.433428]),
    (165.0, [8.68772, 7.22406, 1.16665, -1.80476, 1.0597, -0.490946]),
    (180.0, [9.01352, 7.48898, 1.41774, -2.08502, 1.20974, -0.533756]),
    (200.0, [9.43034, 7.80844, 1.76398, -2.45577, 1.39174, -0.566877]),
];

pub const DIAMETER_M: f64 = 0.01;

/// CO2 at 220 K: viscosity and conductivity of the table in the physics of the simulated sensors;
/// ideal gas.
pub const VISCOSITY_PA_S: f64 = 11.05e-6;
pub const CONDUCTIVITY_W_M_K: f64 = 10.84e-3;

pub fn density_kg_m3(pressure_pa: f64) -> f64 {
    pressure_pa * 0.044_009_8 / (8.314_462_6 * 220.0)
}

pub fn carbon_dioxide(pressure_pa: f64) -> GasState {
    GasState::new(density_kg_m3(pressure_pa) as f32, VISCOSITY_PA_S as f32, CONDUCTIVITY_W_M_K as f32).unwrap()
}

pub fn reynolds_per_speed(pressure_pa: f64) -> f64 {
    density_kg_m3(pressure_pa) * DIAMETER_M / VISCOSITY_PA_S
}

/// The table as a calibration would give it.
pub fn published() -> NusseltConfig {
    sampled(1.0, 200.0)
}

pub fn sampled(least: f64, most: f64) -> NusseltConfig {
    let step = libm::log(most / least) / (POINTS - 1) as f64;
    NusseltConfig {
        least_reynolds: least as f32,
        most_reynolds: most as f32,
        amplitudes: core::array::from_fn(|j| {
            amplitudes((least * libm::exp(step * j as f64)).min(most)).map(|a| a as f32)
        }),
    }
}

/// a_0 … a_5
pub fn amplitudes(reynolds: f64) -> [f64; ORDERS] {
    let (first, last) = (TABLE[0], TABLE[TABLE.len() - 1]);
    if reynolds < first.0 {
        let mut a = first.1.map(|a| a * reynolds);
        a[0] = 2.0 + (first.1[0] - 2.0) * reynolds;
        return a;
    }
    if reynolds > last.0 {
        return last.1.map(|a| a * libm::pow(reynolds / last.0, 0.42));
    }
    let x: Vec<f64> = TABLE.iter().map(|row| libm::log(row.0)).collect();
    let at = libm::log(reynolds);
    let i = x.partition_point(|&x| x <= at).clamp(1, x.len() - 1) - 1;
    let h = x[i + 1] - x[i];
    let (a, b) = ((x[i + 1] - at) / h, (at - x[i]) / h);
    core::array::from_fn(|n| {
        let y: Vec<f64> = TABLE.iter().map(|row| row.1[n]).collect();
        let c = curvature(&x, &y);
        a * y[i] + b * y[i + 1] + ((a * a * a - a) * c[i] + (b * b * b - b) * c[i + 1]) * h * h / 6.0
    })
}

/// Second derivatives of the natural cubic spline, by the tridiagonal algorithm.
fn curvature(x: &[f64], y: &[f64]) -> Vec<f64> {
    let n = x.len();
    let (mut upper, mut c) = (std::vec![0.0; n], std::vec![0.0; n]);
    for i in 1..n - 1 {
        let (left, right) = (x[i] - x[i - 1], x[i + 1] - x[i]);
        let pivot = 2.0 * (left + right) - left * upper[i - 1];
        let bend = 6.0 * ((y[i + 1] - y[i]) / right - (y[i] - y[i - 1]) / left);
        upper[i] = right / pivot;
        c[i] = (bend - left * c[i - 1]) / pivot;
    }
    for i in (1..n - 1).rev() {
        c[i] -= upper[i] * c[i + 1];
    }
    c
}

/// P_0 … P_5 by their recursion.
pub fn legendre(z: f64) -> [f64; ORDERS] {
    let mut p = [1.0, z, 0.0, 0.0, 0.0, 0.0];
    for n in 1..ORDERS - 1 {
        p[n + 1] = ((2 * n + 1) as f64 * z * p[n] - n as f64 * p[n - 1]) / (n + 1) as f64;
    }
    p
}

pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

pub fn unit(a: [f64; 3]) -> [f64; 3] {
    a.map(|x| x / dot(a, a).sqrt())
}

pub fn wide(a: [f32; 3]) -> [f64; 3] {
    a.map(f64::from)
}

pub fn narrow(a: [f64; 3]) -> [f32; 3] {
    a.map(|x| x as f32)
}

/// Mean Nusselt numbers of surfaces in a wind with this Reynolds vector.
pub fn nusselt<const N: usize>(surfaces: &[SurfaceConfig; N], reynolds_vector: [f64; 3]) -> [f64; N] {
    let reynolds = dot(reynolds_vector, reynolds_vector).sqrt();
    let a = amplitudes(reynolds);
    if reynolds == 0.0 {
        return [a[0]; N];
    }
    let from = reynolds_vector.map(|r| -r / reynolds);
    core::array::from_fn(|i| {
        let axis = unit(wide(surfaces[i].axis));
        let z = dot(from, axis);
        let corner = wide(surfaces[i].corner);
        let along = dot(corner, axis);
        let corner = unit(core::array::from_fn(|k| corner[k] - along * axis[k]));
        let x = dot(from, corner);
        let y2 = (1.0 - z * z - x * x).max(0.0);
        let p = legendre(z);
        let means = surfaces[i].means.map(f64::from);
        let third = [15.0, 105.0 * z, 472.5 * z * z - 52.5];
        let threefold: f64 = (0..3).map(|j| a[j + 3] * f64::from(surfaces[i].threefold[j]) * third[j]).sum();
        a[0] + (1..ORDERS).map(|n| a[n] * means[n - 1] * p[n]).sum::<f64>() + threefold * (x * x - 3.0 * y2) * x
    })
}

/// Conductances in W/K in a wind in m/s.
pub fn conductances<const N: usize>(surfaces: &[SurfaceConfig; N], pressure_pa: f64, wind: [f64; 3]) -> [f64; N] {
    let nusselt = nusselt(surfaces, wind.map(|v| v * reynolds_per_speed(pressure_pa)));
    core::array::from_fn(|i| nusselt[i] * CONDUCTIVITY_W_M_K * f64::from(surfaces[i].area_m2) / DIAMETER_M)
}

/// Evenly and normally distributed numbers, the same in every run.
pub struct TestRandom(u64);

impl TestRandom {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Within 0 … 1 (SplitMix64).
    pub fn even(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Standard normal (Box and Muller).
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * libm::log(1.0 - self.even())).sqrt();
        radius * libm::cos(core::f64::consts::TAU * self.even())
    }

    /// A direction outside a cone of 20° about the stem, which points to −z.
    pub fn direction(&mut self) -> [f64; 3] {
        loop {
            let v = unit([self.normal(), self.normal(), self.normal()]);
            if v[2].abs() < libm::cos(20.0_f64.to_radians()) {
                return v;
            }
        }
    }
}
