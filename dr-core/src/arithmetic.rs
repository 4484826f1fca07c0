//! Square root and logarithm from `+ − × ÷` and the bits of an f32, and small vectors.

use core::f32::consts::LOG2_E;

/// Square root of a normal number greater than zero, to one unit in the last place; of zero,
/// negative numbers and NaN: themselves.
///
/// Halving the exponent's bits is right to 3.5 %; each of Newton's steps halves the square of that:
/// 6e-4, 2e-7, 2e-14.
pub fn sqrt(x: f32) -> f32 {
    if x > 0.0 {
        let mut root = f32::from_bits(0x1fbd_1df5 + (x.to_bits() >> 1));
        for _ in 0..3 {
            root = 0.5 * (root + x / root);
        }
        root
    } else {
        x
    }
}

/// Logarithm to base 2 of a normal number greater than zero.
///
/// x = 2ᵉ m with m in √½ … √2, and ln m = 2 artanh t = 2 (t + t³/3 + t⁵/5 + t⁷/7), t = (m − 1)/(m +
/// 1). What is cut off is 3e-8 at the most; rounding adds half a unit in the last place of the sum.
pub fn log2(x: f32) -> f32 {
    const SQRT_HALF: u32 = 0x3f35_04f3;
    let exponent = x.to_bits().wrapping_sub(SQRT_HALF) as i32 >> 23;
    let mantissa = f32::from_bits(x.to_bits().wrapping_sub((exponent << 23) as u32));
    let t = (mantissa - 1.0) / (mantissa + 1.0);
    let t2 = t * t;
    exponent as f32 + 2.0 * LOG2_E * t * (1.0 + t2 * (1.0 / 3.0 + t2 * (0.2 + t2 * (1.0 / 7.0))))
}

pub fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn length(a: [f32; 3]) -> f32 {
    sqrt(dot(a, a))
}

pub fn scaled(a: [f32; 3], by: f32) -> [f32; 3] {
    a.map(|x| by * x)
}

/// a + by·b
pub fn plus(a: [f32; 3], by: f32, b: [f32; 3]) -> [f32; 3] {
    [a[0] + by * b[0], a[1] + by * b[1], a[2] + by * b[2]]
}

pub fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn root_and_logarithm_agree_with_f64() {
        let mut x = 1e-30_f32;
        while x < 1e30 {
            let exact = f64::from(x).sqrt();
            assert!((f64::from(sqrt(x)) / exact - 1.0).abs() < 1.2e-7, "√{x}: {}", sqrt(x));
            let exact = libm::log2(f64::from(x));
            // Cut-off, a rounding of the sum, and some of its last terms.
            assert!((f64::from(log2(x)) - exact).abs() < 1.5e-7 + 6e-8 * exact.abs(), "log2 {x}: {}", log2(x));
            x *= 1.013;
        }
        assert_eq!((sqrt(0.0), log2(1.0), log2(8.0), log2(0.25)), (0.0, 0.0, 3.0, -2.0));
        assert!(sqrt(f32::NAN).is_nan());
    }
}
