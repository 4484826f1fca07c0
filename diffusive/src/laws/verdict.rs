//! Which forecasts differ by more than noise.
//!
//! ```text
//! d_j = mean over block j of (e² − e_best²),    within noise: mean d ≤ 2 s_d/√B
//! ```
//!
//! The held-out rows are cut into B blocks of like length, so that errors that hang together do not
//! count as many. The noise of the output is in both errors, and nearly cancels in their
//! difference.

use crate::identify::folds::{FOLDS, mean_and_sd};

/// Standard errors within which two are alike.
const WITHIN: f64 = 2.0;

/// Mean squared errors by block; rows without an error are left out.
pub fn block_errors(measured: &[f64], predicted: &[f64]) -> Vec<f64> {
    let rows = measured.len().min(predicted.len());
    let block = |j: usize| {
        let rows = j * rows / FOLDS..(j + 1) * rows / FOLDS;
        let errors = measured[rows.clone()].iter().zip(&predicted[rows]).map(|(y, p)| (y - p).powi(2));
        let (sum, count) = errors.filter(|e| !e.is_nan()).fold((0.0, 0.0), |(sum, count), e| (sum + e, count + 1.0));
        sum / count
    };
    (0..FOLDS).map(block).filter(|mean: &f64| !mean.is_nan()).collect()
}

/// Whether the errors of one are within the noise of the best.
pub fn is_within_noise(errors: &[f64], best: &[f64]) -> bool {
    let (mean, sd) = mean_and_sd(errors.iter().zip(best).map(|(own, best)| own - best));
    mean <= WITHIN * sd / (errors.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bias_is_beyond_the_noise_and_a_lucky_block_is_not() {
        let noise = |n: usize| ((n * 7919) % 1009) as f64 / 1009.0 - 0.5;
        let measured: Vec<f64> = (0..5000).map(noise).collect();
        let (truth, biased) = (vec![0.0; 5000], vec![0.2; 5000]);
        let lucky: Vec<f64> = (0..5000).map(|n| if n < 500 { -0.2 } else { 0.0 }).collect();
        let best = block_errors(&measured, &truth);
        assert!(!is_within_noise(&block_errors(&measured, &biased), &best));
        assert!(is_within_noise(&block_errors(&measured, &lucky), &best));
        assert!(is_within_noise(&best, &best));
    }
}
