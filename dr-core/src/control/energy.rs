//! Energy budget of an element: a leaky bucket of its electrical energy.
//!
//! ```text
//! E_{n+1} = max(0, E_n + (P_n − P_sustained) T),   trip where E > E_max
//! ```
//!
//! The head states both numbers; the board has its own, and a head may be stricter only.
//!
//! So the energy of any time t is at most P_sustained t + E_max, and one tick more, whatever is
//! started, stopped, acknowledged or cleared meanwhile: only a reset of the processor empties it.
//! It drains while an element is configured, at the low level.
//!
//! Kept in whole nJ, since f32 would lose 1 µJ a tick beside 60 J, and compared in steps of 1 mJ,
//! which costs a tick least. A tick counts for 2.1 J at most.

use crate::error::{self, ConfigError, Parameter};
use crate::fields::{FieldVisitor, Fields};

const NJ_PER_J: f32 = 1e9;

/// 2²⁰ nJ, about 1 mJ, is a step in which budget and limit are compared.
const STEP_BITS: u32 = 20;

/// Energy that an element bears.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct EnergyLimit {
    /// Mean power that it may have for ever, W.
    pub sustained_power_w: f32,
    /// Energy that it may have beyond that, J.
    pub energy_j: f32,
}

impl EnergyLimit {
    /// The limit, if both numbers are finite and positive.
    pub(super) fn checked(self) -> Result<Self, ConfigError> {
        error::positive(Parameter::SustainedPowerW, self.sustained_power_w)?;
        error::positive(Parameter::EnergyJ, self.energy_j)?;
        Ok(self)
    }

    /// Refuses a limit that is laxer than the board's.
    pub(super) fn check_within(&self, board: &Self) -> Result<(), ConfigError> {
        error::within(Parameter::SustainedPowerW, self.sustained_power_w, 0.0, board.sustained_power_w)?;
        error::within(Parameter::EnergyJ, self.energy_j, 0.0, board.energy_j)?;
        Ok(())
    }

    /// The energy, in whole steps.
    fn most_steps(&self) -> u32 {
        (self.energy_j * (NJ_PER_J / (1 << STEP_BITS) as f32)) as u32
    }
}

/// Energy of one element beyond its sustained power.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct EnergyBudget {
    spent_nj: u64,
}

impl EnergyBudget {
    /// Counts a tick at a power.
    pub(super) fn spend(&mut self, power_w: f32, sample_period_s: f32, limit: &EnergyLimit) {
        let net_nj = ((power_w - limit.sustained_power_w) * sample_period_s * NJ_PER_J) as i32;
        self.spent_nj = self.spent_nj.saturating_add_signed(i64::from(net_nj));
    }

    /// Tells whether more is spent than is granted.
    pub(super) fn is_exceeded(self, limit: &EnergyLimit) -> bool {
        self.spent_nj >> STEP_BITS > u64::from(limit.most_steps())
    }

    /// The same, and no more than twice the limit: a flipped bit must not lock an element for ever.
    pub(super) fn at_most_double(self, limit: &EnergyLimit) -> Self {
        Self { spent_nj: self.spent_nj.min(u64::from(limit.most_steps()) << (STEP_BITS + 1)) }
    }
}

impl Fields for EnergyBudget {
    fn visit(&self, visitor: &mut impl FieldVisitor) {
        visitor.word(self.spent_nj as u32);
        visitor.word((self.spent_nj >> 32) as u32);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMIT: EnergyLimit = EnergyLimit { sustained_power_w: 0.03, energy_j: 2.0 };

    fn ticks_until_exceeded(power_w: f32, sample_period_s: f32) -> Option<u32> {
        let mut budget = EnergyBudget::default();
        (1..10_000_000).find(|_| {
            budget.spend(power_w, sample_period_s, &LIMIT);
            budget.is_exceeded(&LIMIT)
        })
    }

    #[test]
    fn the_time_at_a_power_is_the_energy_by_what_exceeds_the_sustained_power() {
        // 2 J by 10 mW: 200 s; a tick's energy is rounded by 1 nJ, of 1 µJ in the shortest tick.
        for sample_period_s in [1e-4_f32, 1e-3, 0.01, 1.0] {
            let expected = 200.0 / sample_period_s;
            let found = ticks_until_exceeded(0.04, sample_period_s).unwrap() as f32;
            assert!((found - expected).abs() < 1.0 + 1e-3 * expected, "{sample_period_s}: {found}");
        }
        assert_eq!(ticks_until_exceeded(0.03, 1.0), None);
        assert_eq!(ticks_until_exceeded(1e9, 10.0), Some(1), "and does not wrap");
    }

    #[test]
    fn it_drains_to_nothing_and_not_below() {
        let mut budget = EnergyBudget::default();
        (0..100).for_each(|_| budget.spend(0.001, 10.0, &LIMIT));
        assert_eq!(budget, EnergyBudget::default());
        budget.spend(0.04, 1.0, &LIMIT);
        assert_ne!(budget, EnergyBudget::default());
        budget.spend(0.019, 1.0, &LIMIT);
        assert_eq!(budget, EnergyBudget::default());
    }

    #[test]
    fn a_flipped_bit_does_not_lock_it_for_ever() {
        let flipped = EnergyBudget { spent_nj: 1 << 63 };
        assert!(flipped.is_exceeded(&LIMIT));
        let mut budget = flipped.at_most_double(&LIMIT);
        // 2 J at 30 mW.
        (0..67).for_each(|_| budget.spend(0.0, 1.0, &LIMIT));
        assert!(!budget.is_exceeded(&LIMIT));
    }
}
