//! How far values spread: their range and their first two moments, in one go.

use pulp::{Simd, WithSimd};

/// Values that are gone through side by side: a sum alone would wait for each of its additions.
const ABREAST: usize = 8;

/// Of some values v, which are finite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    pub least: f64,
    pub greatest: f64,
    /// Σ(v − from) and Σ(v − from)²
    pub sum: f64,
    pub squares: f64,
}

impl Spread {
    /// The bits do not depend on the machine's vectors: each of the sums abreast runs by itself.
    pub fn of(values: &[f64], from: f64) -> Self {
        pulp::Arch::new().dispatch(Values { values, from })
    }
}

struct Values<'a> {
    values: &'a [f64],
    from: f64,
}

impl WithSimd for Values<'_> {
    type Output = Spread;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Spread {
        let Self { values, from } = self;
        let (mut least, mut greatest) = ([f64::INFINITY; ABREAST], [f64::NEG_INFINITY; ABREAST]);
        let (mut sum, mut squares) = ([0.0; ABREAST], [0.0; ABREAST]);
        let (groups, rest) = values.as_chunks::<ABREAST>();
        for group in groups {
            for lane in 0..ABREAST {
                let (value, moved) = (group[lane], group[lane] - from);
                least[lane] = if value < least[lane] { value } else { least[lane] };
                greatest[lane] = if value > greatest[lane] { value } else { greatest[lane] };
                sum[lane] += moved;
                squares[lane] += moved * moved;
            }
        }
        let mut spread = Spread { least: f64::INFINITY, greatest: f64::NEG_INFINITY, sum: 0.0, squares: 0.0 };
        for lane in 0..ABREAST {
            spread.least = spread.least.min(least[lane]);
            spread.greatest = spread.greatest.max(greatest[lane]);
            spread.sum += sum[lane];
            spread.squares += squares[lane];
        }
        for value in rest {
            let moved = value - from;
            spread.least = spread.least.min(*value);
            spread.greatest = spread.greatest.max(*value);
            spread.sum += moved;
            spread.squares += moved * moved;
        }
        spread
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn range_and_moments_hold_whatever_the_number_of_values() {
        for count in [1_u32, 7, 8, 9, 80, 1_003] {
            // 3, 4, 5 … : whole numbers, of which sums are exact
            let values: Vec<f64> = (0..count).map(|n| f64::from(n + 3)).collect();
            let n = f64::from(count) - 1.0;
            let expected = Spread {
                least: 3.0,
                greatest: n + 3.0,
                sum: n * (n + 1.0) / 2.0,
                squares: n * (n + 1.0) * (2.0 * n + 1.0) / 6.0,
            };
            assert_eq!(Spread::of(&values, 3.0), expected, "{count} values");
        }
    }
}
