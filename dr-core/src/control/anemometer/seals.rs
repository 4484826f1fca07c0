//! What of an anemometer is sealed: all that it has been told. Its tables decide nothing, so they are looked at piece by piece, one a tick; a broken
//! seal trips the instrument all the same, since what it would tell of the wind could not be told from the truth.
//!
//! | piece | how many |
//! |---|---|
//! | an element of the network, a pair, a set of quicker gains | [`Network::PIECES`] |
//! | points, parts, gas law, as they were told | 1 |
//! | how it answers, with the head made ready | 1 |
//! | the gas as it was told | 1 |
//!
//! States, which change in every tick, are not sealed: what is upset there the network forgets, as it forgets any wrong beginning.

use super::{Anemometer, Answer};
use crate::model::Network;
use crate::model::network::{CROSSES, QUICK};
use crate::seal::{Seal, sealable};

/// Pieces beside those of the network.
const OTHERS: usize = 3;

/// Seals of all pieces.
#[derive(Debug, Clone, PartialEq)]
pub struct Seals<const N: usize> {
    own: [Seal; N],
    others: [Seal; CROSSES + QUICK + OTHERS],
    /// From the first thing on that it is told. Sealed at once, a new one would not be made in its place but copied there, and is large for a stack.
    are_set: bool,
}

impl<const N: usize> Default for Seals<N> {
    fn default() -> Self {
        Self { own: [Seal::default(); N], others: [Seal::default(); CROSSES + QUICK + OTHERS], are_set: false }
    }
}

impl<const N: usize> Seals<N> {
    fn slot(&mut self, piece: usize) -> Option<&mut Seal> {
        self.own.iter_mut().chain(&mut self.others).nth(piece)
    }

    fn get(&self, piece: usize) -> Option<Seal> {
        self.own.get(piece).or_else(|| self.others.get(piece.checked_sub(N)?)).copied()
    }
}

impl<const N: usize> Anemometer<N> {
    const PIECES: usize = Network::<N>::PIECES + OTHERS;

    /// Seals everything as it is now, which is right by what has just been checked.
    #[inline(never)]
    pub(super) fn seal_all(&mut self) {
        (0..Self::PIECES).for_each(|piece| self.seal_piece(piece));
        self.seals.are_set = true;
    }

    /// Seals what is told of the gas: at any time, so also where time counts.
    pub(super) fn seal_gas(&mut self) {
        if !self.seals.are_set {
            return self.seal_all();
        }
        self.seal_piece(Self::PIECES - 1);
    }

    fn seal_piece(&mut self, piece: usize) {
        let seal = self.seal_of(piece);
        if let Some(slot) = self.seals.slot(piece) {
            *slot = seal;
        }
    }

    /// Whether the piece whose turn it is in this tick is what it was told. Before anything has been told there is nothing to look at.
    pub fn is_whole_at(&self, tick: u32) -> bool {
        let piece = tick as usize % Self::PIECES;
        self.answer.is_none() || self.is_whole_in(piece)
    }

    /// Whether all of it is.
    pub fn is_whole(&self) -> bool {
        !self.seals.are_set || (0..Self::PIECES).all(|piece| self.is_whole_in(piece))
    }

    fn is_whole_in(&self, piece: usize) -> bool {
        self.seals.get(piece) == Some(self.seal_of(piece))
    }

    #[inline(never)] // in the image once
    fn seal_of(&self, piece: usize) -> Seal {
        match piece.checked_sub(Network::<N>::PIECES) {
            None => self.network.seal_of(piece),
            Some(0) => Seal::of(&self.setup),
            Some(1) => Seal::of(&self.answer),
            Some(_) => Seal::of(&(self.pressure_pa, self.told_gas_c)),
        }
    }
}

sealable!(Answer {
    config,
    head,
    gas_share,
    power_share,
    patience_ticks,
    reference_patience_ticks,
    saturated_ticks,
    starting_ticks,
});
