//! The board's supply falls and rises.

use super::Board;
use crate::adc::Adc;
use crate::complaint::BrokenRule;
use crate::soc::power::PROGRAMMING_MV;

impl Board {
    /// The processor's supply is this from now on, mV. While it is in reset by that, it stands
    /// still.
    pub fn set_supply(&mut self, supply_mv: u32) {
        let (was_low, was_held) = (self.power.is_low(), self.power.holds_reset());
        if let Some(source) = self.power.set_supply(supply_mv) {
            self.request_reset(source);
        }
        if was_held && !self.power.holds_reset() {
            self.adc = Adc::powered_at(self.now);
        }
        self.wire_detector(was_low);
        let (needed, set) = (self.power.wait_states(self.clocks.core_hz), self.flash.wait_states());
        if !self.power.holds_reset() && self.pending_reset.is_none() && set < needed {
            self.complaints.add(self.now, "VDD", BrokenRule::WaitStates { needed, set });
        }
        self.touch();
    }

    /// The detector's output on its line of EXTI.
    pub(super) fn wire_detector(&mut self, was_low: bool) {
        if self.power.is_low() != was_low {
            self.exti.supply_edge(self.power.is_low());
        }
        self.wire_lines();
    }

    /// The regulator's scale may not be enough for the core's clock.
    pub(super) fn check_scale(&mut self) {
        if self.clocks.core_hz > self.power.fastest_hz() {
            self.complaints.add(self.now, "PWR_CR", BrokenRule::VoltageScale);
        }
    }

    /// Something was just begun with the flash.
    pub(super) fn check_programming(&mut self) {
        if self.flash.busy_until() > self.now && self.power.supply_mv() < PROGRAMMING_MV {
            self.complaints.add(self.now, "VDD", BrokenRule::ProgrammingSupply);
        }
    }
}
