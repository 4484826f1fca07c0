//! Counters of a link: messages taken, and everything that was not one.

use serde::{Deserialize, Serialize};

/// What came over a link.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct LinkCounters {
    /// Messages taken.
    pub messages: u32,
    /// Frames dropped because they were damaged, cut short or garbage.
    pub damaged: u32,
    /// Frames dropped because they were longer than any frame is.
    pub oversized: u32,
    /// Frames that came twice in a row; the second one is dropped.
    pub repeated: u32,
    /// Messages that the sequence numbers say are missing.
    pub lost: u32,
    /// Frames of another protocol version.
    pub foreign: u32,
}
