//! The exponential of a matrix, by scaling and squaring around a Padé approximant.
//!
//! (Higham 2005, SIAM J. Matrix Anal. Appl. 26, 1179, with the approximant of degree 13)
//!
//! nalgebra has one, too, but only with products that choose their instructions at run time.

use nalgebra::DMatrix;

/// Coefficients of the numerator, from the constant upwards.
const PADE: [f64; 14] = [
    64_764_752_532_480_000.0,
    32_382_376_266_240_000.0,
    7_771_770_303_897_600.0,
    1_187_353_796_428_800.0,
    129_060_195_264_000.0,
    10_559_470_521_600.0,
    670_442_572_800.0,
    33_522_128_640.0,
    1_323_241_920.0,
    40_840_800.0,
    960_960.0,
    16_380.0,
    182.0,
    1.0,
];

/// Norm up to which the approximant is exact to rounding.
const MOST_NORM: f64 = 5.371_920_351_148_152;

/// Returns e^A of a square matrix.
///
/// # Panics
/// If an entry is not finite.
pub fn exponential(a: &DMatrix<f64>) -> DMatrix<f64> {
    let norm = a.column_iter().map(|column| column.lp_norm(1)).fold(0.0, f64::max);
    assert!(norm.is_finite(), "the matrix has entries that are not finite");
    let halvings = if norm > MOST_NORM { libm::log2(norm / MOST_NORM).ceil() as i32 } else { 0 };
    let a = a * 2.0_f64.powi(-halvings);
    let one = DMatrix::identity(a.nrows(), a.ncols());
    let a2 = &a * &a;
    let a4 = &a2 * &a2;
    let a6 = &a4 * &a2;
    let sum = |c: [f64; 4]| &a6 * c[3] + &a4 * c[2] + &a2 * c[1] + &one * c[0];
    let p = PADE;
    let odd = &a * (&a6 * sum([0.0, p[9], p[11], p[13]]) + sum([p[1], p[3], p[5], p[7]]));
    let even = &a6 * sum([0.0, p[8], p[10], p[12]]) + sum([p[0], p[2], p[4], p[6]]);
    let quotient = (&even - &odd).lu().solve(&(even + odd));
    let mut power = quotient.expect("below that norm the denominator has an inverse");
    for _ in 0..halvings {
        power = &power * &power;
    }
    power
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_near(found: &DMatrix<f64>, wanted: &DMatrix<f64>) {
        let most = (found - wanted).amax() / wanted.amax();
        assert!(most < 1e-14, "{found} is {most} from {wanted}");
    }

    #[test]
    fn a_rotation_has_cosines_and_sines_at_any_angle() {
        for angle in [1e-9, 0.3, 3.0, 40.0] {
            let (sin, cos) = (libm::sin(angle), libm::cos(angle));
            let found = exponential(&DMatrix::from_row_slice(2, 2, &[0.0, -angle, angle, 0.0]));
            let wanted = DMatrix::from_row_slice(2, 2, &[cos, -sin, sin, cos]);
            assert!((found - wanted).amax() < 2e-14 * (1.0 + angle / 10.0));
        }
    }

    #[test]
    fn decays_over_six_decades_stay_exact_beside_each_other() {
        let rates = [1e-3, 1.0, 30.0, 1000.0];
        let found = exponential(&DMatrix::from_diagonal(&rates.map(|rate| -rate).to_vec().into()));
        for (i, rate) in rates.iter().enumerate() {
            assert!((found[(i, i)] - libm::exp(-rate)).abs() < 1e-13, "{rate}");
        }
    }

    #[test]
    fn a_defective_matrix_has_its_series() {
        let found = exponential(&DMatrix::from_row_slice(3, 3, &[0.0, 7.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0]));
        is_near(&found, &DMatrix::from_row_slice(3, 3, &[1.0, 7.0, 7.0, 0.0, 1.0, 2.0, 0.0, 0.0, 1.0]));
    }

    #[test]
    fn a_full_matrix_and_its_inverse_give_one() {
        let a = DMatrix::from_fn(5, 5, |i, j| ((i * 7 + j * 3) % 11) as f64 / 6.0 - 0.8);
        is_near(&(exponential(&a) * exponential(&-&a)), &DMatrix::identity(5, 5));
    }
}
