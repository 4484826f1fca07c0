//! The triangular factor R of a tall matrix A, AᵀA = RᵀR, taken block by block in constant memory.
//!
//! Squares of the columns would lose half of their digits, and with them the evidence of small
//! noise. Each block is reflected into R by Householder's method (G. H. Golub and C. F. Van Loan,
//! *Matrix Computations*, 5.2).

use nalgebra::DMatrix;
use pulp::{Simd, WithSimd};

/// Sums that run side by side, in a fixed order on every machine.
const ABREAST: usize = 16;

/// Sums of squares below which a column has decayed: its reflection would overflow.
const NOTHING: f64 = 1e-280;

/// Rows of a block.
pub const BLOCK: usize = 256;

/// R, row by row.
#[derive(Debug, Clone)]
pub struct TriangularFactor {
    width: usize,
    r: Vec<f64>,
}

impl TriangularFactor {
    /// The factor of no rows yet.
    pub fn new(width: usize) -> Self {
        Self { width, r: vec![0.0; width * width] }
    }

    /// The factor of a small matrix, which stands in memory.
    pub fn of(matrix: &DMatrix<f64>) -> Self {
        let mut factor = Self::new(matrix.ncols());
        factor.take(&mut matrix.as_slice().to_vec(), matrix.nrows(), matrix.nrows());
        factor
    }

    /// Number of columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// An element of R; 0 below the diagonal.
    pub fn at(&self, row: usize, column: usize) -> f64 {
        self.r[row * self.width + column]
    }

    /// Takes `rows` more rows. `block` holds the columns one after the other, each of `stride`
    /// values; it is overwritten.
    pub fn take(&mut self, block: &mut [f64], stride: usize, rows: usize) {
        pulp::Arch::new().dispatch(Reflections { r: &mut self.r, width: self.width, block, stride, rows });
    }
}

struct Reflections<'a> {
    r: &'a mut [f64],
    width: usize,
    block: &'a mut [f64],
    stride: usize,
    rows: usize,
}

impl WithSimd for Reflections<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { r, width, block, stride, rows } = self;
        for k in 0..width {
            let (head, others) = block.split_at_mut((k + 1) * stride);
            let own = &head[k * stride..k * stride + rows];
            let squares = dot(own, own);
            if squares < NOTHING {
                continue;
            }
            let before = r[k * width + k];
            let after = -(before * before + squares).sqrt().copysign(before);
            let first = before - after;
            let factor = 2.0 / (first * first + squares);
            r[k * width + k] = after;
            for (other, column) in others.chunks_mut(stride).zip(k + 1..width) {
                let other = &mut other[..rows];
                let weight = factor * (first * r[k * width + column] + dot(own, other));
                r[k * width + column] -= weight * first;
                other.iter_mut().zip(own).for_each(|(value, own)| *value -= weight * own);
            }
        }
    }
}

#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a_groups, a_rest) = a.as_chunks::<ABREAST>();
    let (b_groups, b_rest) = b.as_chunks::<ABREAST>();
    let mut sums = [0.0; ABREAST];
    for (a, b) in a_groups.iter().zip(b_groups) {
        for lane in 0..ABREAST {
            sums[lane] += a[lane] * b[lane];
        }
    }
    for (lane, (a, b)) in a_rest.iter().zip(b_rest).enumerate() {
        sums[lane] += a * b;
    }
    sums.into_iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_of_the_factor_are_those_of_the_rows_however_they_are_cut() {
        let rows = DMatrix::from_fn(100, 7, |row, column| ((row * 31 + column * 17) % 23) as f64 - 9.0);
        let expected = rows.transpose() * &rows;
        for cut in [100, 37, 1] {
            let mut factor = TriangularFactor::new(7);
            for first in (0..100).step_by(cut) {
                let count = cut.min(100 - first);
                let mut block = rows.rows(first, count).clone_owned().as_slice().to_vec();
                factor.take(&mut block, count, count);
            }
            let r = DMatrix::from_fn(7, 7, |row, column| factor.at(row, column));
            let apart = (r.transpose() * &r - &expected).abs().max();
            assert!(apart < 1e-10, "{cut} rows a block: {apart}");
        }
    }
}
