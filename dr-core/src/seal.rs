//! Seals: what decides about heaters is sealed whenever it is rightly changed, and held against its seal before it is used again.
//!
//! FNV-1a over 32-bit words with a state of 32 bit:
//!
//! ```text
//! s_0 = 0x811c9dc5,    s_(i+1) = (s_i ⊕ w_i) · 0x01000193 mod 2³²
//! ```
//!
//! For a given w, s_i → s_(i+1) is one to one, the factor being odd; and so is w → s_(i+1) for a given s_i. So a change within one word, of
//! one bit or many, always changes the seal. Changes of several words go unseen once in 2³².
//!
//! Memory may be upset by radiation. What a seal cannot see is an upset between the look and the use; of what decides it is looked at in every
//! tick, so that lasts until the next one.

/// A running seal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Seal(u32);

impl Default for Seal {
    fn default() -> Self {
        Self(0x811c_9dc5)
    }
}

impl Seal {
    /// Of one thing.
    pub(crate) fn of(what: &impl Sealable) -> Self {
        let mut seal = Self::default();
        what.seal_into(&mut seal);
        seal
    }

    /// Takes in one word.
    #[inline]
    pub(crate) fn word(&mut self, word: u32) {
        self.0 = (self.0 ^ word).wrapping_mul(0x0100_0193);
    }

    /// Takes in the bits of a number.
    #[inline]
    pub(crate) fn number(&mut self, number: f32) {
        self.word(number.to_bits());
    }

    /// Takes in a list of numbers.
    #[inline]
    pub(crate) fn numbers(&mut self, numbers: &[f32]) {
        numbers.iter().for_each(|&number| self.number(number));
    }
}

/// What can be taken into a seal whole.
pub(crate) trait Sealable {
    /// All of it, in a fixed order.
    fn seal_into(&self, seal: &mut Seal);

    /// Many of them.
    fn seal_each(all: &[Self], seal: &mut Seal)
    where
        Self: Sized,
    {
        all.iter().for_each(|one| one.seal_into(seal));
    }
}

/// All fields of a struct; one that is forgotten does not compile.
macro_rules! sealable {
    ($(@[$($generics:tt)*])? $type:ty { $($field:ident),* $(,)? }) => {
        impl$(<$($generics)*>)? $crate::seal::Sealable for $type {
            fn seal_into(&self, seal: &mut $crate::seal::Seal) {
                let Self { $($field),* } = self;
                $($crate::seal::Sealable::seal_into($field, seal);)*
            }
        }
    };
}
pub(crate) use sealable;

impl Sealable for f32 {
    fn seal_into(&self, seal: &mut Seal) {
        seal.number(*self);
    }

    #[inline(never)] // one loop for all tables
    fn seal_each(all: &[Self], seal: &mut Seal) {
        seal.numbers(all);
    }
}

impl Sealable for u32 {
    fn seal_into(&self, seal: &mut Seal) {
        seal.word(*self);
    }
}

impl Sealable for u16 {
    fn seal_into(&self, seal: &mut Seal) {
        seal.word(u32::from(*self));
    }
}

impl Sealable for u8 {
    fn seal_into(&self, seal: &mut Seal) {
        seal.word(u32::from(*self));
    }
}

impl Sealable for usize {
    fn seal_into(&self, seal: &mut Seal) {
        seal.word(*self as u32);
    }
}

impl<T: Sealable, const N: usize> Sealable for [T; N] {
    fn seal_into(&self, seal: &mut Seal) {
        T::seal_each(self, seal);
    }
}

impl<T: Sealable> Sealable for Option<T> {
    fn seal_into(&self, seal: &mut Seal) {
        seal.word(u32::from(self.is_some()));
        if let Some(inside) = self {
            inside.seal_into(seal);
        }
    }
}

impl<A: Sealable, B: Sealable> Sealable for (A, B) {
    fn seal_into(&self, seal: &mut Seal) {
        self.0.seal_into(seal);
        self.1.seal_into(seal);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bit_of_every_word_changes_it() {
        let words = [0_u32, 1, 0xffff_ffff, 0x3f80_0000, 0x1234_5678, 0];
        let of = |words: &[u32]| {
            let mut seal = Seal::default();
            words.iter().for_each(|&word| seal.word(word));
            seal
        };
        let whole = of(&words);
        for place in 0..words.len() {
            for bit in 0..32 {
                let mut upset = words;
                upset[place] ^= 1 << bit;
                assert_ne!(of(&upset), whole, "word {place}, bit {bit}");
            }
        }
    }
}
