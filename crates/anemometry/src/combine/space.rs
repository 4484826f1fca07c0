//! Where winds come from, everywhere or in a plane, and functions of their direction.
//!
//! ```text
//! everywhere  real spherical harmonics:
//!             Y_l0 = p_l0,  Y_lm = √2 p_lm cos mφ,  Y_l−m = √2 p_lm sin mφ
//!             p_mm = p_m−1,m−1 sin θ √((2m+1)/2m)
//!             p_lm = √((4l²−1)/(l²−m²)) (cos θ p_l−1,m − √(((l−1)²−m²)/(4(l−1)²−1)) p_l−2,m)
//! in a plane  1,  √2 cos mφ,  √2 sin mφ
//! ```
//!
//! Both are orthonormal in the mean over all directions.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, SQRT_2};

use crate::vector::{across, cross, dot, unit};

/// Winds that leave a plane by less are in it: sine of 2°.
const FLAT: f64 = 0.035;

/// Directions of winds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WindSpace {
    /// All of them.
    Everywhere,
    /// Those across a normal, a unit vector.
    Across([f64; 3]),
}

impl WindSpace {
    /// That of unit vectors.
    pub fn of(towards: &[[f64; 3]]) -> Self {
        let moments: Matrix3<f64> = towards.iter().map(|of| Vector3::from(*of)).map(|of| of * of.transpose()).sum();
        let eigen = SymmetricEigen::new(moments);
        let normal = eigen.eigenvectors.column(eigen.eigenvalues.imin());
        // Of the two normals of a plane the one whose greatest component is positive.
        let normal: [f64; 3] = (normal * normal[normal.iamax()].signum()).into();
        match towards.iter().all(|of| dot(*of, normal).abs() < FLAT) {
            true => Self::Across(normal),
            false => Self::Everywhere,
        }
    }

    /// Components of a wind.
    pub const fn dimensions(self) -> usize {
        match self {
            Self::Everywhere => 3,
            Self::Across(_) => 2,
        }
    }

    /// Greatest degree that is of use.
    pub const fn most_degree(self) -> usize {
        match self {
            Self::Everywhere => 8,
            Self::Across(_) => 24,
        }
    }

    /// How many functions there are up to a degree.
    pub const fn count(self, degree: usize) -> usize {
        match self {
            Self::Everywhere => (degree + 1) * (degree + 1),
            Self::Across(_) => 2 * degree + 1,
        }
    }

    /// All functions up to a degree in a direction, a unit vector.
    pub fn functions(self, towards: [f64; 3], degree: usize) -> Vec<f64> {
        match self {
            Self::Everywhere => spherical(towards, degree),
            Self::Across(normal) => {
                let [x, y] = axes(normal).map(|axis| dot(towards, axis));
                let turns = (1..=degree).map(|m| (m as f64 * y.atan2(x)).sin_cos());
                std::iter::once(1.0).chain(turns.flat_map(|(sine, cosine)| [SQRT_2 * cosine, SQRT_2 * sine])).collect()
            }
        }
    }

    /// From one of so many even directions to the next, °.
    pub fn step_deg(self, count: usize) -> f64 {
        match self {
            Self::Everywhere => (4.0 * PI / count as f64).sqrt().to_degrees(),
            Self::Across(_) => 360.0 / count as f64,
        }
    }

    /// So many directions, evenly spread.
    pub fn even_directions(self, count: usize) -> Vec<[f64; 3]> {
        let direction = |n: usize| {
            let share = (n as f64 + 0.5) / count as f64;
            match self {
                Self::Everywhere => {
                    // Fibonacci's lattice.
                    let z = 1.0 - 2.0 * share;
                    let (sine, cosine) = (PI * (1.0 + 5_f64.sqrt()) * (n as f64 + 0.5)).sin_cos();
                    let across = (1.0 - z * z).sqrt();
                    [across * cosine, across * sine, z]
                }
                Self::Across(normal) => {
                    let ([a, b], (sine, cosine)) = (axes(normal), (2.0 * PI * share).sin_cos());
                    std::array::from_fn(|k| cosine * a[k] + sine * b[k])
                }
            }
        };
        (0..count).map(direction).collect()
    }

    /// The part of a vector that is in it.
    pub fn part(self, vector: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Everywhere => vector,
            Self::Across(normal) => across(vector, normal),
        }
    }
}

/// Two directions that span the plane across a normal.
fn axes(normal: [f64; 3]) -> [[f64; 3]; 2] {
    let least = (0..3).min_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs())).unwrap_or(0);
    let first = unit(across(std::array::from_fn(|k| f64::from(u8::from(k == least))), normal));
    [first, cross(normal, first)]
}

fn spherical([x, y, z]: [f64; 3], degree: usize) -> Vec<f64> {
    let mut values = vec![0.0; (degree + 1) * (degree + 1)];
    // (sin θ)^m (cos mφ, sin mφ) without its angle.
    let (mut cosine, mut sine) = (1.0, 0.0);
    let mut diagonal = 1.0;
    for m in 0..=degree {
        if m > 0 {
            (cosine, sine) = (x * cosine - y * sine, x * sine + y * cosine);
            let m = m as f64;
            diagonal *= ((2.0 * m + 1.0) / (2.0 * m)).sqrt();
        }
        let (mut before, mut here) = (0.0, diagonal);
        for l in m..=degree {
            if l > m {
                let (l, m) = (l as f64, m as f64);
                let scale = ((4.0 * l * l - 1.0) / (l * l - m * m)).sqrt();
                let back = (((l - 1.0).powi(2) - m * m) / (4.0 * (l - 1.0).powi(2) - 1.0)).max(0.0).sqrt();
                (before, here) = (here, scale * (z * here - back * before));
            }
            let middle = l * l + l;
            if m == 0 {
                values[middle] = here;
            } else {
                values[middle + m] = SQRT_2 * here * cosine;
                values[middle - m] = SQRT_2 * here * sine;
            }
        }
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_are_orthonormal_in_the_mean() {
        const DEGREE: usize = 6;
        for space in [WindSpace::Everywhere, WindSpace::Across(unit([0.3, -0.5, 0.8]))] {
            let directions = space.even_directions(20_000);
            let all: Vec<Vec<f64>> = directions.iter().map(|of| space.functions(*of, DEGREE)).collect();
            for i in 0..space.count(DEGREE) {
                for j in 0..=i {
                    let mean = all.iter().map(|of| of[i] * of[j]).sum::<f64>() / all.len() as f64;
                    assert!((mean - f64::from(u8::from(i == j))).abs() < 2e-3, "{space:?} {i} {j}: {mean}");
                }
            }
        }
    }

    #[test]
    fn harmonics_of_the_first_degree_are_the_direction() {
        let values = WindSpace::Everywhere.functions([0.48, 0.6, 0.64], 1);
        let [y, z, x] = [1, 2, 3].map(|n| values[n] / 3_f64.sqrt());
        assert!((x - 0.48).abs() < 1e-12 && (y - 0.6).abs() < 1e-12 && (z - 0.64).abs() < 1e-12);
    }

    #[test]
    fn winds_say_whether_they_are_in_a_plane() {
        let normal = unit([0.0, 0.5, 0.8]);
        let flat = WindSpace::Across(normal).even_directions(30);
        let WindSpace::Across(found) = WindSpace::of(&flat) else { panic!("they are flat") };
        assert!(dot(found, normal).abs() > 1.0 - 1e-9 && flat.iter().all(|of| dot(*of, normal).abs() < 1e-9));
        assert_eq!(WindSpace::of(&WindSpace::Everywhere.even_directions(30)), WindSpace::Everywhere);
    }
}
