//! Numbers of twice the digits of f64, for sums of decays that all but cancel.
//!
//! (T. J. Dekker, *Numerische Mathematik* 18 (1971) 224)

use std::ops::{Add, Div, Mul, Neg};

use crate::identify::panels::exact_sum;

/// A sum of two numbers: the second is less than half of the last digit of the first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Twofold([f64; 2]);

impl From<f64> for Twofold {
    fn from(value: f64) -> Self {
        Self([value, 0.0])
    }
}

impl Add for Twofold {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let ([a, of_a], [b, of_b]) = (self.0, other.0);
        let (sum, lost) = exact_sum(a, b);
        let (sum, lost) = exact_sum(sum, lost + of_a + of_b);
        Self([sum, lost])
    }
}

impl Neg for Twofold {
    type Output = Self;

    fn neg(self) -> Self {
        Self(self.0.map(|part| -part))
    }
}

impl Mul for Twofold {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let ([a, of_a], [b, of_b]) = (self.0, other.0);
        let product = a * b;
        let (product, lost) = exact_sum(product, a.mul_add(b, -product) + (a * of_b + of_a * b));
        Self([product, lost])
    }
}

impl Div for Twofold {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let quotient = |left: Self| Self::from(left.0[0] / other.0[0]);
        let first = quotient(self);
        let second = quotient(self + -(first * other));
        first + second + quotient(self + -((first + second) * other))
    }
}

impl Twofold {
    /// The nearest number.
    pub fn rounded(self) -> f64 {
        self.0[0] + self.0[1]
    }

    pub fn power(self, exponent: u64) -> Self {
        let (mut power, mut square, mut left) = (Self::from(1.0), self, exponent);
        while left > 0 {
            if left % 2 == 1 {
                power = power * square;
            }
            (square, left) = (square * square, left / 2);
        }
        power
    }
}

/// Σ p_n p_{n+l} over `rows` rows in all, for l = 0 … `lags`, of p_n = Σ_k c_k d_k^n:
///
/// ```text
/// Σ_ij c_i c_j d_j^l (1 − (d_i d_j)^(N−l))/(1 − d_i d_j)
/// ```
pub fn decay_products(decays: &[(f64, f64)], rows: u64, lags: usize) -> Vec<f64> {
    let one = Twofold::from(1.0);
    let mut sums = vec![Twofold::from(0.0); lags + 1];
    let least = rows.saturating_sub(lags as u64);
    for &(size, keep) in decays {
        for &(other_size, other) in decays {
            let (sizes, both) = (Twofold::from(size) * other_size.into(), Twofold::from(keep) * other.into());
            let each = if both == one { None } else { Some(one / (one + -both)) };
            let mut later: Vec<Twofold> = vec![sizes];
            (0..lags).for_each(|lag| later.push(later[lag] * other.into()));
            let mut power = both.power(least);
            for count in least..=rows {
                if let Some(sum) = sums.get_mut((rows - count) as usize) {
                    let all = each.map_or(Twofold::from(count as f64), |each| (one + -power) * each);
                    *sum = *sum + later[(rows - count) as usize] * all;
                }
                power = power * both;
            }
        }
    }
    sums.into_iter().map(Twofold::rounded).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_of_decays_that_all_but_cancel_are_those_of_their_sum() {
        // A second difference of decays, a million times as great as itself.
        let (size, keep) = (1e6, 0.999);
        let decays = [(size, keep), (-2.0 * size, keep - 1e-6), (size, keep - 2e-6), (0.5, 1.0)];
        for (rows, lags) in [(3000_u64, 40), (7, 40), (1, 3)] {
            let value = |n: u64| {
                let each = decays.iter().map(|&(size, keep)| Twofold::from(size) * Twofold::from(keep).power(n));
                each.fold(Twofold::from(0.0), |sum, of| sum + of).rounded()
            };
            let values: Vec<f64> = (0..rows).map(value).collect();
            for (lag, found) in decay_products(&decays, rows, lags).into_iter().enumerate() {
                let expected: f64 = values.iter().zip(values.iter().skip(lag)).map(|(now, later)| now * later).sum();
                // Of 3000 terms of at most 1, rounded.
                assert!((found - expected).abs() < 1e-11, "{rows} rows, lag {lag}: {found} for {expected}");
            }
        }
    }
}
