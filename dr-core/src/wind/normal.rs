//! Symmetric equations in three unknowns.

/// A symmetric matrix, all nine elements kept.
pub type Matrix = [[f32; 3]; 3];

/// a + weight · x xᵀ
pub fn plus_outer(a: &mut Matrix, weight: f32, x: [f32; 3]) {
    for i in 0..3 {
        for j in 0..3 {
            a[i][j] += weight * x[i] * x[j];
        }
    }
}

/// a + b
pub fn plus(a: &mut Matrix, b: &Matrix) {
    for (a, b) in a.as_flattened_mut().iter_mut().zip(b.as_flattened()) {
        *a += b;
    }
}

/// Takes unknown `k` out of a: nothing couples it to the others, and its diagonal element is
/// `diagonal`.
pub fn decouple(a: &mut Matrix, k: usize, diagonal: f32) {
    scale(a, k, 0.0);
    a[k][k] = diagonal;
}

/// Multiplies row and column `k` by a factor.
pub fn scale(a: &mut Matrix, k: usize, by: f32) {
    a[k] = a[k].map(|x| x * by);
    for row in a {
        row[k] *= by;
    }
}

/// Share of a diagonal element that must be left when the unknowns before it are eliminated: some
/// rounding errors of an f32.
const LEAST_PIVOT: f32 = 3e-6;

/// L and D of a = L D Lᵀ, or none if a is not positive definite to the precision of f32.
#[derive(Debug, Clone, Copy)]
pub struct Factors {
    l10: f32,
    l20: f32,
    l21: f32,
    d: [f32; 3],
}

impl Factors {
    pub fn of(a: &Matrix) -> Option<Self> {
        let good = |pivot: f32, whole: f32| pivot.is_finite() && pivot > LEAST_PIVOT * whole;
        let d0 = a[0][0];
        if !good(d0, 0.0) {
            return None;
        }
        let (l10, l20) = (a[1][0] / d0, a[2][0] / d0);
        let d1 = a[1][1] - l10 * a[1][0];
        if !good(d1, a[1][1]) {
            return None;
        }
        let l21 = (a[2][1] - l20 * a[1][0]) / d1;
        let d2 = a[2][2] - l20 * a[2][0] - l21 * l21 * d1;
        good(d2, a[2][2]).then_some(Self { l10, l20, l21, d: [d0, d1, d2] })
    }

    /// x of a x = b
    pub fn solve(&self, b: [f32; 3]) -> [f32; 3] {
        let y1 = b[1] - self.l10 * b[0];
        let y2 = b[2] - self.l20 * b[0] - self.l21 * y1;
        let x2 = y2 / self.d[2];
        let x1 = y1 / self.d[1] - self.l21 * x2;
        [b[0] / self.d[0] - self.l10 * x1 - self.l20 * x2, x1, x2]
    }

    /// a⁻¹
    pub fn inverse(&self) -> Matrix {
        let mut inverse = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|unit| self.solve(unit));
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            // The two differ by roundings.
            inverse[i][j] = inverse[j][i];
        }
        inverse
    }
}

/// x · a x
pub fn quadratic(a: &Matrix, x: [f32; 3]) -> f32 {
    crate::arithmetic::dot(x, a.map(|row| crate::arithmetic::dot(row, x)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_times_the_matrix_is_one() {
        let a = [[4.0, 1.0, -2.0], [1.0, 3.0, 0.5], [-2.0, 0.5, 5.0]];
        let inverse = Factors::of(&a).unwrap().inverse();
        for (i, j) in (0..9).map(|k| (k / 3, k % 3)) {
            let product: f32 = (0..3).map(|k| a[i][k] * inverse[k][j]).sum();
            assert!((product - if i == j { 1.0 } else { 0.0 }).abs() < 1e-6);
        }
    }

    #[test]
    fn a_matrix_without_full_rank_is_refused() {
        let mut a = [[0.0; 3]; 3];
        plus_outer(&mut a, 1.0, [1.0, 2.0, 3.0]);
        plus_outer(&mut a, 1.0, [0.3, -1.0, 0.7]);
        assert!(Factors::of(&a).is_none());
        assert!(Factors::of(&[[f32::NAN; 3]; 3]).is_none());
        assert!(Factors::of(&[[0.0; 3]; 3]).is_none());
    }
}
