//! Predicted power against what a loop took: both through the same decimator, edges left out.
//!
//! A bit stream is compared by its mean. Prediction and stream go through a sinc³ decimator of one
//! window, so that what it delays and smooths it does to both. An output counts if its whole
//! response lies on the surface and in one wind: edges and reaching are left out.

use dr_core::signal::{Decimator, DecimatorState};

use crate::model::ModelError;

/// Moving averages in a row.
const ORDER: usize = 3;

/// Tells whether the decimator can take windows of so many ticks.
pub fn fits(ratio: usize) -> bool {
    u32::try_from(ratio).is_ok_and(|ratio| Decimator::<ORDER>::new(ratio).is_ok())
}

/// Distance between them.
#[derive(Debug, Clone, PartialEq)]
pub struct Compared {
    /// Mean of the stream, W.
    pub mean_w: f64,
    /// Root mean square of stream minus prediction, W.
    pub rms_w: f64,
    /// Mean of stream minus prediction, W.
    pub bias_w: f64,
    /// Outputs that were compared.
    pub count: usize,
}

/// (time in s, predicted in W, taken in W, counts)
pub type DecimatedRow = (f64, f64, f64, bool);

/// Decimated powers at the middle of their windows.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Decimated {
    /// One a window.
    pub rows: Vec<DecimatedRow>,
}

/// Decimates both by windows of `ratio` ticks. `good` tells ticks on the surface, `class` the wind
/// of each.
///
/// # Errors
/// If the window is too long or the stream is shorter than the prediction.
pub fn decimate(
    predicted_w: &[f64],
    taken_w: &[f64],
    good: &[bool],
    class: &[usize],
    ratio: usize,
    sample_period_s: f64,
) -> Result<Decimated, ModelError> {
    let unusable = |error: &dyn std::fmt::Display| model_error!("a window of {ratio} ticks cannot be used: {error}");
    let ticks = u32::try_from(ratio).map_err(|error| unusable(&error))?;
    let decimator = Decimator::<ORDER>::new(ticks).map_err(|error| unusable(&error))?;
    // The decimator counts in steps for watts; any other unit is brought to that size.
    let scale = predicted_w.iter().chain(taken_w).fold(0.0_f64, |most, w| most.max(w.abs()));
    let scale = if scale > 0.0 { scale } else { 1.0 };
    let (mut one, mut other) = (DecimatorState::default(), DecimatorState::default());
    let length = ORDER * (ratio - 1) + 1;
    let mut clean = 0;
    let mut decimated = Decimated::default();
    let rows = predicted_w.iter().zip(taken_w).zip(good).zip(class).enumerate();
    for (tick, (((predicted, taken), good), own)) in rows {
        let edge = tick > 0 && class[tick - 1] != *own;
        clean = if !good {
            0
        } else if edge {
            1
        } else {
            clean + 1
        };
        let predicted = decimator.push(&mut one, (predicted / scale) as f32);
        let taken = decimator.push(&mut other, (taken / scale) as f32);
        if let (Some(predicted), Some(taken)) = (predicted, taken) {
            let time_s = (tick as f64 - f64::from(decimator.delay_ticks())) * sample_period_s;
            decimated.rows.push((time_s, scale * f64::from(predicted), scale * f64::from(taken), clean >= length));
        }
    }
    Ok(decimated)
}

impl Decimated {
    /// `None` where no output counts.
    pub fn compare(&self) -> Option<Compared> {
        let counted: Vec<(f64, f64)> = self
            .rows
            .iter()
            .filter(|(.., counts)| *counts)
            .map(|(_, predicted, taken, _)| (*predicted, *taken))
            .collect();
        if counted.is_empty() {
            return None;
        }
        let count = counted.len();
        let mean = |of: &dyn Fn(f64, f64) -> f64| counted.iter().map(|(p, t)| of(*p, *t)).sum::<f64>() / count as f64;
        Some(Compared {
            mean_w: mean(&|_, taken| taken),
            rms_w: mean(&|predicted, taken| (taken - predicted).powi(2)).sqrt(),
            bias_w: mean(&|predicted, taken| taken - predicted),
            count,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_taken_beyond_the_prediction_is_bias_and_the_rest_is_rms() {
        // ±1 mW around a bias of 0.5 mW, in stretches that the decimator lets through.
        let taken: Vec<f64> = (0..4000).map(|n| 0.0205 + if (n / 1000) % 2 == 0 { 1e-3 } else { -1e-3 }).collect();
        let class: Vec<usize> = (0..4000).map(|n| n / 1000).collect();
        let compared = decimate(&[0.02; 4000], &taken, &[true; 4000], &class, 20, 0.01).unwrap().compare().unwrap();
        // 50 outputs a wind, of which the first whole response ends after 58 ticks.
        assert_eq!(compared.count, 4 * 48);
        assert!((compared.bias_w - 5e-4).abs() < 1e-8 && (compared.mean_w - 0.0205).abs() < 1e-8, "{compared:?}");
        assert!((compared.rms_w - (1e-6_f64 + 0.25e-6).sqrt()).abs() < 1e-8, "{compared:?}");
    }

    #[test]
    fn edges_and_ways_to_the_set_point_are_left_out() {
        let mut taken = vec![0.02; 3000];
        // Before the surface is met, and right after the wind has changed.
        taken[..200].fill(5.0);
        taken[1000..1001].fill(5.0);
        let good: Vec<bool> = (0..3000).map(|n| n >= 200).collect();
        let class: Vec<usize> = (0..3000).map(|n| usize::from(n >= 1001)).collect();
        let decimated = decimate(&[0.02; 3000], &taken, &good, &class, 20, 0.01).unwrap();
        let compared = decimated.compare().unwrap();
        // The tick at 1000 is the last of its wind: outputs after it begin anew.
        assert!(compared.rms_w < 1e-8 && compared.count > 100, "{compared:?}");
        assert!(decimated.rows.iter().any(|(_, _, taken, counts)| *taken > 0.1 && !counts));
    }

    #[test]
    fn where_nothing_counts_nothing_is_compared() {
        let never = decimate(&[0.02; 500], &[0.02; 500], &[false; 500], &[0; 500], 20, 0.01).unwrap();
        // The first two of 25 outputs are of a decimator that is not full yet.
        assert_eq!((never.rows.len(), never.compare()), (23, None));
        let short = decimate(&[0.02; 10], &[0.02; 10], &[true; 10], &[0; 10], 20, 0.01).unwrap();
        assert_eq!(short, Decimated::default());
        assert!(
            decimate(&[0.02; 10], &[0.02; 10], &[true; 10], &[0; 10], 0, 0.01)
                .unwrap_err()
                .to_string()
                .contains("0 ticks")
        );
    }
}
