//! Cubic B-splines on the range of ln Re that the winds cover.
//!
//! Clamped at both ends: Σ_k B_k = 1, and B_0 = 1 at the first end, B_last = 1 at the last. By the
//! recursion of de Boor (*A Practical Guide to Splines*, ch. IX). The inner knots divide the
//! speeds, not the range, so that there are as many speeds between any two.

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
            // Of a parabola x² it is 2, of a straight line nothing.
            let of = |f: fn(f64) -> f64| (0..3).map(|j| c[j] * f(at[k + j])).sum::<f64>();
            assert!((of(|x| x * x) - 2.0).abs() < 1e-10 && of(|x| 3.0 * x - 1.0).abs() < 1e-10);
        }
    }
}
