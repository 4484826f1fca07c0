//! The checksums that a controller keeps of its own memory.

use crate::checksum::Checksum;

/// Checksums of a controller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControllerChecksums<const N: usize> {
    /// Of the settings that are verified in every tick.
    pub settings: Checksum,
    /// Of the states that are verified in every tick.
    pub states: Checksum,
    /// Of each element's drive, model and observer.
    pub elements: [Checksum; N],
}

impl<const N: usize> Default for ControllerChecksums<N> {
    /// Checksums of nothing.
    fn default() -> Self {
        Self { settings: Checksum::default(), states: Checksum::default(), elements: [Checksum::default(); N] }
    }
}
