//! Common operations of the board's f32 and the host's f64: formulas that both need stand once, and
//! round as their number does.

use core::ops::{Add, Div, Mul, Sub};

/// f32 or f64, with `+ − × ÷` and comparisons only: no functions, so that every body computes the
/// same bits.
pub trait Real:
    Copy + PartialOrd + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// Nothing.
    const ZERO: Self;
}

impl Real for f32 {
    const ZERO: Self = 0.0;
}

impl Real for f64 {
    const ZERO: Self = 0.0;
}
