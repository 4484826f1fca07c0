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
//!
//! Least squares by functions of the direction, and what they leave of directions that were left
//! out.
//!
//! A tunnel turns to a few directions and holds several speeds in each. A wind that is left out
//! alone would be found by its neighbours of the same direction, whatever the functions do between
//! directions; so winds of one direction are left out together:
//!
//! ```text
//! e_G = (1 − H_GG)⁻¹ r_G        H = A (AᵀA)⁻¹ Aᵀ,  r what the fit of all leaves
//! ```

use std::f64::consts::{PI, SQRT_2};

use nalgebra::{DMatrix, Matrix3, SymmetricEigen, Vector3};
use serde::{Deserialize, Serialize};

use crate::vector::{across, angle_deg, cross, dot, unit};

/// Winds that leave a plane by less are in it: sine of 2°.
const FLAT: f64 = 0.035;

/// Directions of winds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WindSpace {
    /// All of them.
    Everywhere,
    /// Winds across a normal, a unit vector.
    Across([f64; 3]),
}

impl WindSpace {
    /// That of unit vectors.
    pub fn of(towards: &[[f64; 3]]) -> Self {
        let moments: Matrix3<f64> = towards.iter().map(|of| Vector3::from(*of)).map(|of| of * of.transpose()).sum();
        let eigen = SymmetricEigen::new(moments);
        let normal = eigen.eigenvectors.column(eigen.eigenvalues.imin());
        // The normal of a plane whose greatest component is positive is taken.
        let normal: [f64; 3] = (normal * normal[normal.iamax()].signum()).into();
        if towards.iter().all(|of| dot(*of, normal).abs() < FLAT) { Self::Across(normal) } else { Self::Everywhere }
    }

    /// Components of a wind.
    pub const fn dimensions(self) -> usize {
        if matches!(self, Self::Everywhere) { 3 } else { 2 }
    }

    /// Greatest degree that is of use.
    pub const fn most_degree(self) -> usize {
        if matches!(self, Self::Everywhere) { 8 } else { 24 }
    }

    /// Number of functions up to a degree.
    pub const fn count(self, degree: usize) -> usize {
        if matches!(self, Self::Everywhere) { (degree + 1) * (degree + 1) } else { 2 * degree + 1 }
    }

    /// All functions up to a degree in a direction, a unit vector.
    pub fn functions(self, towards: [f64; 3], degree: usize) -> Vec<f64> {
        match self {
            Self::Everywhere => spherical(towards, degree),
            Self::Across(normal) => {
                let [x, y] = axes(normal).map(|axis| dot(towards, axis));
                let turns = (1..=degree).map(|m| libm::sincos(m as f64 * libm::atan2(y, x)));
                std::iter::once(1.0).chain(turns.flat_map(|(sine, cosine)| [SQRT_2 * cosine, SQRT_2 * sine])).collect()
            }
        }
    }

    /// From one of so many even directions to the next, °.
    pub fn step_deg(self, count: usize) -> f64 {
        if self == Self::Everywhere { (4.0 * PI / count as f64).sqrt().to_degrees() } else { 360.0 / count as f64 }
    }

    /// So many directions, evenly spread.
    pub fn even_directions(self, count: usize) -> Vec<[f64; 3]> {
        let direction = |n: usize| {
            let share = (n as f64 + 0.5) / count as f64;
            match self {
                Self::Everywhere => {
                    // Fibonacci's lattice.
                    let z = 1.0 - 2.0 * share;
                    let (sine, cosine) = libm::sincos(PI * (1.0 + 5_f64.sqrt()) * (n as f64 + 0.5));
                    let across = (1.0 - z * z).sqrt();
                    [across * cosine, across * sine, z]
                }
                Self::Across(normal) => {
                    let ([a, b], (sine, cosine)) = (axes(normal), libm::sincos(2.0 * PI * share));
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

/// Winds that are so near to each other are of one direction, °.
const SAME_DEG: f64 = 2.0;
/// Directions a function, at least.
const DIRECTIONS_A_FUNCTION: f64 = 1.5;
/// Most of the degree times the widest way to a known wind, °: a gap is twice that way, and five
/// sixths of a period at most.
const DEGREE_BY_WAY_DEG: f64 = 150.0;
/// Directions among which a gap between the known winds is sought.
const SOUGHT: usize = 200;

/// Directions of known winds.
pub struct KnownDirections {
    /// Unit vectors.
    pub towards: Vec<[f64; 3]>,
    /// Where they are.
    pub space: WindSpace,
    /// By wind: which of the directions.
    pub groups: Vec<usize>,
    /// Number of them.
    pub count: usize,
    /// The widest way from a direction to the nearest of them, °, and from which.
    pub widest: (f64, [f64; 3]),
}

impl KnownDirections {
    /// Shares of unit vectors.
    pub fn new(towards: Vec<[f64; 3]>) -> Self {
        let space = WindSpace::of(&towards);
        let mut firsts: Vec<[f64; 3]> = Vec::new();
        let mut groups = Vec::new();
        for of in &towards {
            let group = firsts.iter().position(|first| angle_deg(*first, *of) < SAME_DEG).unwrap_or(firsts.len());
            if group == firsts.len() {
                firsts.push(*of);
            }
            groups.push(group);
        }
        let nearest_deg = |of: [f64; 3]| firsts.iter().map(|known| angle_deg(*known, of)).fold(180.0, f64::min);
        let all = space.even_directions(SOUGHT).into_iter().map(|of| (nearest_deg(of), of));
        let widest = all.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default();
        Self { towards, space, groups, count: firsts.len(), widest }
    }

    /// Least number.
    pub fn least(&self) -> usize {
        (DIRECTIONS_A_FUNCTION * self.space.count(1) as f64).ceil() as usize
    }

    /// Tells whether they can determine functions up to a degree.
    pub fn are_enough(&self, degree: usize) -> bool {
        DIRECTIONS_A_FUNCTION * self.space.count(degree) as f64 <= self.count as f64
            && (degree == 1 || degree as f64 * self.widest.0 <= DEGREE_BY_WAY_DEG)
    }
}

/// Least squares by functions of one degree.
pub struct DirectionFit {
    /// The degree.
    pub degree: usize,
    /// Function by component.
    pub coefficients: DMatrix<f64>,
    /// Residual of each wind where its direction is left out, by component.
    pub left: DMatrix<f64>,
}

impl DirectionFit {
    /// Covariance of winds in these directions, by component of their shares; none where they do
    /// not determine the functions, or not without one direction.
    pub fn of(directions: &KnownDirections, shares: &DMatrix<f64>, degree: usize) -> Option<Self> {
        let KnownDirections { towards, space, groups, .. } = directions;
        let rows: Vec<Vec<f64>> = towards.iter().map(|of| space.functions(*of, degree)).collect();
        let design = DMatrix::from_fn(rows.len(), space.count(degree), |row, k| rows[row][k]);
        let inverse = (design.transpose() * &design).cholesky()?.inverse();
        let coefficients = &inverse * design.transpose() * shares;
        let mut left = shares - &design * &coefficients;
        for group in 0..directions.count {
            let own: Vec<usize> = (0..groups.len()).filter(|row| groups[*row] == group).collect();
            let part = design.select_rows(&own);
            let own_share = DMatrix::identity(own.len(), own.len()) - &part * &inverse * part.transpose();
            let alone = own_share.cholesky()?.solve(&left.select_rows(&own));
            own.iter().zip(alone.row_iter()).for_each(|(row, alone)| left.set_row(*row, &alone));
        }
        Some(Self { degree, coefficients, left })
    }
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
