//! The amplitudes as functions of ln Re, in the numbers that are fitted: splines, or King's law.
//!
//! ```text
//! splines     a_n(Re) = β_n + (Re/Re_most)^p_n Σ_k C_nk B_k(ln Re)
//!             β_0 = Nu at rest, others 0;  p = ½ for n = 0, 1, else 1
//! King's law  a_0(Re) = β_0 + C_0 + C_1 F_0 (Re/Re_most)^m       a_n(Re) = C_1 F_n (Re/Re_most)^m
//!             F_n: Σ F_n cos 2nφ ≈ (cos² φ + k² sin² φ)^(m/2)
//! ```
//!
//! King's law has an exponent m, wires a yaw factor k besides: the share of the speed along a wire
//! that counts (F. E. Jørgensen, DISA Information 11 (1971) 31). Both are sought by
//! [`solve`](mod@super::solve) beside the coefficients; for given ones the law is linear like a spline.
//!
//! The powers make the splines flat: a_0 − 2 and a_1 go between Re^½ and Re in a laminar stream,
//! the others faster. Towards quiescent gas, below the slowest wind, dr-core's `nusselt` continues
//! in its own way, a_0 to 2 and the others to 0.
//!
//! Where winds say little, coefficients are held by a prior, as if it had been measured:
//!
//! | of | value | standard error | reason |
//! |---|---|---|---|
//! | curvature of Σ C B in ln Re | 0 | `CURVATURE` | the published sphere has 2 at most, and more only at a change of regime |
//! | Nu at rest, where it is sought | β_0 | `REST` β_0 | a stem and a body that is no sphere change it |
//! | C_nk, n ≥ 2 | 0 | `SIZE` | no published amplitude is half of this up to Re 300 |
//!
//! An order that no surface of the head sees (the even ones of two hemispheres) is left out and
//! stays zero. King's law needs no prior.
//!
//! Cubic B-splines on the range of ln Re that the winds cover.
//!
//! Clamped at both ends: Σ_k B_k = 1, and B_0 = 1 at the first end, B_last = 1 at the last. By the
//! recursion of de Boor (*A Practical Guide to Splines*, ch. IX). The inner knots divide the
//! speeds, not the range, so that there are as many speeds between any two.

use dr_core::wind::nusselt::ORDERS;
use dr_core::wind::{HeadForm, SurfaceConfig};

const CURVATURE: f64 = 6.0;
/// Relative standard error of Nu at rest before any reading.
const REST: f64 = 0.15;
/// Prior size of a coefficient.
pub const SIZE: f64 = 8.0;
/// More coefficients would follow the noise: the amplitudes have no more shape than this between
/// quiescent gas and a turbulent wake.
const MOST_COUNT: usize = 9;
/// A mean less than this is none.
const SEEN: f32 = 1e-6;

/// Dependence of amplitudes on the Reynolds number.
#[derive(Debug, Clone, PartialEq)]
pub enum AmplitudeShape {
    /// Freely, by a basis over the logarithm of the Reynolds number.
    Spline(Spline),
    /// By King's law itself, whose exponent and yaw factor are sought.
    Law,
    /// King's law: one power of it, with the shares of the orders.
    King {
        /// m
        exponent: f64,
        /// F_n
        shares: [f64; ORDERS],
    },
}

/// Amplitudes over the Reynolds number.
#[derive(Debug, Clone, PartialEq)]
pub struct AmplitudeFamily {
    /// Dependence on it.
    pub shape: AmplitudeShape,
    /// β_0
    pub at_rest: f64,
    /// Least Reynolds number of the winds.
    pub least_reynolds: f64,
    /// Greatest Reynolds number of the winds.
    pub most_reynolds: f64,
    /// The orders that the head sees.
    pub orders: Vec<usize>,
    /// Nu at rest is sought, as what the last coefficient adds to β_0.
    pub is_rest_sought: bool,
}

/// Amount that a unit of each coefficient gives to each amplitude at one Reynolds number.
pub type BasisAt = Vec<[f64; ORDERS]>;

