//! Differences between the dice over the direction of the wind: (D_p, D_q) = −Re^n (P(θ), Q(θ)) +
//! (ε_p, ε_q) M, by linear least squares for every n, and the n that leaves least.

use dr_core::wind::card_inverse::TERMS;
use nalgebra::{DMatrix, DVector};

use super::drawn::CardWind;

/// Harmonics, exponent and inequality of the dice.
pub struct DieDifferences {
    /// P, cosines from the zeroth on.
    pub along: [f64; TERMS],
    /// Q, sines from the first on.
    pub around: [f64; TERMS],
    /// n
    pub exponent: f64,
    /// ε_p, ε_q
    pub unlike: [f64; 2],
    /// Residuals over the size of the differences, rms.
    pub share: f64,
}

/// Fits the differences; none if the equations have no solution.
pub fn differences(winds: &[CardWind]) -> Option<DieDifferences> {
    let solved = |exponent: f64, k: usize| {
        let of = |n: usize, angle: f64| match k {
            0 => (n as f64 * angle).cos(),
            _ => ((n + 1) as f64 * angle).sin(),
        };
        let size = |wind: &CardWind| wind.root.powf(2.0 * exponent);
        let design = DMatrix::from_fn(winds.len(), TERMS + 1, |at, n| {
            let wind = &winds[at];
            if n < TERMS { of(n, wind.angle) } else { -wind.mean / size(wind) }
        });
        let wanted = DVector::from_fn(winds.len(), |at, _| -winds[at].differences[k] / size(&winds[at]));
        let found = design.clone().svd(true, true).solve(&wanted, 1e-12).ok()?;
        let left = (&design * &found - wanted).norm_squared();
        Some((found, left))
    };
    let both = |exponent: f64| Some((solved(exponent, 0)?, solved(exponent, 1)?));
    let left = |exponent: f64| both(exponent).map_or(f64::INFINITY, |(along, around)| along.1 + around.1);
    let exponent = (0..=100).map(|n| 0.25 + 0.005 * f64::from(n)).min_by(|&a, &b| left(a).total_cmp(&left(b)))?;
    let ((along, along_left), (around, around_left)) = both(exponent)?;
    let terms = |of: &DVector<f64>| std::array::from_fn(|n| of[n]);
    let (along_terms, around_terms): ([f64; TERMS], [f64; TERMS]) = (terms(&along), terms(&around));
    let size2: f64 = winds
        .iter()
        .map(|wind| {
            let sum = |of: &[f64; TERMS], f: fn(f64) -> f64, first: usize| {
                of.iter().enumerate().map(|(n, a)| a * f((n + first) as f64 * wind.angle)).sum::<f64>()
            };
            sum(&along_terms, f64::cos, 0).powi(2) + sum(&around_terms, f64::sin, 1).powi(2)
        })
        .sum();
    // Of one component beside the size of both; two components a wind less what was fitted to them.
    let free = (2 * winds.len()).saturating_sub(2 * TERMS + 3).max(1) as f64;
    let share = ((along_left + around_left) / free / (size2 / winds.len() as f64)).sqrt();
    Some(DieDifferences {
        along: along_terms,
        around: around_terms,
        exponent,
        unlike: [along[TERMS], around[TERMS]],
        share,
    })
}
