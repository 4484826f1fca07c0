//! Pseudo-random binary sequences from an n-bit Fibonacci shift register with XNOR feedback, n = 2
//! … 32.
//!
//! Period 2ⁿ − 1. All zeros is a legal seed, all ones the lock-up state. With ω_p the bit clock,
//! the band in which the sequence is as good as white is ω_p/(2ⁿ−1) ≤ ω ≤ ω_p/2.3 (thesis 2.5).
//! Taps: P. Alfke, Xilinx XAPP052, table 3.

use crate::error::{self, ConfigError, Parameter, ParameterProblem};

/// Least and greatest register length.
pub const ORDERS: core::ops::RangeInclusive<u8> = 2..=32;

/// Feedback taps for n = 2 … 32: bit i set means stage i + 1 (the output is stage n).
const TAPS: [u32; 31] = [
    stages([2, 1, 0, 0]),
    stages([3, 2, 0, 0]),
    stages([4, 3, 0, 0]),
    stages([5, 3, 0, 0]),
    stages([6, 5, 0, 0]),
    stages([7, 6, 0, 0]),
    stages([8, 6, 5, 4]),
    stages([9, 5, 0, 0]),
    stages([10, 7, 0, 0]),
    stages([11, 9, 0, 0]),
    stages([12, 6, 4, 1]),
    stages([13, 4, 3, 1]),
    stages([14, 5, 3, 1]),
    stages([15, 14, 0, 0]),
    stages([16, 15, 13, 4]),
    stages([17, 14, 0, 0]),
    stages([18, 11, 0, 0]),
    stages([19, 6, 2, 1]),
    stages([20, 17, 0, 0]),
    stages([21, 19, 0, 0]),
    stages([22, 21, 0, 0]),
    stages([23, 18, 0, 0]),
    stages([24, 23, 22, 17]),
    stages([25, 22, 0, 0]),
    stages([26, 6, 2, 1]),
    stages([27, 5, 2, 1]),
    stages([28, 25, 0, 0]),
    stages([29, 27, 0, 0]),
    stages([30, 6, 4, 1]),
    stages([31, 28, 0, 0]),
    stages([32, 22, 2, 1]),
];

/// A word with the named stages set; 0 stands for no stage.
const fn stages(list: [u32; 4]) -> u32 {
    let mut word = 0;
    let mut i = 0;
    while i < list.len() {
        if list[i] > 0 {
            word |= 1 << (list[i] - 1);
        }
        i += 1;
    }
    word
}

/// A running generator: its register, and the two words that make it an n-bit one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Fields!)]
pub struct Prbs {
    register: u32,
    mask: u32,
    taps: u32,
}

impl Prbs {
    /// An n-bit generator that starts from the low n bits of `seed`.
    ///
    /// # Errors
    /// If the order is not 2 … 32, or the seed has bits above the n-th, or is the lock-up word of n
    /// ones.
    pub fn new(order: u8, seed: u32) -> Result<Self, ConfigError> {
        let taps = order.checked_sub(*ORDERS.start()).and_then(|index| TAPS.get(usize::from(index)));
        let taps = *taps.ok_or(error::out_of_range(Parameter::PrbsOrder, 2.0, 32.0))?;
        let mask = u32::MAX >> (32 - u32::from(order));
        if seed > mask {
            return Err(error::out_of_range(Parameter::PrbsSeed, 0.0, mask as f32));
        }
        if seed == mask {
            return Err(ConfigError { parameter: Parameter::PrbsSeed, problem: ParameterProblem::LockUp });
        }
        Ok(Self { register: seed, mask, taps })
    }

    /// The register as it stands.
    pub const fn register(&self) -> u32 {
        self.register
    }

