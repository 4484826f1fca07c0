//! Predicted power against what a loop took: both through the same decimator, edges left out.
//!
//! A bit stream is compared by its mean. Prediction and stream go through a sinc³ decimator of one window, so that what it delays and
//! smooths it does to both. An output counts if its whole response lies on the surface and in one wind: edges and reaching are left out.

use dr_core::signal::{Decimator, DecimatorState};

/// Moving averages in a row.
const ORDER: usize = 3;

/// How far apart they are.
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
pub type Row = (f64, f64, f64, bool);

/// Decimated powers at the middle of their windows.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Decimated {
    pub rows: Vec<Row>,
}

/// Decimates both by windows of `ratio` ticks. `good` tells ticks on the surface, `class` the wind of each.
///
/// # Errors
/// A sentence, if the window is too long or the stream is shorter than the prediction.
pub fn decimate(
    predicted_w: &[f64],
    taken_w: &[f64],
    good: &[bool],
    class: &[usize],
    ratio: usize,
    sample_period_s: f64,
) -> Result<Decimated, String> {
    let decimator = u32::try_from(ratio)
        .map_err(|error| error.to_string())
        .and_then(|ratio| Decimator::<ORDER>::new(ratio).map_err(|error| error.to_string()))
        .map_err(|error| format!("a window of {ratio} ticks cannot be used: {error}"))?;
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
