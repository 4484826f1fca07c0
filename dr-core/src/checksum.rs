//! Checksums of settings and states: updated with every legitimate change, verified before the
//! values are used again.
//!
//! FNV-1a over 32-bit words with a state of 32 bit:
//!
//! ```text
//! s_0 = 0x811c9dc5,    s_(i+1) = (s_i ⊕ w_i) · 0x01000193 mod 2³²
//! ```
//!
//! The factor is odd, so s_i → s_(i+1) is one to one for a given w, and w → s_(i+1) for a given
//! s_i. A change within one word, of one bit or many, therefore always changes the checksum.
//! Changes of several words pass unseen with a probability of 2⁻³².
//!
//! The threat is a bit flip in memory, by radiation for instance. A flip between the verification
//! and the use passes unseen until the value is verified again.

use crate::fields::{FieldVisitor, Fields};

/// A running checksum.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Checksum(u32);

impl Default for Checksum {
    fn default() -> Self {
        Self(0x811c_9dc5)
    }
}

impl Checksum {
    /// The word that stands for it in memory.
    pub(crate) const fn word_of_it(self) -> u32 {
        self.0
    }

    /// The checksum of one value.
    pub(crate) fn of(what: &impl Fields) -> Self {
        let mut checksum = Self::default();
        what.visit(&mut checksum);
        checksum
    }
}

impl FieldVisitor for Checksum {
    #[inline]
    fn word(&mut self, word: u32) {
        self.0 = (self.0 ^ word).wrapping_mul(0x0100_0193);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bit_of_every_word_changes_it() {
        let words = [0_u32, 1, 0xffff_ffff, 0x3f80_0000, 0x1234_5678, 0];
        let of = |words: &[u32]| {
            let mut checksum = Checksum::default();
            words.iter().for_each(|&word| checksum.word(word));
            checksum
        };
        let whole = of(&words);
        for place in 0..words.len() {
            for bit in 0..32 {
                let mut flipped = words;
                flipped[place] ^= 1 << bit;
                assert_ne!(of(&flipped), whole, "word {place}, bit {bit}");
            }
        }
    }
}