impl AmplitudeFamily {
    /// For winds of these Reynolds numbers (ascending, distinct speeds) and so many readings.
    pub fn new(form: HeadForm, reynolds: &[f64], orders: Vec<usize>, readings: usize) -> Self {
        let at: Vec<f64> = reynolds.iter().map(|r| libm::log(*r)).collect();
        // Two readings for every coefficient.
        let affordable = readings / (2 * orders.len().max(1));
        let count = reynolds.len().min(affordable).clamp(LEAST_COUNT, MOST_COUNT);
        Self {
            shape: AmplitudeShape::Spline(Spline::through(&at, count)),
            at_rest: f64::from(form.nusselt_at_rest()),
            least_reynolds: reynolds[0],
            most_reynolds: reynolds[reynolds.len() - 1],
            orders,
            is_rest_sought: false,
        }
    }

    /// Nu at rest.
    pub fn rest(&self, coefficients: &[f64]) -> f64 {
        let sought = self.is_rest_sought.then(|| coefficients.last().copied()).flatten();
        self.at_rest + sought.unwrap_or(0.0)
    }

    /// Number of coefficients of all orders.
    pub fn count(&self) -> usize {
        let of_shape = match &self.shape {
            AmplitudeShape::Spline(spline) => self.orders.len() * spline.count(),
            AmplitudeShape::Law | AmplitudeShape::King { .. } => 2,
        };
        of_shape + usize::from(self.is_rest_sought)
    }

    /// The basis at a Reynolds number; nothing for the law itself.
    pub fn at(&self, reynolds: f64) -> BasisAt {
        let s = reynolds / self.most_reynolds;
        let mut rows = vec![[0.0; ORDERS]; self.count()];
        if self.is_rest_sought
            && let Some(rest) = rows.last_mut()
        {
            rest[0] = 1.0;
        }
        match &self.shape {
            AmplitudeShape::Spline(spline) => {
                let basis = spline.values(libm::log(reynolds));
                let places = self.orders.iter().flat_map(|&n| basis.iter().map(move |b| (n, b)));
                for (row, (n, b)) in rows.iter_mut().zip(places) {
                    row[n] = b * if n < 2 { s.sqrt() } else { s };
                }
            }
            AmplitudeShape::Law => {}
            AmplitudeShape::King { exponent, shares } => {
                rows[0][0] = 1.0;
                rows[1] = shares.map(|share| share * libm::pow(s, *exponent));
            }
        }
        rows
    }

    /// a_0 … a_5
    pub fn amplitudes(&self, at: &BasisAt, coefficients: &[f64]) -> [f64; ORDERS] {
        let mut a = [0.0; ORDERS];
        a[0] = self.at_rest;
        for (c, row) in coefficients.iter().zip(at) {
            a.iter_mut().zip(row).for_each(|(a, share)| *a += c * share);
        }
        a
    }

    /// The prior: rows of (place, factor), each zero with a standard error of one;
    /// higher orders are of this `size`.
    pub fn prior(&self, size: f64) -> Vec<Vec<(usize, f64)>> {
        let AmplitudeShape::Spline(spline) = &self.shape else { return Vec::new() };
        let (count, curvatures) = (spline.count(), spline.curvatures());
        let mut rows = Vec::new();
        for (j, &n) in self.orders.iter().enumerate() {
            for (k, factors) in &curvatures {
                rows.push((0..3).map(|i| (j * count + k + i, factors[i] / CURVATURE)).collect());
            }
            if n >= 2 {
                rows.extend((0..count).map(|k| vec![(j * count + k, 1.0 / size)]));
            }
        }
        if self.is_rest_sought {
            rows.push(vec![(self.count() - 1, 1.0 / (REST * self.at_rest))]);
        }
        rows
    }
}

/// The orders that at least one surface sees.
pub fn seen_orders<'a>(surfaces: impl Iterator<Item = &'a SurfaceConfig> + Clone) -> Vec<usize> {
    let sees = |surface: &SurfaceConfig, n: usize| {
        n == 0 || surface.means[n - 1].abs() > SEEN || (n >= 3 && surface.threefold[n - 3].abs() > SEEN)
    };
    (0..ORDERS).filter(|&n| surfaces.clone().any(|surface| sees(surface, n))).collect()
}

const DEGREE: usize = 3;

/// Least number of coefficients: one cubic.
pub const LEAST_COUNT: usize = DEGREE + 1;

