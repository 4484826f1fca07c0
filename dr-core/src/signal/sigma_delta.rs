//! The first-order sigma-delta modulator: a stream of bits whose mean is a wanted number.
//!
//! u_{n+1} = u_n + δ − b_n,  b_n = sgn(u_n),  sgn(ρ) = 1 for ρ ≥ 0, else 0   (thesis 2.25)
//!
//! In the stationary regime u_n = (u_0 + (n−1)δ) mod 1 − 1 + δ (2.26) and b_n = δ + (u_0+(n−1)δ)
//! mod 1 − (u_0+nδ) mod 1 (2.27): the mean of b is δ, and after m bits their sum is within one of
//! mδ. Valid for 0 ≤ δ ≤ 1, which the caller checks; outside of it the accumulator would run away.

/// State of a modulator. At rest, u = 0.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SigmaDelta {
    /// u_n, in −1 … 1.
    pub accumulator: f32,
}

impl SigmaDelta {
    /// The next bit for a wanted mean `delta` in 0 … 1.
    #[inline]
    pub fn step(&mut self, delta: f32) -> bool {
        let bit = self.accumulator >= 0.0;
        self.accumulator += if bit { delta - 1.0 } else { delta };
        bit
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fractional part in 0 … 1 for any sign.
    fn modulo_1(value: f64) -> f64 {
        value - libm::floor(value)
    }

    #[test]
    fn follows_the_closed_form_of_the_thesis() {
        // Multiples of 2^-10 keep every sum exact in f32, so that (2.26) and (2.27) must hold to
        // the bit.
        for delta_1024 in [1_u32, 100, 341, 512, 777, 1023] {
            for start_1024 in [0_u32, 13, 500, 1000] {
                let delta = f64::from(delta_1024) / 1024.0;
                let u0 = f64::from(start_1024) / 1024.0 - 1.0 + delta; // anywhere in the stationary band [δ−1, δ)
                let mut modulator = SigmaDelta { accumulator: u0 as f32 };
                for n in 0..5000 {
                    let phase = |i: i32| modulo_1(u0 + f64::from(i) * delta);
                    // (2.26) is stated for a start that is itself a state of the regime
                    assert_eq!(f64::from(modulator.accumulator), phase(n - 1) - 1.0 + delta, "u, n {n}");
                    let bit = modulator.step(delta as f32);
                    assert_eq!(f64::from(u8::from(bit)), delta + phase(n - 1) - phase(n), "b, n {n}");
                }
            }
        }
    }

    #[test]
    fn the_sum_of_bits_stays_within_one_of_the_wanted_sum() {
        let delta = 0.123_456_7_f32;
        let mut modulator = SigmaDelta::default();
        let mut sum = 0_u32;
        for n in 1..=1_000_000 {
            sum += u32::from(modulator.step(delta));
            // rounding of u drifts by at most half an ulp of 1 a step
            assert!((f64::from(sum) - f64::from(n) * f64::from(delta)).abs() <= 1.0 + f64::from(n) * 6e-8);
        }
    }

    #[test]
    fn the_ends_of_the_range_are_constant() {
        let (mut zero, mut one) = (SigmaDelta { accumulator: -0.5 }, SigmaDelta::default());
        for _ in 0..100 {
            assert!(!zero.step(0.0));
            assert!(one.step(1.0));
        }
    }
}
