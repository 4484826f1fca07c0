//! Combinations of slow errors that the winds of a recording leave as uncertain as they were.

use std::fmt;

use dr_core::wind::sphere::SECTORS;
use nalgebra::SMatrix;

use super::smoother::{ERRORS, SlowErrorsAt, SlowPrior};

/// Share of its standard deviation before anything is known beyond which an error is left open.
const OPEN: f64 = 0.5;
/// Cosine to what all surfaces share from which on a combination is that.
const COMMON: f64 = 0.9;

/// One combination.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpenError {
    /// Whether all surfaces have it alike.
    pub is_common: bool,
    /// Whether it is of gains, else of heat.
    pub is_gain: bool,
    /// mW or % of each surface.
    pub deviation: f64,
}

/// Those of offsets and of gains, from the slots that have an equation.
pub fn open_errors<'a>(prior: &SlowPrior, known: impl Iterator<Item = &'a SlowErrorsAt>) -> Vec<OpenError> {
    let mut sum = SMatrix::<f64, ERRORS, ERRORS>::zeros();
    let mut count = 0.0;
    for at in known {
        sum += at.covariance;
        count += 1.0;
    }
    let mut open = Vec::new();
    for (is_gain, first, size) in [(false, 0, prior.offset_mw), (true, SECTORS, prior.gain_percent)] {
        let eigen = (sum.fixed_view::<SECTORS, SECTORS>(first, first) / f64::max(count, 1.0)).symmetric_eigen();
        for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
            let deviation = value.max(0.0).sqrt();
            if size > 0.0 && deviation > OPEN * size {
                let alike = (SECTORS as f64).sqrt();
                open.push(OpenError {
                    is_common: vector.sum().abs() > COMMON * alike,
                    is_gain,
                    deviation: deviation / alike,
                });
            }
        }
    }
    open
}

impl fmt::Display for OpenError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (what, unit) = if self.is_gain { ("gains", "%") } else { ("heat", "mW") };
        let of = if self.is_common { "of all surfaces alike" } else { "other than alike" };
        write!(f, "{what} {of} (± {:.2} {unit})", self.deviation)
    }
}
