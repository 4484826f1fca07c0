//! One element's own diffusive model: heating power in, temperature out.
//!
//! T = T_ref + Σ R_k x_k, with the x_k driven by the element's heating power. The controller steps
//! it beside the element and judges set-points by it; order 8 at the most, the rest of the weights
//! being zero.

use super::observer::{ObservedPower, Observer, ObserverState};
use super::relaxation::{RelaxationState, Relaxations};
use super::sliding::{Reachability, reachability};
use super::symbol::{Symbol, pairwise_sum};
use crate::error::{self, ConfigError, Parameter};

/// Order of the models that the controller carries.
pub const ORDER: usize = 8;

/// A model as it travels and is stored: mesh, symbol and the temperature from which it counts.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SelfHeatingConfig {
    /// Relaxation rates ξ_k, rad/s, ascending.
    pub mesh_rad_s: [f32; ORDER],
    /// Resistances R_k, K/W.
    pub r_k_per_w: [f32; ORDER],
    /// Temperature of the element without heating, °C.
    pub reference_c: f32,
}

/// A model prepared for one sample period. Immutable.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
pub struct SelfHeating {
    mesh_rad_s: [f32; ORDER],
    sample_period_s: f32,
    relaxations: Relaxations<ORDER>,
    symbol: Symbol<ORDER>,
    reference_c: f32,
}

impl SelfHeating {
    /// Checks a model and works out its gains for `sample_period_s`.
    ///
    /// # Errors
    /// Names what is not finite, not positive or not ascending.
    pub fn new(config: &SelfHeatingConfig, sample_period_s: f32) -> Result<Self, ConfigError> {
        Ok(Self {
            mesh_rad_s: config.mesh_rad_s,
            sample_period_s,
            relaxations: Relaxations::new(&config.mesh_rad_s, sample_period_s)?,
            symbol: Symbol::new(config.r_k_per_w)?,
            reference_c: error::finite(Parameter::ReferenceC, config.reference_c)?,
        })
    }

    /// Flips a bit of its reference, for fault injection.
    #[cfg(any(test, feature = "bit-flips"))]
    pub(crate) fn flip_bit(&mut self, bit: u32) {
        self.reference_c = f32::from_bits(self.reference_c.to_bits() ^ 1 << (bit % 32));
    }

    /// One sample period under `power_w`.
    #[inline]
    pub fn step(&self, state: &mut RelaxationState<ORDER>, power_w: f32) {
        self.relaxations.step(state, power_w);
    }

    /// The temperature in °C that the states amount to.
    #[inline]
    pub fn temperature_c(&self, state: &RelaxationState<ORDER>) -> f32 {
        self.reference_c + self.symbol.output(state)
    }

    /// An observer of this model's states.
    ///
    /// # Errors
    /// If the model is none of a passive body: a resistance is negative, or all are zero.
    pub fn observer(&self) -> Result<Observer<ORDER>, ConfigError> {
        Observer::new(&self.mesh_rad_s, &self.symbol, self.sample_period_s)
    }

    /// The states of an element in steady state at `temperature_c`.
    pub fn in_balance(&self, temperature_c: f32) -> RelaxationState<ORDER> {
        let power_w = (temperature_c - self.reference_c) / self.symbol.steady_gain_k_per_w();
        RelaxationState { x: [power_w; ORDER], ..RelaxationState::default() }
    }

    /// Holds the states beside a measured temperature in °C, if there is one; to be called before
    /// the tick's [`step`](Self::step).
    #[inline]
    pub fn observe(
        &self,
        observer: &Observer<ORDER>,
        remembered: &mut ObserverState,
        state: &RelaxationState<ORDER>,
        measured_c: Option<f32>,
    ) -> ObservedPower {
        let weighted_k = self.symbol.weighted(state);
        let measured_rise_k = measured_c.map(|measured_c| measured_c - self.reference_c);
        observer.estimate(remembered, &weighted_k, pairwise_sum(weighted_k), measured_rise_k)
    }

    /// Tells whether `target_c` can be held between two levels in W.
    pub fn reachability(&self, target_c: f32, power_low_w: f32, power_high_w: f32) -> Reachability {
        reachability(self.symbol.steady_gain_k_per_w(), target_c - self.reference_c, power_low_w, power_high_w)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::mesh;

    fn config() -> SelfHeatingConfig {
        SelfHeatingConfig {
            mesh_rad_s: mesh::geometric(0.003, 30.0).unwrap(),
            r_k_per_w: [600.0, 20.0, 5.0, 2.0, 1.0, 0.0, 0.0, 0.0],
            reference_c: -50.0,
        }
    }

    #[test]
    fn rests_at_its_reference() {
        let model = SelfHeating::new(&config(), 0.01).unwrap();
        assert_eq!(model.temperature_c(&RelaxationState::default()), -50.0);
    }

    #[test]
    fn judges_set_points_from_its_reference() {
        let model = SelfHeating::new(&config(), 0.01).unwrap();
        assert!(matches!(model.reachability(-30.0, 0.0015, 0.04), Reachability::Reachable { .. }));
        assert!(matches!(model.reachability(-49.5, 0.0015, 0.04), Reachability::LowLevelTooWarm { .. }));
        assert!(matches!(model.reachability(0.0, 0.0015, 0.04), Reachability::HighLevelTooCold { .. }));
    }

    #[test]
    fn refuses_a_reference_that_is_no_temperature() {
        let bad = SelfHeatingConfig { reference_c: f32::INFINITY, ..config() };
        assert_eq!(SelfHeating::new(&bad, 0.01).unwrap_err().parameter, Parameter::ReferenceC);
    }
}
