//! Covariances of steady filters, by doubling: every step goes twice as far as the one before.
//!
//! ```text
//! Riccati   P = F P Fᵀ − F P hᵀ (h P hᵀ + r)⁻¹ h P Fᵀ + Q
//! Lyapunov  X = A X Aᵀ + B
//! ```
//!
//! Structured doubling (E. K.-W. Chu, H.-Y. Fan, W.-W. Lin, C.-S. Wang, Int. J. Control 77
//! (2004) 767) converges quadratically, so that modes whose memory is 10⁷ samples take two dozen
//! steps, and takes no eigenvectors, which a Foster network read every millisecond has nearly in
//! parallel.

use nalgebra::{DMatrix, DVector};

/// Doublings after which 2⁶⁰ samples are behind.
const MOST: usize = 60;
const SETTLED: f64 = 1e-13;

/// P of the filter of x ← F x + w, y = h x + v, with covariance `noise` of w and variance
/// `variance` of v; `None` if it does not settle.
pub fn riccati(
    transition: &DMatrix<f64>,
    h: &DVector<f64>,
    noise: &DMatrix<f64>,
    variance: f64,
) -> Option<DMatrix<f64>> {
    let n = h.len();
    let mut a = transition.transpose();
    let mut g = h * h.transpose() / variance;
    let mut p = noise.clone();
    for _ in 0..MOST {
        let inverse = (DMatrix::identity(n, n) + &g * &p).try_inverse()?;
        let pulled = &a * &inverse;
        let added = a.transpose() * &p * &inverse * &a;
        let new = symmetric(&p + &added);
        g = symmetric(&g + &pulled * &g * a.transpose());
        a = pulled * &a;
        let is_settled = added.norm() <= SETTLED * new.norm();
        p = new;
        if !p.norm().is_finite() {
            return None;
        }
        if is_settled {
            return Some(p);
        }
    }
    None
}

/// X of x ← A x + w with covariance `noise` of w; `None` if A is not stable.
pub fn lyapunov(transition: &DMatrix<f64>, noise: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let mut a = transition.clone();
    let mut x = noise.clone();
    for _ in 0..MOST {
        let added = &a * &x * a.transpose();
        x += &added;
        a = &a * &a;
        // Squares of the norm overflow first.
        if !x.norm().is_finite() {
            return None;
        }
        if added.norm() <= SETTLED * x.norm() {
            return Some(x);
        }
    }
    None
}

fn symmetric(of: DMatrix<f64>) -> DMatrix<f64> {
    0.5 * (&of + of.transpose())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> (DMatrix<f64>, DVector<f64>, DMatrix<f64>) {
        let f = DMatrix::from_row_slice(3, 3, &[1.0 - 1e-6, 0.0, -1e-6, 0.0, 0.9, -0.1, 0.0, 0.0, 1.0]);
        (
            f,
            DVector::from_vec(vec![400.0, 120.0, 0.0]),
            DMatrix::from_diagonal(&DVector::from_vec(vec![1e-14, 0.0, 1e-10])),
        )
    }

    #[test]
    fn the_riccati_equation_holds_for_modes_of_any_slowness() {
        let (f, h, q) = example();
        let r = 1e-6;
        let p = riccati(&f, &h, &q, r).unwrap();
        let gain = &p * &h / (h.dot(&(&p * &h)) + r);
        let again = &f * (&p - &gain * (h.transpose() * &p)) * f.transpose() + &q;
        assert!((&again - &p).norm() < 1e-9 * p.norm(), "{again} {p}");
        assert!(p.clone().symmetric_eigenvalues().min() > 0.0);
    }

    #[test]
    fn a_random_walk_has_the_variance_of_the_textbook() {
        // P = (q + √(q² + 4 q r))/2 for one state that is read with variance r.
        let one = |value| DMatrix::from_element(1, 1, value);
        let p = riccati(&one(1.0), &DVector::from_element(1, 1.0), &one(0.01), 4.0).unwrap()[0];
        assert!((p - (0.01 + (0.0001_f64 + 0.16).sqrt()) / 2.0).abs() < 1e-14);
        assert!((lyapunov(&one(0.999), &one(2.0)).unwrap()[0] * (1.0 - 0.999 * 0.999) - 2.0).abs() < 1e-9);
        assert!(lyapunov(&one(1.5), &one(1.0)).is_none());
    }
}
