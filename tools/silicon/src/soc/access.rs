//! Circumstances of an access to a peripheral: the time, its clocks, and where to complain.

use crate::complaint::{BrokenRule, Complaints};

/// Frequencies of the buses, Hz; zero is a clock that has failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Clocks {
    /// Clock of the core and AHB.
    pub core_hz: u64,
    /// Clock of APB1.
    pub apb1_hz: u64,
    /// Clock of APB2.
    pub apb2_hz: u64,
    /// Clock of the timers on APB1.
    pub timers1_hz: u64,
}

/// An access to a register.
pub struct Access<'a> {
    /// When.
    pub now: u64,
    /// At which clocks.
    pub clocks: Clocks,
    /// Where to complain.
    pub complaints: &'a mut Complaints,
}

impl Access<'_> {
    /// The firmware breaks a rule.
    pub fn complain(&mut self, register: &'static str, rule: BrokenRule) {
        self.complaints.add(self.now, register, rule);
    }
}