    /// Shifts once; the bit is the one that enters the register.
    // The bit stays a word until the end: kept as a `bool`, rustc 1.95 at opt-level 2 drops it from
    // the register where this is inlined into an iterator that chooses between two constants (test
    // `every_way_of_collecting_gives_the_same_bits`).
    #[inline]
    pub fn step(&mut self) -> bool {
        let bit = !(self.register & self.taps).count_ones() & 1;
        self.register = ((self.register << 1) | bit) & self.mask;
        bit == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_way_of_collecting_gives_the_same_bits() {
        let mut one_by_one = [0.0_f32; 200];
        let mut prbs = Prbs::new(10, 0).unwrap();
        for level in &mut one_by_one {
            core::hint::black_box(&mut prbs).step();
            *level = if prbs.register() & 1 == 1 { 0.0 } else { 1.0 };
        }
        let mut prbs = Prbs::new(10, 0).unwrap();
        let mut levels = (0..200).map(|_| if prbs.step() { 0.0_f32 } else { 1.0 });
        let collected = core::array::from_fn(|_| levels.next().unwrap());
        assert_eq!(one_by_one, collected);
        assert!(one_by_one.contains(&0.0) && one_by_one.contains(&1.0));
    }

    #[test]
    fn short_registers_visit_every_word_but_the_lock_up_one() {
        for order in 2..=20 {
            let mut prbs = Prbs::new(order, 0).unwrap();
            let (mut period, mut ones) = (0_u32, 0_u32);
            loop {
                ones += u32::from(prbs.step());
                period += 1;
                assert!(period >> order == 0, "order {order}: it never comes back");
                if prbs.register() == 0 {
                    break;
                }
            }
            assert_eq!(period, (1 << order) - 1, "order {order}");
            // A maximal XNOR sequence has one zero more than ones.
            assert_eq!(ones, (1 << (order - 1)) - 1, "order {order}");
        }
    }

    /// Product of two polynomials over GF(2) modulo x^n + taps (`low` = the polynomial without its
    /// leading term).
    fn multiply(a: u64, b: u64, order: u32, low: u64) -> u64 {
        (0..order).rev().fold(0, |acc, i| {
            let doubled = acc << 1;
            let reduced = if doubled >> order & 1 == 1 { (doubled & ((1 << order) - 1)) ^ low } else { doubled };
            if b >> i & 1 == 1 { reduced ^ a } else { reduced }
        })
    }

    fn power(mut exponent: u64, order: u32, low: u64) -> u64 {
        let (mut result, mut base) = (1, 2);
        while exponent > 0 {
            if exponent & 1 == 1 {
                result = multiply(result, base, order, low);
            }
            base = multiply(base, base, order, low);
            exponent >>= 1;
        }
        result
    }

    #[test]
    fn every_feedback_polynomial_is_primitive() {
        // x is of order 2^n − 1 in GF(2)[x]/p exactly if p is primitive, and then the register's
        // period is maximal.
        for order in 2..=32_u32 {
            let taps = u64::from(TAPS[order as usize - 2]);
            // Stage s feeds back: characteristic polynomial x^n + Σ x^(n−s), n − s = 0 for the
            // output stage.
            let low = (0..order).filter(|i| taps >> i & 1 == 1).fold(0, |p, i| p | 1 << (order - 1 - i));
            let period = (1_u64 << order) - 1;
            assert_eq!(power(period, order, low), 1, "order {order}");
            let (mut rest, mut factor) = (period, 2);
            while rest > 1 {
                if rest % factor == 0 {
                    // order 2 has period 3: 3/3 = 1 and x itself is not 1
                    assert_ne!(power(period / factor, order, low), 1, "order {order}, factor {factor}");
                    while rest % factor == 0 {
                        rest /= factor;
                    }
                }
                factor += 1;
                if factor * factor > rest && rest > 1 {
                    factor = rest;
                }
            }
        }
    }

    #[test]
    fn stages_are_counted_from_one() {
        assert_eq!(stages([0; 4]), 0);
        assert_eq!(stages([1, 0, 0, 0]), 1);
        assert_eq!(stages([32, 22, 2, 1]), 1 << 31 | 1 << 21 | 0b11);
        assert_eq!(stages([5, 3, 0, 0]), 0b10100);
    }

    #[test]
    fn follows_the_recurrence_by_hand() {
        // n = 3, taps 3 and 2, from 000: the bit is XNOR of the two high stages.
        let mut prbs = Prbs::new(3, 0).unwrap();
        let bits = core::array::from_fn::<bool, 7, _>(|_| prbs.step());
        assert_eq!(bits, [true, true, false, true, false, false, false]);
    }

    #[test]
    fn refuses_orders_and_seeds_that_cannot_run() {
        assert_eq!(Prbs::new(1, 0).unwrap_err().parameter, Parameter::PrbsOrder);
        assert_eq!(Prbs::new(33, 0).unwrap_err().parameter, Parameter::PrbsOrder);
        assert_eq!(Prbs::new(4, 0b1111).unwrap_err().problem, ParameterProblem::LockUp);
        assert_eq!(Prbs::new(32, u32::MAX).unwrap_err().problem, ParameterProblem::LockUp);
        assert_eq!(Prbs::new(4, 16).unwrap_err().parameter, Parameter::PrbsSeed);
    }
}
