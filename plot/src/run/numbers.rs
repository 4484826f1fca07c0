//! Arithmetic of winds and ranges that several charts share.

/// Share of the values that an axis may leave out at either end: transients of the start.
const LEFT_OUT: f64 = 0.005;

/// Least and greatest value but for a few.
pub fn most_of(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    let left_out = (values.len() as f64 * LEFT_OUT) as usize;
    Some((*values.get(left_out)?, *values.get(values.len() - 1 - left_out)?))
}

pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn size(of: [f64; 3]) -> f64 {
    dot(of, of).sqrt()
}
