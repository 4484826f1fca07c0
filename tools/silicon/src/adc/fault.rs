//! Faults of the converter.

/// A fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AdcFault {
    /// No more data-ready; it answers as before.
    Silent,
    /// Conversions come, and all are what the last one was.
    Stuck,
    /// Its data line carries random bytes.
    Garbage,
    /// Its inputs are at the lower end of their range.
    LowEnd,
    /// Its data line is at one level: all ones.
    Dead,
}
