//! Convection from a cylinder in crossflow: as a whole, or from sectors around its axis.
//!
//! ```text
//! Nu     = churchill_bernstein(Re)                          mean, Re = U d / ν
//! Nu(φ)  = N (1 − (φ/90°)³)           φ ≤ 80° from the front stagnation line
//!        = (Nu − s N) / (1 − 80/180)  behind it, so that the mean is Nu
//! N      = 1.14 Pr^0.4 √Re            s = mean of the front's law over all angles, 0.3664
//! U²     = U_across² + k² U_along²    k is `yaw_factor`
//! ```
//!
//! A sector is the part of the surface that is nearer to its normal than to any other's; its mean
//! is taken from the Fourier series of Nu(φ), exactly but for what `HARMONICS` leave out (under
//! 0.3 % of Nu for a sector of 60° or more). What the wind along the axis adds has no front.
//!
//! *Sources.* Mean: Churchill and Bernstein 1977, Re·Pr > 0.2, within some 20 %. Front: the laminar
//! stagnation line and its fall to the separation at 80° (Kreith, Principles of Heat Transfer, for
//! air at Re 100 … 10⁵). Rear: uniform, from the mean; measured rears vary by a factor of two about
//! it and rise above Re 10⁴. Below Re 5, where no layer is thin, what differs around the cylinder
//! goes as Re from what it is there. Free convection: a horizontal cylinder by Churchill and Chu
//! 1975.
//!
//! *Limits.* Above Re 10⁵ the layer becomes turbulent: `extrapolated`. No ends, no blockage;
//! properties at the gas temperature; a continuum around the diameter.

use std::f64::consts::{PI, TAU};

use super::flow::{
    continuum, cylinder_factor, cylinder_nusselt, effective_speed_m_s, free_cylinder_nusselt, joined, rayleigh,
};
use crate::sensor::error::SensorError;
use anemometry::gas::IdealGas;
use anemometry::head::body::CylinderShape;
use anemometry::vector::{across, cross, dot, length, unit};

/// Cosines of the local Nusselt number.
const HARMONICS: usize = 24;
/// Where the law of the front begins.
const LEAST_REYNOLDS: f64 = 5.0;
/// End of the laminar layer.
const HIGHEST_REYNOLDS: f64 = 1e5;
/// Where it leaves the front, rad.
const SEPARATION_RAD: f64 = 80.0 / 180.0 * PI;

/// Convection of one cylinder in one gas.
#[derive(Clone, Debug)]
pub struct Cylinder {
    shape: CylinderShape,
    gas: IdealGas,
    /// Ends of every sector as angles around the axis, rad; none of a cylinder as a whole.
    sectors: Vec<[f64; 2]>,
    /// Two directions across the axis; angles count from the first.
    frame: [[f64; 3]; 2],
    /// Cosine coefficients of the front's law and of 1 behind it.
    front: [f64; HARMONICS],
    rear: [f64; HARMONICS],
    factor: f64,
    reynolds_per_speed: f64,
    stagnation: f64,
}

impl Cylinder {
    /// With one sector a normal; refuses a gas so thin that it is no continuum around the cylinder.
    pub fn new(gas: &IdealGas, shape: &CylinderShape, normals: &[[f64; 3]]) -> Result<Self, SensorError> {
        continuum(gas, shape.diameter_m)?;
        let axis = unit(shape.axis);
        let seed = if axis[0].abs() < 0.9 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        let first = unit(across(seed, axis));
        let frame = [first, cross(axis, first)];
        let angles: Vec<f64> = normals.iter().map(|&normal| angle(frame, normal)).collect();
        let [front, rear] = coefficients();
        let mut cylinder = Cylinder {
            shape: *shape,
            gas: *gas,
            sectors: sectors(&angles),
            frame,
            front,
            rear,
            factor: 0.0,
            reynolds_per_speed: 0.0,
            stagnation: 0.0,
        };
        cylinder.follow(gas);
        Ok(cylinder)
    }

    /// The same in another gas.
    pub fn follow(&mut self, gas: &IdealGas) {
        self.gas = *gas;
        self.factor = cylinder_factor(gas.prandtl());
        self.reynolds_per_speed = gas.reynolds(1.0, self.shape.diameter_m);
        self.stagnation = 1.14 * libm::pow(gas.prandtl(), 0.4);
    }

    /// Surface of a sector, or of all, m².
    pub fn area_m2(&self, sector: usize) -> f64 {
        let angle_rad = self.sectors.get(sector).map_or(TAU, |[start, end]| end - start);
        0.5 * self.shape.diameter_m * angle_rad * self.shape.length_m
    }

    /// Tells whether free convection joins in.
    pub fn is_free(&self) -> bool {
        self.shape.gravity_m_s2.is_some()
    }

    /// Tells whether the layer would no longer be laminar.
    pub fn extrapolated(&self, wind_m_s: [f64; 3]) -> bool {
        self.reynolds(wind_m_s) > HIGHEST_REYNOLDS
    }

    fn reynolds(&self, wind_m_s: [f64; 3]) -> f64 {
        self.reynolds_per_speed * effective_speed_m_s(wind_m_s, self.shape.axis, self.shape.yaw_factor)
    }

