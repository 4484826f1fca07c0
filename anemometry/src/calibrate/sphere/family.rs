//! The amplitudes as functions of ln Re, in the numbers that are fitted.
//!
//! ```text
//! a_n(Re) = β_n + (Re/Re_most)^p_n Σ_k C_nk B_k(ln Re)
//! β_0 = 2, others 0;  p = ½ for n = 0, 1, else 1
//! ```
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
//! | C_nk, n ≥ 2 | 0 | `SIZE` | no published amplitude is half of this up to Re 300 |
//!
//! An order that no surface of the head sees (the even ones of two hemispheres) is left out and
//! stays zero.

use dr_core::wind::SurfaceConfig;
use dr_core::wind::nusselt::{CONDUCTION, ORDERS};

use super::spline::{LEAST_COUNT, Spline};

const CURVATURE: f64 = 6.0;
/// Prior size of a coefficient.
pub const SIZE: f64 = 8.0;
/// More coefficients would follow the noise: the amplitudes have no more shape than this between
/// quiescent gas and a turbulent wake.
const MOST_COUNT: usize = 9;
/// A mean less than this is none.
const SEEN: f32 = 1e-6;

/// Legendre amplitudes over the Reynolds number, as splines.
#[derive(Debug, Clone, PartialEq)]
pub struct AmplitudeFamily {
    /// Basis over the logarithm of the Reynolds number.
    pub spline: Spline,
    /// Least Reynolds number of the winds.
    pub least_reynolds: f64,
    /// Greatest Reynolds number of the winds.
    pub most_reynolds: f64,
    /// The orders that the head sees.
    pub orders: Vec<usize>,
}

/// Amplitudes at one Reynolds number, as they follow from the coefficients.
pub struct BasisAt {
    /// B_k
    pub basis: Vec<f64>,
    /// (Re/Re_most)^p_n
    pub scale: [f64; ORDERS],
}

impl AmplitudeFamily {
    /// For winds of these Reynolds numbers (ascending, distinct speeds) and so many readings.
    pub fn new(reynolds: &[f64], orders: Vec<usize>, readings: usize) -> Self {
        let at: Vec<f64> = reynolds.iter().map(|r| r.ln()).collect();
        // Two readings for every coefficient.
        let affordable = readings / (2 * orders.len().max(1));
        let count = reynolds.len().min(affordable).clamp(LEAST_COUNT, MOST_COUNT);
        Self {
            spline: Spline::through(&at, count),
            least_reynolds: reynolds[0],
            most_reynolds: reynolds[reynolds.len() - 1],
            orders,
        }
    }

    /// Number of coefficients of all orders.
    pub fn count(&self) -> usize {
        self.orders.len() * self.spline.count()
    }

    /// The basis at a Reynolds number.
    pub fn at(&self, reynolds: f64) -> BasisAt {
        let s = reynolds / self.most_reynolds;
        let scale = std::array::from_fn(|n| if n < 2 { s.sqrt() } else { s });
        BasisAt { basis: self.spline.values(reynolds.ln()), scale }
    }

    /// a_0 … a_5
    pub fn amplitudes(&self, at: &BasisAt, coefficients: &[f64]) -> [f64; ORDERS] {
        let mut a = [0.0; ORDERS];
        a[0] = f64::from(CONDUCTION);
        for (&n, own) in self.orders.iter().zip(coefficients.chunks(self.spline.count())) {
            a[n] += at.scale[n] * own.iter().zip(&at.basis).map(|(c, b)| c * b).sum::<f64>();
        }
        a
    }

    /// The prior: rows of (place, factor), each zero with a standard error of one;
    /// higher orders are of this `size`.
    pub fn prior(&self, size: f64) -> Vec<Vec<(usize, f64)>> {
        let (count, curvatures) = (self.spline.count(), self.spline.curvatures());
        let mut rows = Vec::new();
        for (j, &n) in self.orders.iter().enumerate() {
            for (k, factors) in &curvatures {
                rows.push((0..3).map(|i| (j * count + k + i, factors[i] / CURVATURE)).collect());
            }
            if n >= 2 {
                rows.extend((0..count).map(|k| vec![(j * count + k, 1.0 / size)]));
            }
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
