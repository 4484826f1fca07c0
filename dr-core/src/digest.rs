//! A running digest of a run, to show that two instruments did the same: FNV-1a over 32-bit words,
//! 64-bit state.
//!
//! It neither protects against damage (frames have a CRC) nor against intent. A NaN must not enter
//! it: its sign is not defined.

use crate::fields::FieldVisitor;

/// A running FNV-1a digest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Digest(u64);

/// Digests of a run: of all that was decided, and of all that was estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RunDigests {
    /// Digest of the controller after each tick.
    pub control: Digest,
    /// Digest of the anemometer after each tick.
    pub wind: Digest,
}

impl Default for Digest {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Digest {
    /// The digest so far.
    pub const fn value(&self) -> u64 {
        self.0
    }

    /// A digest of which this is the value.
    pub const fn of_value(value: u64) -> Self {
        Self(value)
    }
}

impl FieldVisitor for Digest {
    #[inline]
    fn word(&mut self, word: u32) {
        self.0 = (self.0 ^ u64::from(word)).wrapping_mul(0x0000_0100_0000_01b3);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fields::Fields;

    #[test]
    fn a_single_bit_or_a_swap_changes_it() {
        let of = |words: &[f32]| {
            let mut digest = Digest::default();
            words.iter().for_each(|&w| w.visit(&mut digest));
            digest.value()
        };
        assert_ne!(of(&[1.0, 2.0]), of(&[2.0, 1.0]));
        assert_ne!(of(&[0.0]), of(&[-0.0]));
        assert_ne!(of(&[1.0]), of(&[f32::from_bits(1.0_f32.to_bits() + 1)]));
    }
}
