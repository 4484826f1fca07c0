//! Observer of the states of a model: it estimates the heat stored in the structure of an element
//! from the measured temperature, tick by tick.
//!
//! A copy of the model that is driven by the heating power alone drifts away as soon as the wind
//! differs from the model's. Wind acts where heating acts (H_v = H_0 / (1 + ΔG H_0)), so the copy
//! is held on the temperature through its input:
//!
//! ```text
//! e = (T − T_ref) − Σ z_k,    w = ℓ e + s,    s ← s + μ ℓ e
//! x_k ← x_k + g_k (P + w − x_k),    z_k = R_k x_k
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | e | measured rise less that of the states | K |
//! | ℓ = 1 / (2 Σ R_k (1 − e^(−ξ_k (τ + Ts)))) | gain: a correction held for τ makes half of the error good | W/K |
//! | τ | 0.5 s | |
//! | s | what the error adds up to, so that none is left | W |
//! | μ = L / 4, L = Ts / (τ + Ts) | share that is added a tick; damped by 0.7 where the structure is slow | |
//! | −w | the power that another wind than the model's takes away | W |
//!
//! For ξ_k Ts ≪ 1 this is a correction of z along η/Γ. It is measured by the response after τ and
//! not by Γ, the slope at once: of a light chip on a heavy body the chip would take all of it, and
//! forget it by the next tick. The equivalent control of the states, u_eq = Σ ξ_k z_k / Γ (thesis
//! 2.49), is then the conduction into the structure, slow response included: equal to the mean
//! power in the model's wind, and the mean power less it is what any other wind takes.
//!
//! Limits: resistances must not be negative, and one must be greater than zero. Then the error dies
//! away at any sample period and any rates: e within some ten τ, but how the heat is shared out
//! among slow poles only as fast as the structure's own transmission zeros (the closed loop's time
//! constants) allow, since one temperature contains no more information: the initial state should
//! be near the truth. A relative error of the steady gain of the model appears as the same error of
//! u_eq. `+ − × ÷` on f32 in fixed order.

use super::mesh;
use super::sliding::equivalent_control;
use super::symbol::Symbol;
use crate::error::{self, ConfigError, Parameter, ParameterProblem};

/// τ: the time in which half of an error of the temperature is made good, s. Well above a tick, so
/// that reading noise is averaged; below the seconds in which a wind is to be seen.
pub const TIME_CONSTANT_S: f32 = 0.5;

/// Least response after τ, K/W: under it a gain would be beyond any power.
const LEAST_RESPONSE_K_PER_W: f64 = 1e-9;

/// Gains of an observer of K relaxations at a fixed sample period. Immutable.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
pub struct Observer<const K: usize> {
    rates_rad_s: [f32; K],
    high_frequency_gain_k_per_j: f32,
    /// ℓ
    gain_w_per_k: f32,
    /// μ ℓ
    adding_w_per_k: f32,
}

/// State of an observer, apart from the states of the model.
#[derive(Debug, Clone, Copy, PartialEq, Default, Fields!)]
pub struct ObserverState {
    /// s, W.
    pub added_w: f32,
}

/// Result of the observer at a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObservedPower {
    /// u_eq, W.
    pub equivalent_power_w: f32,
    /// w: to be added to the heating power until the next tick, W.
    pub correction_w: f32,
}

impl<const K: usize> Observer<K> {
    /// The observer of a symbol on a mesh.
    ///
    /// # Errors
    /// If a resistance is negative, or none is large enough for the temperature to respond within
    /// τ.
    pub fn new(rates_rad_s: &[f32; K], symbol: &Symbol<K>, sample_period_s: f32) -> Result<Self, ConfigError> {
        mesh::check(rates_rad_s)?;
        error::positive(Parameter::SamplePeriodS, sample_period_s)?;
        let within_s = f64::from(TIME_CONSTANT_S) + f64::from(sample_period_s);
        let mut response_k_per_w = 0.0;
        for (&r, &rate) in symbol.r_k_per_w().iter().zip(rates_rad_s) {
            error::within(Parameter::ResistanceKPerW, r, 0.0, 1e9)?;
            response_k_per_w += f64::from(r) * mesh::gain(f64::from(rate), within_s);
        }
        if response_k_per_w < LEAST_RESPONSE_K_PER_W {
            return Err(ConfigError { parameter: Parameter::ResistanceKPerW, problem: ParameterProblem::NotPositive });
        }
        let gain_w_per_k = 0.5 / response_k_per_w;
        Ok(Self {
            rates_rad_s: *rates_rad_s,
            high_frequency_gain_k_per_j: symbol.high_frequency_gain_k_per_j(rates_rad_s),
            gain_w_per_k: gain_w_per_k as f32,
            adding_w_per_k: (0.25 * f64::from(sample_period_s) / within_s * gain_w_per_k) as f32,
        })
    }

    /// Compares the rise by the states, `rise_k` with the shares `weighted_k` = z_k, with the
    /// measured rise. Without a measurement the correction stays constant.
    #[inline]
    pub fn estimate(
        &self,
        state: &mut ObserverState,
        weighted_k: &[f32; K],
        rise_k: f32,
        measured_rise_k: Option<f32>,
    ) -> ObservedPower {
        let error_k = measured_rise_k.map_or(0.0, |measured| measured - rise_k);
        let correction_w = self.gain_w_per_k * error_k + state.added_w;
        state.added_w += self.adding_w_per_k * error_k;
        let equivalent_power_w = equivalent_control(&self.rates_rad_s, weighted_k, self.high_frequency_gain_k_per_j);
        ObservedPower { equivalent_power_w, correction_w }
    }
}

#[cfg(test)]
mod tests;
