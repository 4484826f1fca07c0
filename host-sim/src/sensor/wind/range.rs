//! How a check of a wind refuses a number.

use crate::sensor::error::{SensorError, require};

/// No gust, sine or dust devil may add more than this, m/s.
pub(super) const HIGHEST_M_S: f64 = 100.0;

/// A table of an entry, as `wind[2].gust`.
#[derive(Clone, Copy)]
pub(super) struct EntryTable {
    pub entry: usize,
    /// Empty for the entry itself.
    pub name: &'static str,
}

impl EntryTable {
    /// Refuses a number of the table that is not right.
    pub(super) fn require(self, right: bool, key: &str, value: f64, expected: &str) -> Result<(), SensorError> {
        let dot = if self.name.is_empty() { "" } else { "." };
        require(right, &format!("wind[{}].{}{dot}{key}", self.entry, self.name), value, expected)
    }
}