/// Cubic B-splines on given knots.
#[derive(Debug, Clone, PartialEq)]
pub struct Spline {
    knots: Vec<f64>,
}

impl Spline {
    /// `count` ≥ 4 coefficients; `at` ascends, at least two places.
    pub fn through(at: &[f64], count: usize) -> Self {
        let (first, last) = (at[0], at[at.len() - 1]);
        let intervals = count - DEGREE;
        let inner = (1..intervals).map(|j| {
            let place = j as f64 * (at.len() - 1) as f64 / intervals as f64;
            let below = place as usize;
            at[below] + (place - below as f64) * (at[below + 1] - at[below])
        });
        let ends = |x| std::iter::repeat_n(x, DEGREE + 1);
        Self { knots: ends(first).chain(inner).chain(ends(last)).collect() }
    }

    /// Number of coefficients.
    pub fn count(&self) -> usize {
        self.knots.len() - DEGREE - 1
    }

    /// All B_k at `x`; beyond an end, those of the end.
    pub fn values(&self, x: f64) -> Vec<f64> {
        let (t, count) = (&self.knots, self.count());
        let x = x.clamp(t[0], t[count]);
        let interval = (t.partition_point(|&t| t <= x).max(1) - 1).clamp(DEGREE, count - 1);
        let mut b = vec![0.0; t.len() - 1];
        b[interval] = 1.0;
        for degree in 1..=DEGREE {
            for k in 0..b.len() - degree {
                let part =
                    |b: f64, over: f64, under: f64| if b == 0.0 || under == 0.0 { 0.0 } else { b * over / under };
                b[k] = part(b[k], x - t[k], t[k + degree] - t[k])
                    + part(b[k + 1], t[k + degree + 1] - x, t[k + degree + 1] - t[k + 1]);
            }
        }
        b.truncate(count);
        b
    }

    /// For every three coefficients in a row, what makes their curvature in x of them.
    pub fn curvatures(&self) -> Vec<(usize, [f64; 3])> {
        // Where a coefficient is at home (Greville): a straight line has its own values there as
        // coefficients.
        let at: Vec<f64> =
            (0..self.count()).map(|k| self.knots[k + 1..=k + DEGREE].iter().sum::<f64>() / DEGREE as f64).collect();
        (0..self.count() - 2)
            .map(|k| {
                let (left, right) = (at[k + 1] - at[k], at[k + 2] - at[k + 1]);
                let half = 0.5 * (left + right);
                (k, [1.0 / (left * half), -(1.0 / left + 1.0 / right) / half, 1.0 / (right * half)])
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reproduces_a_cubic_from_its_blossom() {
        let at = [0.0, 0.3, 1.0, 1.2, 2.0, 2.5, 3.1];
        for count in LEAST_COUNT..=7 {
            let spline = Spline::through(&at, count);
            assert_eq!(spline.count(), count);
            for step in 0..=100 {
                let x = 0.031 * f64::from(step);
                let b = spline.values(x);
                // The coefficient of x³ is the product of the three knots within its support.
                let cubic: f64 =
                    (0..count).map(|k| b[k] * spline.knots[k + 1] * spline.knots[k + 2] * spline.knots[k + 3]).sum();
                assert!((b.iter().sum::<f64>() - 1.0).abs() < 1e-12 && b.iter().all(|b| *b >= 0.0), "{b:?}");
                assert!((cubic - x * x * x).abs() < 1e-11, "{cubic} at {x}");
            }
        }
    }

    #[test]
    fn curvature_is_that_of_the_coefficients() {
        let spline = Spline::through(&[0.0, 0.5, 1.0, 1.7, 2.6, 3.0], 7);
        let at: Vec<f64> = (0..7).map(|k| spline.knots[k + 1..=k + 3].iter().sum::<f64>() / 3.0).collect();
        for (k, c) in spline.curvatures() {
            // It is 2 for a parabola x², nothing for a straight line.
            let of = |f: fn(f64) -> f64| (0..3).map(|j| c[j] * f(at[k + j])).sum::<f64>();
            assert!((of(|x| x * x) - 2.0).abs() < 1e-10 && of(|x| 3.0 * x - 1.0).abs() < 1e-10);
        }
    }
}
