//! Runs whose numbers stand apart from those of the others.
//!
//! The distance of a number x of n from the median m is z = |x − m| / (1.4826 · median |xᵢ − m|):
//! half of all numbers may be anything, and z stays what it is (Hampel, JASA 69, 1974). Where more
//! than half of all are equal, or there are fewer than five, nothing is judged.

/// Standard deviation of a normal distribution over its median deviation.
const NORMAL: f64 = 1.4826;
/// Fewer numbers say little of what is usual.
const FEWEST: usize = 5;

/// Numbers that are far from the median, by their places, with median and z; others are `None`.
pub(crate) fn distances(numbers: &[Option<f64>]) -> Vec<Option<(f64, f64)>> {
    let present: Vec<f64> = numbers.iter().flatten().copied().collect();
    if present.len() < FEWEST {
        return vec![None; numbers.len()];
    }
    let middle = median(present.clone());
    let spread = NORMAL * median(present.iter().map(|number| (number - middle).abs()).collect());
    // Rounding is no spread.
    let is_spread = spread > 1e-12 * middle.abs();
    let z =
        |number: &Option<f64>| number.filter(|_| is_spread).map(|number| (middle, (number - middle).abs() / spread));
    numbers.iter().map(z).collect()
}

fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_unstable_by(f64::total_cmp);
    let (below, above) = ((numbers.len() - 1) / 2, numbers.len() / 2);
    0.5 * (numbers[below] + numbers[above])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_that_stands_apart_does_not_widen_what_is_usual() {
        let numbers: Vec<Option<f64>> = [1.0, 2.0, 3.0, 4.0, 1000.0].map(Some).to_vec();
        let found = distances(&numbers);
        // Median 3, deviations 2 1 0 1 997: their median is 1.
        assert_eq!(found[4], Some((3.0, 997.0 / NORMAL)));
        assert_eq!(found[0], Some((3.0, 2.0 / NORMAL)));
    }

    #[test]
    fn equal_numbers_and_a_few_are_not_judged() {
        assert!(distances(&[1.0, 1.0, 1.0, 1.0, 2.0].map(Some)).iter().all(Option::is_none));
        assert!(distances(&[1.0, 2.0, 3.0, 900.0].map(Some)).iter().all(Option::is_none));
        let with_none = [Some(1.0), None, Some(2.0), Some(3.0), Some(4.0), Some(50.0)];
        assert_eq!(distances(&with_none).iter().filter(|found| found.is_some()).count(), 5);
    }
}