    /// Conductance of every sector to the gas, W/K.
    pub fn conductance_w_k(&self, wind_m_s: [f64; 3], surface_k: &[f64], conductance_w_k: &mut [f64]) {
        let reynolds = self.reynolds(wind_m_s);
        let mean = cylinder_nusselt(reynolds, self.factor);
        let known = reynolds.max(LEAST_REYNOLDS);
        let front = self.stagnation * known.sqrt();
        let behind = (cylinder_nusselt(known, self.factor) - front * self.front[0]) / self.rear[0];
        let across_m_s = across(wind_m_s, self.shape.axis);
        let seen_m_s = reynolds / self.reynolds_per_speed;
        // Share of the wind that has a front, and of the law of the front where it is slow.
        let share = if seen_m_s > 0.0 { reynolds / known * length(across_m_s) / seen_m_s } else { 0.0 };
        let from = angle(self.frame, across_m_s.map(|v| -v));
        for (i, (conductance, surface_k)) in conductance_w_k.iter_mut().zip(surface_k).enumerate() {
            let mut nusselt = mean;
            if let Some(sector) = self.sectors.get(i).filter(|_| share > 0.0) {
                nusselt += share * self.around(*sector, from, [front, behind]);
            }
            if let Some(gravity_m_s2) = self.shape.gravity_m_s2 {
                let overheat_k = (surface_k - self.gas.temperature_k).abs();
                let rayleigh = rayleigh(&self.gas, self.shape.diameter_m, overheat_k, gravity_m_s2);
                nusselt = joined(free_cylinder_nusselt(rayleigh, self.gas.prandtl()), nusselt);
            }
            *conductance = nusselt * self.gas.conductivity_w_m_k / self.shape.diameter_m * self.area_m2(i);
        }
    }

    /// Amount by which a sector has more than the mean.
    fn around(&self, [start, end]: [f64; 2], from: f64, [front, behind]: [f64; 2]) -> f64 {
        (1..HARMONICS)
            .map(|m| {
                let order = m as f64;
                let mean =
                    (libm::sin(order * (end - from)) - libm::sin(order * (start - from))) / (order * (end - start));
                (front * self.front[m] + behind * self.rear[m]) * mean
            })
            .sum()
    }
}

/// Angle of a direction around the axis, rad.
fn angle([first, second]: [[f64; 3]; 2], direction: [f64; 3]) -> f64 {
    libm::atan2(dot(direction, second), dot(direction, first))
}

/// Ends of the sector around every angle: halfway to its neighbours.
fn sectors(angles: &[f64]) -> Vec<[f64; 2]> {
    if angles.len() < 2 {
        return Vec::new();
    }
    let gap = |from: f64, to: f64| match (to - from).rem_euclid(TAU) {
        0.0 => TAU,
        gap => gap,
    };
    let nearest = |own: usize, gap_to: &dyn Fn(f64) -> f64| {
        let others = angles.iter().enumerate().filter(|(i, _)| *i != own);
        others.map(|(_, &angle)| gap_to(angle)).fold(TAU, f64::min)
    };
    let sector = |(i, &angle): (usize, &f64)| {
        let after = nearest(i, &|other| gap(angle, other));
        let before = nearest(i, &|other| gap(other, angle));
        [angle - 0.5 * before, angle + 0.5 * after]
    };
    angles.iter().enumerate().map(sector).collect()
}

