//! What a head's file comes to for one of its elements.

use serde::Serialize;

/// One element.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ElementCheck {
    /// Its name.
    pub name: String,
    /// Whether it is held at the set-point; else it only senses.
    pub held: bool,
    /// Rise by a watt of its own in quiescent gas, K/W.
    pub own_gain_k_per_w: f64,
    /// The same at 3 m/s, K/W.
    pub own_gain_in_wind_k_per_w: f64,
    /// Heat capacity of the node that it heats, J/K.
    pub capacity_j_k: f64,
    /// Power of either level at the set-point, W.
    pub level_w: [f64; 2],
}

impl ElementCheck {
    /// By how much a tick at the high level, in place of the low one, heats it: what its node
    /// stores of it, but no more than the whole structure would rise, K.
    pub fn tick_rise_k(&self, sample_period_s: f64) -> f64 {
        let step_w = self.level_w[1] - self.level_w[0];
        step_w * (sample_period_s / self.capacity_j_k).min(self.own_gain_k_per_w)
    }
}
