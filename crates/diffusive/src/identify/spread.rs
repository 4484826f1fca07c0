//! Spread of values: their range and their first two moments, in one go; and how an input moves
//! from row to row, by which a drift is told from a body.

use pulp::{Simd, WithSimd};

/// Values that are gone through side by side: a sum alone would wait for each of its additions.
const ABREAST: usize = 16;

/// Values that are gone through twice while they are at hand.
const PART: usize = 1024;

/// Of some values v, which are finite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ValueSpread {
    pub count: u64,
    /// From where moments are counted.
    pub from: f64,
    pub least: f64,
    pub greatest: f64,
    /// Σ(v − from) and Σ(v − from)²
    pub sum: f64,
    pub squares: f64,
}

impl ValueSpread {
    /// Of no values yet.
    pub fn from(from: f64) -> Self {
        Self { count: 0, from, least: f64::INFINITY, greatest: f64::NEG_INFINITY, sum: 0.0, squares: 0.0 }
    }

    /// The bits do not depend on the machine's vectors: each of the sums abreast runs by itself.
    pub fn add(&mut self, values: &[f64]) {
        let more = pulp::Arch::new().dispatch(Spreading { values, from: self.from });
        self.count += more.count;
        self.least = self.least.min(more.least);
        self.greatest = self.greatest.max(more.greatest);
        self.sum += more.sum;
        self.squares += more.squares;
    }

    /// Standard deviation.
    pub fn sd(&self) -> f64 {
        deviation(self.sum, self.squares, self.count)
    }
}

/// Standard deviation of values with these moments.
pub fn deviation(sum: f64, squares: f64, count: u64) -> f64 {
    let n = (count as f64).max(1.0);
    (squares / n - (sum / n).powi(2)).max(0.0).sqrt()
}

struct Spreading<'a> {
    values: &'a [f64],
    from: f64,
}

impl WithSimd for Spreading<'_> {
    type Output = ValueSpread;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> ValueSpread {
        let Self { values, from } = self;
        let (mut least, mut greatest) = ([f64::INFINITY; ABREAST], [f64::NEG_INFINITY; ABREAST]);
        let (mut sum, mut squares) = ([0.0; ABREAST], [0.0; ABREAST]);
        for part in values.chunks(PART) {
            let (groups, rest) = part.as_chunks::<ABREAST>();
            // Range and moments each by themselves: together they are more than registers hold, and
            // more than a compiler sorts out.
            for group in groups {
                for lane in 0..ABREAST {
                    least[lane] = if group[lane] < least[lane] { group[lane] } else { least[lane] };
                }
                for lane in 0..ABREAST {
                    greatest[lane] = if group[lane] > greatest[lane] { group[lane] } else { greatest[lane] };
                }
            }
            for group in groups {
                for lane in 0..ABREAST {
                    sum[lane] += group[lane] - from;
                }
                for lane in 0..ABREAST {
                    squares[lane] += (group[lane] - from) * (group[lane] - from);
                }
            }
            for (lane, &value) in rest.iter().enumerate() {
                least[lane] = least[lane].min(value);
                greatest[lane] = greatest[lane].max(value);
                sum[lane] += value - from;
                squares[lane] += (value - from) * (value - from);
            }
        }
        ValueSpread {
            count: values.len() as u64,
            from,
            least: least.into_iter().fold(f64::INFINITY, f64::min),
            greatest: greatest.into_iter().fold(f64::NEG_INFINITY, f64::max),
            sum: sum.iter().sum(),
            squares: squares.iter().sum(),
        }
    }
}

/// How an input moves from row to row.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct InputMoves {
    /// Rows in which it moves by more than a tenth of its range.
    pub moves: u64,
    /// Sum of all its changes, whatever their sign.
    pub travel: f64,
    pub last: f64,
}

impl InputMoves {
    /// Takes the next values; a move is `far` or more.
    pub fn add(&mut self, values: &[f64], far: f64) {
        // Side by side, as a single sum would wait for each of its additions.
        let (mut moves, mut travel) = ([0_u64; ABREAST], [0.0; ABREAST]);
        let mut add = |values: &[f64], before: &[f64]| {
            for (at, (value, before)) in values.iter().zip(before).enumerate() {
                let by = (value - before).abs();
                moves[at] += u64::from(by > far);
                travel[at] += by;
            }
        };
        add(&values[..1], &[self.last]);
        for (values, before) in values[1..].chunks(ABREAST).zip(values.chunks(ABREAST)) {
            add(values, before);
        }
        self.moves += moves.iter().sum::<u64>();
        self.travel += travel.iter().sum::<f64>();
        self.last = values[values.len() - 1];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn range_and_moments_hold_whatever_the_number_of_values() {
        for count in [1_u32, 15, 16, 17, 160, 3_003] {
            // 3, 4, 5 … : whole numbers, of which sums are exact
            let values: Vec<f64> = (0..count).map(|n| f64::from(n + 3)).collect();
            let n = f64::from(count) - 1.0;
            let expected = ValueSpread {
                count: u64::from(count),
                from: 3.0,
                least: 3.0,
                greatest: n + 3.0,
                sum: n * (n + 1.0) / 2.0,
                squares: n * (n + 1.0) * (2.0 * n + 1.0) / 6.0,
            };
            let mut spread = ValueSpread::from(3.0);
            spread.add(&values);
            assert_eq!(spread, expected, "{count} values");
        }
    }
}
