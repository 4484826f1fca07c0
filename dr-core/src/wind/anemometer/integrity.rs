//! Integrity check of the anemometer's settings.
//!
//! The tables decide nothing, so one piece is verified per tick, in turn. A failed checksum trips
//! the instrument, since a wrong estimate could not be distinguished from a right one.
//!
//! | piece | number |
//! |---|---|
//! | an element of the network, two pairs of elements, a set of faster gains | [`ConvectionObserver::PIECES`] |
//! | Nusselt points, surfaces, gas law, as they were set | 1 |
//! | output settings, with the prepared inverse of the head | 1 |
//! | the given pressure and temperature of the gas, corrections of surfaces | 1 |
//!
//! States change in every tick and have no checksum: the network forgets a flipped bit as it
//! forgets a wrong initial state.

use super::{Anemometer, MOST_PIECES, OTHER_PIECES};
use crate::checksum::Checksum;
use crate::model::convection_observer::ConvectionObserver;

impl<const N: usize> Anemometer<N> {
    const PIECES: usize = ConvectionObserver::<N>::PIECES + OTHER_PIECES;

    /// Updates all checksums to what is there now, which is right by what has just been checked.
    #[inline(never)]
    pub(super) fn update_checksums(&mut self) {
        self.checksums.get_or_insert([Checksum::default(); MOST_PIECES]);
        (0..Self::PIECES).for_each(|piece| self.update_piece_checksum(piece));
    }

    /// Updates the checksum of what is given while running: the gas, and corrections off line.
    pub(super) fn update_given_checksum(&mut self) {
        if self.checksums.is_none() {
            return self.update_checksums();
        }
        self.update_piece_checksum(Self::PIECES - 1);
    }

    fn update_piece_checksum(&mut self, piece: usize) {
        let checksum = self.piece_checksum(piece);
        if let Some(slot) = self.checksums.as_mut().and_then(|all| all.get_mut(piece)) {
            *slot = checksum;
        }
    }

    /// Tells whether the piece whose turn it is in this tick is intact. Before the set-up there is
    /// nothing to verify.
    pub fn is_intact_at(&self, tick: u32) -> bool {
        let piece = tick as usize % Self::PIECES;
        self.output.is_none() || self.is_intact_in(piece)
    }

    /// Tells whether all pieces are intact.
    pub fn is_whole(&self) -> bool {
        self.checksums.is_none() || (0..Self::PIECES).all(|piece| self.is_intact_in(piece))
    }

    fn is_intact_in(&self, piece: usize) -> bool {
        self.checksums.as_ref().and_then(|all| all.get(piece)) == Some(&self.piece_checksum(piece))
    }

    /// Flips a bit of a setting, for tests.
    #[cfg(test)]
    pub fn flip_a_setting(&mut self) {
        self.pressure_pa = self.pressure_pa.map(|of| f32::from_bits(of.to_bits() ^ 1));
    }

    #[inline(never)] // in the image once
    fn piece_checksum(&self, piece: usize) -> Checksum {
        match piece.checked_sub(ConvectionObserver::<N>::PIECES) {
            None => self.network.piece_checksum(piece),
            Some(0) => Checksum::of(&self.setup),
            Some(1) => Checksum::of(&self.output),
            Some(_) => Checksum::of(&((self.pressure_pa, self.given_gas_c), self.corrections)),
        }
    }
}
