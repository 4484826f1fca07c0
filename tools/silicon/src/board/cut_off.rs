//! The cut-off of the platinum's supply, as `hardware/cut-off.cir` has it: the status LED's pin
//! holds the supply up by moving.

use crate::time::ms;

/// The supply stays at least as long after a rising edge, by the netlist's bounds.
pub const HOLDS: u64 = ms(1_050);
/// Rising edges that have it up at -40 °C.
const EDGES: u8 = 2;

/// State of the pin at the cut-off.
#[derive(Clone, Copy, Debug, Default)]
pub struct PlatinumSupply {
    is_high: bool,
    edges: u8,
    ends_at: u64,
}

impl PlatinumSupply {
    /// When it falls, if nothing moves.
    pub const fn next_event(&self) -> u64 {
        if self.edges == 0 { u64::MAX } else { self.ends_at }
    }

    /// The pin is now this; whether the supply is up.
    pub fn pass(&mut self, now: u64, is_high: bool) -> bool {
        if self.ends_at <= now {
            self.edges = 0;
        }
        if is_high && !self.is_high {
            self.edges = EDGES.min(self.edges + 1);
            self.ends_at = now + HOLDS;
        }
        self.is_high = is_high;
        self.edges == EDGES
    }
}
