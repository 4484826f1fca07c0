//! The checksums that an anemometer keeps of its settings, piece by piece.

use crate::checksum::Checksum;
use crate::model::convection_observer::config::{FASTER_ELEMENTS, MOST_PAIRS};

/// Pieces beside those of the network.
pub const OTHERS: usize = 3;

/// Checksums of all pieces.
#[derive(Debug, Clone, PartialEq)]
pub struct AnemometerChecksums<const N: usize> {
    own: [Checksum; N],
    others: [Checksum; MOST_PAIRS + FASTER_ELEMENTS + OTHERS],
    /// Set with the first command. Checksums in the constructor would make the compiler build the
    /// large value on the stack and copy it.
    pub are_set: bool,
}

impl<const N: usize> Default for AnemometerChecksums<N> {
    fn default() -> Self {
        Self {
            own: [Checksum::default(); N],
            others: [Checksum::default(); MOST_PAIRS + FASTER_ELEMENTS + OTHERS],
            are_set: false,
        }
    }
}

impl<const N: usize> AnemometerChecksums<N> {
    pub fn slot(&mut self, piece: usize) -> Option<&mut Checksum> {
        self.own.iter_mut().chain(&mut self.others).nth(piece)
    }

    pub fn get(&self, piece: usize) -> Option<Checksum> {
        self.own.get(piece).or_else(|| self.others.get(piece.checked_sub(N)?)).copied()
    }
}
