//! The recommended loop, tried once on the model: sampled as it will be, one bit a tick, in f64.

use dr_core::model::mesh;

use crate::predict::analysis::LoopConditions;
use crate::predict::loop_model::LoopModel;
use crate::predict::sliding_surface::SlidingSurface;

/// Ticks of the trial at rest in the set-point, of which the first tenth is not counted.
const TICKS: u32 = 50_000;
/// A trial from rest that takes longer is given up.
const MOST_TICKS: u32 = 20_000_000;

/// Result of a trial.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct LoopTrial {
    /// Until the first reading at or above the set-point, from rest; `None` if that never came.
    pub reaching_time_s: Option<f64>,
    /// Once the states are those of u_Q, W.
    pub mean_power_w: f64,
    /// Swing of the readings, from peak to peak, K.
    pub swing_k: f64,
}

/// States of one element, stepped exactly.
struct SampledElement<'a> {
    surface: &'a SlidingSurface,
    gain: Vec<f64>,
    x: Vec<f64>,
}

impl<'a> SampledElement<'a> {
    fn new(surface: &'a SlidingSurface, power_w: f64, sample_period_s: f64) -> Self {
        let gain = surface.rates_rad_s.iter().map(|&rate| mesh::gain(rate, sample_period_s)).collect();
        Self { surface, gain, x: vec![power_w; surface.order()] }
    }

    fn rise_k(&self) -> f64 {
        self.x.iter().zip(&self.surface.r_k_per_w).map(|(x, r)| x * r).sum()
    }

    fn step(&mut self, power_w: f64) {
        self.x.iter_mut().zip(&self.gain).for_each(|(x, gain)| *x += gain * (power_w - *x));
    }
}

/// Tries a loop in one wind.
pub fn run(loop_model: &LoopModel, conditions: &LoopConditions) -> LoopTrial {
    let LoopConditions { target_c, power_low_w, power_high_w, sample_period_s } = *conditions;
    let (surface, rise_k) = (&loop_model.surface, target_c - loop_model.unheated_c);
    let mut body = SampledElement::new(surface, 0.0, sample_period_s);
    let mut ticks = 0;
    while body.rise_k() < rise_k && ticks < MOST_TICKS {
        body.step(power_high_w);
        ticks += 1;
    }
    let reaching_time_s = (ticks < MOST_TICKS).then(|| f64::from(ticks) * sample_period_s);

    let mut body = SampledElement::new(surface, rise_k / surface.steady_gain_k_per_w, sample_period_s);
    let (mut energy, mut counted, mut lowest_k, mut highest_k) = (0.0, 0.0, f64::INFINITY, f64::NEG_INFINITY);
    for tick in 0..TICKS {
        let reading_k = body.rise_k();
        let power_w = if reading_k < rise_k { power_high_w } else { power_low_w };
        if tick >= TICKS / 10 {
            (lowest_k, highest_k) = (reading_k.min(lowest_k), reading_k.max(highest_k));
            energy += power_w;
            counted += 1.0;
        }
        body.step(power_w);
    }
    LoopTrial { reaching_time_s, mean_power_w: energy / counted, swing_k: highest_k - lowest_k }
}
