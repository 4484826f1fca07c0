//! Spectra of turbulence as sums of relaxations.
//!
//! ```text
//! g(x) = ∫ ρ(t)/(t + x²) dt        ρ > 0, x = 2πf T
//! ```
//!
//! is exact for both shapes (Stieltjes), and 1/(t + x²) is the spectrum of an Ornstein–Uhlenbeck
//! process of rate √t/T:
//!
//! | shape | g | ρ |
//! |---|---|---|
//! | von Kármán | (1 + x²)^(−5/6) | (t − 1)^(−5/6)/2π, t > 1 |
//! | Kaimal | (1 + x)^(−5/3) | (1 + t)^(−5/6) sin(5/3 arctan √t)/π, t > 0 |
//!
//! With t = 1 + e^y or t = e^y the trapezoidal rule in y converges exponentially, and steps of 1.5
//! leave 10⁻⁴: three rates a decade of frequency are enough for a −5/3 that is straight.

use std::f64::consts::{PI, TAU};

/// Γ(1/3)/(√π Γ(5/6)): of von Kármán's spectrum, T U/L.
pub(super) const EDDY: f64 = 1.338_985_279_065_280_3;

/// Step of y.
const STEP: f64 = 1.5;
/// Below, the rates of von Kármán's spectrum are one: t = 1.
const VON_KARMAN_FROM: f64 = -4.5;
/// Below, Kaimal's has some 10⁻⁴ of its value at f = 0.
const KAIMAL_FROM: f64 = -18.0;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum SpectrumShape {
    VonKarman,
    Kaimal,
}

/// An Ornstein–Uhlenbeck process.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Relaxation {
    pub rate_rad_s: f64,
    pub variance: f64,
}

impl SpectrumShape {
    /// Relaxations of up to a rate whose spectra add up to unit variance.
    pub(super) fn relaxations(self, time_s: f64, highest_rad_s: f64) -> Vec<Relaxation> {
        // S(f) = S0 T Σ c/(t + x²), and a process has 4 ξ variance/(ξ² + ω²) with ξ = √t/T.
        let s0 = match self {
            Self::VonKarman => 4.0 / EDDY,
            Self::Kaimal => 2.0 / 3.0 * TAU,
        };
        let process = |(t, c): (f64, f64)| {
            let root = t.sqrt();
            Relaxation { rate_rad_s: root / time_s, variance: 0.25 * s0 * c / root }
        };
        let within = |relaxation: &Relaxation| relaxation.rate_rad_s <= highest_rad_s;
        let mut all: Vec<Relaxation> = self.slowest().into_iter().map(process).collect();
        all.extend((1..).map(|k| process(self.term(k))).take_while(within));
        all
    }

    /// t and what stands over t + x², of the k-th term.
    fn term(self, k: u32) -> (f64, f64) {
        match self {
            Self::VonKarman => {
                let y = VON_KARMAN_FROM + STEP * f64::from(k);
                (1.0 + libm::exp(y), STEP * libm::exp(y / 6.0) / TAU)
            }
            Self::Kaimal => {
                let t = libm::exp(KAIMAL_FROM + STEP * f64::from(k));
                (t, STEP * t * libm::pow(1.0 + t, -5.0 / 6.0) * libm::sin(5.0 / 3.0 * libm::atan(t.sqrt())) / PI)
            }
        }
    }

    /// The terms of k = 0, −1, −2 … as one: geometric sums of them and of their e^y.
    fn slowest(self) -> Option<(f64, f64)> {
        match self {
            Self::VonKarman => {
                let (_, c) = self.term(0);
                let rest = 1.0 - libm::exp(-STEP / 6.0);
                let mean = libm::exp(VON_KARMAN_FROM) * rest / (1.0 - libm::exp(-7.0 * STEP / 6.0));
                Some((1.0 + mean, c / rest))
            }
            Self::Kaimal => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relaxations_add_up_to_the_spectra() {
        let time_s = 0.7;
        for k in -30..=40 {
            // x from 10⁻³ to 10⁴, eddies of hours to those of a millisecond.
            let x = libm::pow(10.0, 0.1 * f64::from(k));
            for (shape, s0, g) in [
                (SpectrumShape::VonKarman, 4.0 / EDDY, libm::pow(1.0 + x * x, -5.0 / 6.0)),
                (SpectrumShape::Kaimal, 4.0 * PI / 3.0, libm::pow(1.0 + x, -5.0 / 3.0)),
            ] {
                let omega = x / time_s;
                let sum: f64 = (shape.relaxations(time_s, 1e9).iter())
                    .map(|one| 4.0 * one.rate_rad_s * one.variance / (one.rate_rad_s.powi(2) + omega * omega))
                    .sum();
                let error = sum / (s0 * time_s * g) - 1.0;
                assert!(error.abs() < 3e-4, "{shape:?} at {x}: {error}");
            }
        }
    }

    #[test]
    fn their_variances_add_up_to_one() {
        assert!((EDDY - libm::tgamma(1.0 / 3.0) / (PI.sqrt() * libm::tgamma(5.0 / 6.0))).abs() < 1e-12);
        for shape in [SpectrumShape::VonKarman, SpectrumShape::Kaimal] {
            let all = shape.relaxations(1.0, 1e12);
            let sum: f64 = all.iter().map(|one| one.variance).sum();
            // The part above a rate of 10¹² is some 10⁻⁸.
            assert!((sum - 1.0).abs() < 2e-4, "{shape:?}: {sum}");
            assert!(all.iter().all(|one| one.variance > 0.0), "a spectrum of each");
        }
        // Rates that matter at 1 kHz, eddies of a second.
        assert!(SpectrumShape::VonKarman.relaxations(1.0, 2e4).len() < 20);
    }
}
