//! The time-constant spectrum (diffusive symbol): the weights that turn relaxations into a
//! temperature.
//!
//! y = Σ R_k x_k  with R_k = η_k/ξ_k in K/W (thesis 2.10 in normalised states). The model is then a
//! Foster network with resistances R_k and capacitances 1/η_k.
//!
//! | quantity | definition | unit |
//! |---|---|---|
//! | steady gain | Σ R_k | K/W |
//! | high-frequency gain Γ | Σ R_k ξ_k | K/J |
//! | continuous symbol | η(ξ_k) = η_k / (ln(r) ξ_k) = R_k / ln r (thesis 2.18) | K/W |

use super::relaxation::RelaxationState;
use crate::error::{self, ConfigError, Parameter};

/// Weights R_k in K/W of K relaxations.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
pub struct Symbol<const K: usize> {
    r_k_per_w: [f32; K],
}

impl<const K: usize> Symbol<K> {
    /// A symbol from its resistances in K/W. They may be negative: cross-heating needs that.
    ///
    /// # Errors
    /// If one is not finite, or beyond ±10⁹ K/W: no state can then make the output overflow.
    pub fn new(r_k_per_w: [f32; K]) -> Result<Self, ConfigError> {
        for r in r_k_per_w {
            error::within(Parameter::ResistanceKPerW, r, -1e9, 1e9)?;
        }
        Ok(Self { r_k_per_w })
    }

    /// The resistances R_k, K/W.
    pub const fn r_k_per_w(&self) -> &[f32; K] {
        &self.r_k_per_w
    }

    /// The temperature rise in K that the states amount to.
    #[inline]
    pub fn output(&self, state: &RelaxationState<K>) -> f32 {
        pairwise_sum(self.weighted(state))
    }

    /// The share z_k = R_k x_k of each state in that rise, K.
    #[inline]
    pub fn weighted(&self, state: &RelaxationState<K>) -> [f32; K] {
        core::array::from_fn(|k| self.r_k_per_w[k] * state.x[k])
    }

    /// Σ R_k, K/W: the rise that one watt ends in.
    pub fn steady_gain_k_per_w(&self) -> f32 {
        pairwise_sum(self.r_k_per_w)
    }

    /// Γ = Σ R_k ξ_k, K/J: the slope that one watt begins with.
    pub fn high_frequency_gain_k_per_j(&self, rates_rad_s: &[f32; K]) -> f32 {
        pairwise_sum::<K>(core::array::from_fn(|k| self.r_k_per_w[k] * rates_rad_s[k]))
    }
}

/// The sum in a fixed order, by halves: it loses less than a running sum, and neighbours do not
/// wait for each other.
#[inline]
pub(super) fn pairwise_sum<const K: usize>(mut terms: [f32; K]) -> f32 {
    let mut length = K;
    while length > 1 {
        let half = length / 2;
        for k in 0..half {
            terms[k] = terms[2 * k] + terms[2 * k + 1];
        }
        if length % 2 == 1 {
            terms[half] = terms[length - 1];
        }
        length = half + length % 2;
    }
    if K == 0 { 0.0 } else { terms[0] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::mesh;
    use crate::model::relaxation::Relaxations;

    #[test]
    fn a_held_power_ends_at_the_steady_gain() {
        let rates = mesh::geometric::<8>(0.1, 100.0).unwrap();
        let relaxations = Relaxations::new(&rates, 0.05).unwrap();
        let symbol = Symbol::new([40.0, 30.0, 20.0, 10.0, 5.0, 2.0, 1.0, 0.5]).unwrap();
        let mut state = RelaxationState::default();
        for _ in 0..10_000 {
            relaxations.step(&mut state, 0.04);
        }
        // 50 slowest time constants: what is left is rounding, a few units of 4.34 K
        assert!((symbol.output(&state) - 0.04 * symbol.steady_gain_k_per_w()).abs() < 2e-6);
        assert_eq!(symbol.steady_gain_k_per_w(), 108.5);
    }

    #[test]
    fn the_first_instant_rises_with_the_high_frequency_gain() {
        let rates = [0.5, 4.0, 30.0];
        let symbol = Symbol::new([10.0, 3.0, 1.0]).unwrap();
        let period_s = 1e-5;
        let relaxations = Relaxations::new(&rates, period_s).unwrap();
        let mut state = RelaxationState::default();
        relaxations.step(&mut state, 1.0);
        let slope = symbol.output(&state) / period_s;
        // relative error of the order ξ_K Ts / 2
        assert!((slope / symbol.high_frequency_gain_k_per_j(&rates) - 1.0).abs() < 2e-4);
    }

    #[test]
    fn sums_any_number_of_terms() {
        assert_eq!(pairwise_sum::<0>([]), 0.0);
        assert_eq!(pairwise_sum([7.0]), 7.0);
        assert_eq!(pairwise_sum([1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0]), 127.0);
    }

    #[test]
    fn refuses_a_weight_that_is_no_number() {
        assert!(Symbol::new([1.0, f32::NAN]).is_err());
        assert!(Symbol::new([1.0, -1e30]).is_err());
    }
}
