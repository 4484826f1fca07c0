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

use nalgebra::DMatrix;

use super::space::WindSpace;
use crate::vector::angle_deg;

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
    /// How many there are.
    pub count: usize,
    /// The widest way from a direction to the nearest of them, °, and from which.
    pub widest: (f64, [f64; 3]),
}

impl KnownDirections {
    /// Of unit vectors.
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

    /// How many are needed.
    pub fn least(&self) -> usize {
        (DIRECTIONS_A_FUNCTION * self.space.count(1) as f64).ceil() as usize
    }

    /// Whether they can determine functions up to a degree.
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
    /// What is left of each wind where its direction is left out, by component.
    pub left: DMatrix<f64>,
}

impl DirectionFit {
    /// Of winds in these directions, by component of their shares; none where they do not
    /// determine the functions, or not without one direction.
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
