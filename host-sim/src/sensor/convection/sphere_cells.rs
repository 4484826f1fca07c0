//! Means of a sphere's local Nusselt number over cells of any shape: the points nearer to a normal
//! than to any other.
//!
//! ```text
//! P_n(w·r) = Σ_m (2 − δ_m0) (n−m)!/(n+m)! P_n⁽ᵐ⁾(w_z) P_n⁽ᵐ⁾(r_z) Re[(w_x + i w_y)ᵐ (r_x − i
//! r_y)ᵐ]
//! ```
//!
//! (addition theorem, P_n⁽ᵐ⁾ the m-th derivative; w, r of length 1) splits the mean over r into
//! moments of the cell, taken once by a lattice of points, and functions of the wind's direction.
//! The lattice resolves a cell's edge to some 1e-4 of the mean.

use super::sphere_stream::{Coefficients, ORDERS, legendre};
use anemometry::vector::dot;

/// Points of the lattice, by golden angle.
const POINTS: usize = 400_000;

/// A complex number for each order n and degree m ≤ n.
type Moments = [[[f64; 2]; ORDERS]; ORDERS];

/// Cells of one sphere.
#[derive(Clone, Debug)]
pub struct SphereCells {
    cells: Vec<Moments>,
    /// Parts of the whole surface.
    shares: Vec<f64>,
}

impl SphereCells {
    /// One cell a normal, which are unit vectors.
    pub fn new(normals: &[[f64; 3]]) -> Self {
        let mut cells = vec![[[[0.0; 2]; ORDERS]; ORDERS]; normals.len()];
        let mut shares = vec![0.0_f64; normals.len()];
        let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
        for k in 0..POINTS {
            let z = 1.0 - (2.0 * k as f64 + 1.0) / POINTS as f64;
            let radius = (1.0 - z * z).sqrt();
            let angle = golden * k as f64;
            let point = [radius * libm::cos(angle), radius * libm::sin(angle), z];
            let nearest = (0..normals.len()).max_by(|&i, &j| dot(point, normals[i]).total_cmp(&dot(point, normals[j])));
            let Some(owner) = nearest else { continue };
            shares[owner] += 1.0;
            let functions = functions(point);
            for (sum, function) in cells[owner].as_flattened_mut().iter_mut().zip(functions.as_flattened()) {
                sum[0] += function[0];
                sum[1] += function[1];
            }
        }
        for (cell, &count) in cells.iter_mut().zip(&shares) {
            for (n, order) in cell.iter_mut().enumerate() {
                for (m, moment) in order.iter_mut().enumerate().take(n + 1) {
                    let ratio: f64 = (n - m + 1..=n + m).map(|k| k as f64).product();
                    *moment = moment.map(|sum| if m == 0 { 1.0 } else { 2.0 } * sum / ratio / count.max(1.0));
                }
            }
        }
        Self { cells, shares: shares.into_iter().map(|count| count / POINTS as f64).collect() }
    }

    /// Parts of the whole surface.
    pub fn shares(&self) -> &[f64] {
        &self.shares
    }

    /// Means of Σ a_n P_n(cos θ) over every cell; `from` is the unit vector towards the front
    /// stagnation point.
    pub fn means(&self, a: &Coefficients, from: [f64; 3]) -> impl Iterator<Item = f64> {
        let functions = functions(from);
        let a = *a;
        self.cells.iter().map(move |cell| {
            let order = |n: usize| -> f64 {
                (0..=n).map(|m| cell[n][m][0] * functions[n][m][0] + cell[n][m][1] * functions[n][m][1]).sum()
            };
            (0..ORDERS).map(|n| a[n] * order(n)).sum()
        })
    }
}

/// P_n⁽ᵐ⁾(z) (x + i y)ᵐ at a point of the unit sphere.
fn functions([x, y, z]: [f64; 3]) -> Moments {
    // d/dz P_n = (2n − 1) P_{n−1} + d/dz P_{n−2}, and the same for every further derivative.
    let mut derivative = legendre(z);
    let mut power = [1.0, 0.0];
    let mut functions = [[[0.0; 2]; ORDERS]; ORDERS];
    for m in 0..ORDERS {
        for (n, order) in functions.iter_mut().enumerate().skip(m) {
            order[m] = power.map(|part| derivative[n] * part);
        }
        let mut next = [0.0; ORDERS];
        for n in 1..ORDERS {
            let before = if n >= 2 { next[n - 2] } else { 0.0 };
            next[n] = (2 * n - 1) as f64 * derivative[n - 1] + before;
        }
        derivative = next;
        power = [power[0] * x - power[1] * y, power[0] * y + power[1] * x];
    }
    functions
}

#[cfg(test)]
mod tests {
    use super::*;
    use anemometry::vector::unit;

    const A: Coefficients = [9.4, 7.8, 1.8, -2.5, 1.4, 0.3];

    #[test]
    fn a_point_has_the_legendre_series_of_its_angle() {
        // Many cells: each is nearly a point.
        let normals: Vec<[f64; 3]> = super::super::sphere_stream::tests::directions(2000).collect();
        let cells = SphereCells::new(&normals);
        let from = unit([0.3, -0.5, 0.7]);
        for (normal, mean) in normals.iter().zip(cells.means(&A, from)) {
            let p = legendre(dot(*normal, from));
            let expected: f64 = (0..ORDERS).map(|n| A[n] * p[n]).sum();
            // A cell of 2.6° averages over some curvature, and its middle is not its normal.
            assert!((mean - expected).abs() < 0.15, "{mean} for {expected}");
        }
    }

    #[test]
    fn six_faces_of_a_cube_add_up_to_the_sphere_and_the_one_in_front_loses_most() {
        let normals =
            [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
        let cells = SphereCells::new(&normals);
        assert!(cells.shares().iter().all(|share| (share * 6.0 - 1.0).abs() < 1e-3), "{:?}", cells.shares());
        for from in [[1.0, 0.0, 0.0], unit([1.0, 2.0, -3.0])] {
            let means: Vec<f64> = cells.means(&A, from).collect();
            let mean: f64 = means.iter().zip(cells.shares()).map(|(mean, share)| mean * share).sum();
            assert!((mean / A[0] - 1.0).abs() < 1e-5, "{mean}");
            let most = (0..6).max_by(|&i, &j| means[i].total_cmp(&means[j])).unwrap();
            let front = (0..6).max_by(|&i, &j| dot(normals[i], from).total_cmp(&dot(normals[j], from))).unwrap();
            assert_eq!(most, front);
        }
    }
}
