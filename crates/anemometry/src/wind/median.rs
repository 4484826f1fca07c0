//! A median in memory that does not grow with the number of values, to half a per cent.

use std::collections::BTreeMap;

/// Bins by the factor e.
const BINS: f64 = 200.0;

/// Values that are not negative, counted by their logarithm.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LogMedian {
    counts: BTreeMap<i32, u64>,
    count: u64,
}

impl LogMedian {
    /// Counts a value, unless it is negative or not finite.
    pub fn add(&mut self, value: f64) {
        if value.is_finite() && value >= 0.0 {
            // ln 0 is the least bin of all.
            *self.counts.entry((BINS * value.ln()).round() as i32).or_default() += 1;
            self.count += 1;
        }
    }

    /// The median; `None` without values.
    pub fn value(&self) -> Option<f64> {
        let mut left = self.count.div_ceil(2);
        for (&bin, &count) in &self.counts {
            if count >= left {
                return Some((f64::from(bin) / BINS).exp());
            }
            left -= count;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_the_middle_value_to_half_a_per_cent_whatever_the_greatest_is() {
        let mut median = LogMedian::default();
        assert_eq!(median.value(), None);
        for value in [3e-3, 1e6, 0.0, 2e-3, 1e9, f64::NAN, -1.0] {
            median.add(value);
        }
        assert!((median.value().unwrap() / 3e-3 - 1.0).abs() < 5e-3, "{median:?}");
        let mut none = LogMedian::default();
        none.add(0.0);
        assert_eq!(none.value(), Some(0.0));
    }
}