/// Cosine coefficients of the law of the front, and of 1 behind it, by Simpson's rule.
fn coefficients() -> [[f64; HARMONICS]; 2] {
    const STEPS: usize = 2000;
    let integral = |from: f64, to: f64, of: &dyn Fn(f64) -> f64| -> f64 {
        let step = (to - from) / STEPS as f64;
        let weight = |j: usize| if j == 0 || j == STEPS { 1.0 } else { 2.0 + 2.0 * (j % 2) as f64 };
        (0..=STEPS).map(|j| weight(j) * of(from + step * j as f64)).sum::<f64>() * step / 3.0
    };
    let front = |angle: f64| 1.0 - (angle / (0.5 * PI)).powi(3);
    let share = |m: usize| if m == 0 { 1.0 / PI } else { 2.0 / PI };
    [
        std::array::from_fn(|m| {
            share(m) * integral(0.0, SEPARATION_RAD, &|angle| front(angle) * libm::cos(m as f64 * angle))
        }),
        std::array::from_fn(|m| share(m) * integral(SEPARATION_RAD, PI, &|angle| libm::cos(m as f64 * angle))),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use anemometry::gas::Species;

    const SHAPE: CylinderShape =
        CylinderShape { diameter_m: 6e-3, length_m: 0.03, axis: [0.0, 0.0, 2.0], yaw_factor: 0.0, gravity_m_s2: None };

    fn air() -> IdealGas {
        IdealGas::new(Species::Air, 101_325.0, 293.15).unwrap()
    }

    fn normals(count: usize) -> Vec<[f64; 3]> {
        let angle = |i: usize| TAU * i as f64 / count as f64;
        (0..count).map(|i| [libm::cos(angle(i)), libm::sin(angle(i)), 0.0]).collect()
    }

    fn conductances(shape: &CylinderShape, count: usize, wind: [f64; 3]) -> Vec<f64> {
        let cylinder = Cylinder::new(&air(), shape, &normals(count)).unwrap();
        let mut all = vec![0.0; count.max(1)];
        cylinder.conductance_w_k(wind, &vec![323.15; all.len()], &mut all);
        all
    }

    #[test]
    fn sectors_together_lose_what_the_whole_loses() {
        let whole = conductances(&SHAPE, 0, [-3.0, 1.0, 0.5])[0];
        // Re of 3.16 m/s 1251, Pr 0.71: 0.3 + 0.62 · 35.4 · 0.892 / 1.139 · 1.027 = 17.9 by hand.
        let nusselt = whole / (air().conductivity_w_m_k * PI * 0.03);
        assert!((nusselt / 17.95 - 1.0).abs() < 0.01, "{nusselt}");
        for count in [2, 3, 6, 8] {
            let sum: f64 = conductances(&SHAPE, count, [-3.0, 1.0, 0.5]).iter().sum();
            assert!((sum / whole - 1.0).abs() < 1e-9, "{count} sectors: {sum} of {whole}");
        }
    }

    #[test]
    fn a_sector_has_the_mean_of_the_law_over_itself() {
        // Six sectors; the first faces the wind: φ from −30° to 30°, where the law has the mean
        // 1 − (30/90)³/4. The one behind is all rear.
        let all = conductances(&SHAPE, 6, [-3.0, 0.0, 0.0]);
        let gas = air();
        let reynolds = gas.reynolds(3.0, 6e-3);
        let area = PI * 6e-3 * 0.03 / 6.0;
        let nusselt = |g: f64| g / (gas.conductivity_w_m_k / 6e-3 * area);
        let stagnation = 1.14 * libm::pow(gas.prandtl(), 0.4) * reynolds.sqrt();
        let mean = cylinder_nusselt(reynolds, cylinder_factor(gas.prandtl()));
        let front = stagnation * (1.0 - (1.0_f64 / 3.0).powi(3) / 4.0);
        assert!((nusselt(all[0]) / front - 1.0).abs() < 3e-3, "{} for {front}", nusselt(all[0]));
        let share = (80.0 - 80.0_f64.powi(4) / (4.0 * 90.0_f64.powi(3))) / 180.0;
        let rear = (mean - share * stagnation) / (100.0 / 180.0);
        assert!((nusselt(all[3]) / rear - 1.0).abs() < 6e-3, "{} for {rear}", nusselt(all[3]));
        assert!((all[1] / all[5] - 1.0).abs() < 1e-9 && (all[2] / all[4] - 1.0).abs() < 1e-9, "{all:?}");
    }

    #[test]
    fn a_turn_by_a_sector_changes_nothing_but_the_numbers() {
        let wind = |degrees: f64| [4.0 * libm::cos(degrees.to_radians()), 4.0 * libm::sin(degrees.to_radians()), 1.0];
        let (one, turned) = (conductances(&SHAPE, 3, wind(17.0)), conductances(&SHAPE, 3, wind(137.0)));
        for i in 0..3 {
            assert!((one[i] / turned[(i + 1) % 3] - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn along_the_axis_only_the_yaw_factor_counts_and_no_side_is_the_front() {
        let axial = conductances(&CylinderShape { yaw_factor: 0.2, ..SHAPE }, 3, [0.0, 0.0, 5.0]);
        let across = conductances(&SHAPE, 0, [1.0, 0.0, 0.0])[0];
        assert!((axial.iter().sum::<f64>() / across - 1.0).abs() < 1e-9);
        assert!((axial[0] / axial[1] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_front_loses_most_however_slow_the_wind() {
        let per_speed = air().reynolds(1.0, 6e-3);
        for reynolds in [0.01, 0.5, 4.9, 5.1, 20.0, 1e3, 9e4] {
            let all = conductances(&SHAPE, 3, [-reynolds / per_speed, 0.0, 0.0]);
            assert!(all[0] > all[1] && (all[1] / all[2] - 1.0).abs() < 1e-9, "Re {reynolds}: {all:?}");
        }
        let front = |reynolds: f64| conductances(&SHAPE, 3, [-reynolds / per_speed, 0.0, 0.0])[0];
        assert!((front(5.0 - 1e-6) / front(5.0 + 1e-6) - 1.0).abs() < 1e-5);
    }

    #[test]
    fn in_quiescent_air_it_loses_what_free_convection_takes() {
        // Ra of 6 mm at 30 K: 9.81/293.15 · 30 · 2.16e-7 · 0.71 / (1.516e-5)² = 670; Nu 0.36 +
        // 0.518 · 5.088 / 1.327 = 2.35.
        let warm = conductances(&CylinderShape { gravity_m_s2: Some(9.81), ..SHAPE }, 0, [0.0; 3])[0];
        let nusselt = warm / (air().conductivity_w_m_k * PI * 0.03);
        assert!((nusselt / 2.35 - 1.0).abs() < 0.02, "{nusselt}");
    }
}
