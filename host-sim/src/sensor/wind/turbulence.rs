//! Seeded turbulence: of one relaxation, or of the spectra of a boundary layer.
//!
//! One relaxation is the Ornstein–Uhlenbeck process,
//!
//! ```text
//! dx = −x dt/τ + √(2/τ) dW        x ← a x + √(1 − a²) n,  a = exp(−Ts/τ)
//! ```
//!
//! of unit variance in each component, sampled exactly, so that variance and correlation time do
//! not depend on the sample period. It starts in its stationary distribution and goes on from entry
//! to entry. Its spectrum falls as f⁻², that of real turbulence as f^(−5/3).
//!
//! The spectra are one-sided, ∫ S df = σ² over f > 0, and of frozen eddies that the mean U carries
//! past (Taylor): f = n U/L.
//!
//! ```text
//! von Kármán   S_u = 4σ² (L/U) (1 + (αn)²)^(−5/6)
//!              S_v = S_w = 2σ² (L/U) (1 + 8/3 (αn)²) (1 + (αn)²)^(−11/6)
//!              n = f L/U, α = 2π·1.339; L the longitudinal integral scale,
//!              of which isotropy makes a lateral one of L/2
//! Kaimal       S_k = 4σ_k² (L_k/U) (1 + 6 n_k)^(−5/3)
//!              n_k = f L_k/U, L_k = 5.67 z, 1.89 z, 0.462 z, σ_k = σ, 0.8 σ, 0.5 σ for k = u, v, w
//! ```
//!
//! with σ = intensity × U: u is along the mean, v horizontal across it, w the third. They are
//! independent, and held as means over each sample period (`series`), which is S sinc² (f Ts),
//! folded: 0.97 of S at a tenth of the sample rate, 0.71 to 1 up to half of it. Instants instead of
//! means would be folded to 2.9 times S there. Lower frequencies do not depend on it. They begin
//! anew with each entry, in their stationary distribution.
//!
//! Sources: von Kármán, Proc. Natl. Acad. Sci. 34 (1948) 530–539, in the form of ESDU 85020; Kaimal
//! et al., Q. J. R. Meteorol. Soc. 98 (1972) 563–589, in the form of IEC 61400-1, annex B, whose
//! scale is 0.7 z up to 60 m: flat ground, neutral stratification.
//!
//! Limits: none of the correlation between u and w that carries momentum to the ground; none of the
//! slow fluctuations that convection by day adds, on Mars even more than on Earth; −5/3 without an
//! end, where viscosity would end it. A mean that is slow against its fluctuations carries no
//! frozen eddies: intensities above 0.3 are beyond what Taylor's hypothesis is good for.

use diffusive::random::StandardNormal;
use rand_chacha::ChaCha8Rng;
use rand_distr::Distribution;

use super::planned::EntryTable;
use super::relaxations::{EDDY, SpectrumShape};
use crate::sensor::error::SensorError;

/// Random fluctuations about a mean wind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turbulence {
    /// Standard deviation over the mean speed: of each component, of Kaimal's along the mean.
    pub intensity: f64,
    /// Spread over frequencies.
    pub spectrum: Spectrum,
}

/// Spread of turbulence over frequencies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spectrum {
    /// Rate of one relaxation.
    Relaxation {
        /// Correlation time, s.
        correlation_time_s: f64,
    },
    /// Isotropic; the longitudinal integral scale.
    VonKarman {
        /// Longitudinal integral scale, m.
        length_m: f64,
    },
    /// Over ground; the sensor's height.
    Kaimal {
        /// Height of the sensor above ground, m.
        height_m: f64,
    },
}

/// Turbulence of one relaxation at a sample period.
#[derive(Clone, Copy, Debug)]
pub(super) struct Relaxed {
    deviation_m_s: f64,
    /// a and √(1 − a²) of one sample period.
    memory: f64,
    renewal: f64,
}

impl Relaxed {
    /// Adds the present x and lets a period pass.
    pub(super) fn add(&self, wind_m_s: &mut [f64; 3], x: &mut [f64; 3], rng: &mut ChaCha8Rng) {
        for (wind, x) in wind_m_s.iter_mut().zip(x) {
            *wind += self.deviation_m_s * *x;
            let normal: f64 = StandardNormal.sample(rng);
            *x = self.memory * *x + self.renewal * normal;
        }
    }
}

/// x of the beginning.
pub(super) fn at_rest_in_distribution(rng: &mut ChaCha8Rng) -> [f64; 3] {
    std::array::from_fn(|_| StandardNormal.sample(rng))
}

/// One component of a spectrum's turbulence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Component {
    pub shape: SpectrumShape,
    pub deviation_m_s: f64,
    /// T: the spectrum is a function of 2πf T.
    pub time_s: f64,
    /// Across the mean in isotropic turbulence.
    pub across: bool,
}

impl Turbulence {
    /// At a mean speed, if it is of one relaxation and there is any.
    pub(super) fn relaxed(&self, speed_m_s: f64, sample_period_s: f64) -> Option<Relaxed> {
        let Spectrum::Relaxation { correlation_time_s } = self.spectrum else { return None };
        let (deviation_m_s, memory) = (self.intensity * speed_m_s, libm::exp(-sample_period_s / correlation_time_s));
        let renewal = (1.0 - memory * memory).sqrt();
        (deviation_m_s != 0.0).then_some(Relaxed { deviation_m_s, memory, renewal })
    }

    /// Along the mean, horizontal across it, and the third, if it is of another spectrum and there
    /// is any.
    pub(super) fn components(&self, speed_m_s: f64) -> Option<[Component; 3]> {
        let deviation_m_s = self.intensity * speed_m_s;
        if deviation_m_s == 0.0 {
            return None;
        }
        match self.spectrum {
            Spectrum::Relaxation { .. } => None,
            Spectrum::VonKarman { length_m } => Some([false, true, true].map(|across| Component {
                shape: SpectrumShape::VonKarman,
                deviation_m_s,
                time_s: EDDY * length_m / speed_m_s,
                across,
            })),
            Spectrum::Kaimal { height_m } => Some([(1.0, 8.1), (0.8, 2.7), (0.5, 0.66)].map(|(part, length)| {
                let length_m = length * 0.7 * height_m;
                Component {
                    shape: SpectrumShape::Kaimal,
                    deviation_m_s: part * deviation_m_s,
                    time_s: 6.0 * length_m / (std::f64::consts::TAU * speed_m_s),
                    across: false,
                }
            })),
        }
    }

    pub(super) fn check(&self, entry: usize, speed_m_s: f64, sample_period_s: f64) -> Result<(), SensorError> {
        let (table, intensity) = (EntryTable { entry, name: "turbulence" }, self.intensity);
        let share = (0.0..=1.0).contains(&intensity);
        table.require(share, "intensity", intensity, "0 to 1, a fraction of the mean speed")?;
        match self.spectrum {
            Spectrum::Relaxation { correlation_time_s: time_s } => {
                table.require(time_s.is_finite() && time_s > 0.0, "correlation_time_s", time_s, "more than 0")
            }
            Spectrum::VonKarman { length_m } => {
                let expected = "more than 0, and no less than the mean wind goes in five sample periods";
                let right = length_m.is_finite() && length_m > 0.0 && length_m >= 5.0 * sample_period_s * speed_m_s;
                table.require(right, "length_m", length_m, expected)
            }
            Spectrum::Kaimal { height_m } => {
                let expected = "more than 0 and at most 60, above which eddies do not grow with it";
                table.require(height_m > 0.0 && height_m <= 60.0, "height_m", height_m, expected)
            }
        }
    }
}
