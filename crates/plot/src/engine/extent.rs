//! Between which values some values lie.

/// Share of the values that an axis may leave out at either end: transients of the start.
const LEFT_OUT: f64 = 0.005;

/// The least and the greatest of those that are finite.
pub fn extent(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    let ends = values.into_iter().filter(|value| value.is_finite()).map(|value| (value, value));
    ends.reduce(|all, of| (all.0.min(of.0), all.1.max(of.1)))
}

/// The same but for a few at either end.
pub fn extent_of_most(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    let mut values: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    let left_out = (values.len() as f64 * LEFT_OUT) as usize;
    Some((*values.get(left_out)?, *values.get(values.len() - 1 - left_out)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_values_do_not_count_and_few_may_be_left_out() {
        assert_eq!(extent([2.0, f64::NAN, -1.0, f64::INFINITY]), Some((-1.0, 2.0)));
        assert_eq!((extent([f64::NAN]), extent_of_most([f64::NAN])), (None, None));
        // Half a percent of 400 are two.
        assert_eq!(extent_of_most((0..400).map(f64::from)), Some((2.0, 397.0)));
        assert_eq!(extent_of_most([3.0]), Some((3.0, 3.0)));
    }
}
